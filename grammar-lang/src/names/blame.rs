//! Adds to findings what only the whole program knows: that a variant has changed what they are
//! about, and which module of the library declares a name that is missing.

use std::collections::BTreeMap;

use crate::diagnostics::{Code, Diagnostic};
use crate::source::{FileId, Loader, SourceMap, Span};
use crate::syntax;

use super::{Declaration, declared};

/// What helps where nothing else is known about a name.
pub(crate) const UNDECLARED: &str = "declare it, or import it with `use`";

/// How the help begins where the library has a name.
const IMPORT: &str = "import it:";

/// What the labels say where a name is not known, or a thing has nothing of that name.
const ABSENT: &[&str] = &["not declared", "not an attribute", "not a parameter", "no such name in the rule"];

/// One edit of a variant.
#[derive(Clone, Debug)]
pub struct Change {
    /// The words of what it changes: `grow`, `n`.
    pub(super) path: Vec<String>,
    /// Where the variant says so.
    pub(crate) place: Span,
    /// The declaration that it changes.
    pub(super) target: Span,
    /// What the variant is called.
    pub(crate) variant: String,
    /// The declaration, if it changes a part of it and does not replace it.
    pub(crate) edited: Option<Declaration>,
}

/// Whether a text has this word.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|w| w == word)
}

impl Change {
    /// The name whose value it sets, if it changes a whole parameter.
    #[must_use]
    pub fn sets(&self) -> Option<&str> {
        match self.path.as_slice() {
            [name] if self.edited.is_some() => Some(name),
            _ => None,
        }
    }

    /// Where the variant says so, and what the variant is called.
    #[must_use]
    pub fn source(&self) -> (Span, &str) {
        (self.place, &self.variant)
    }
}

pub(super) fn within(inner: Span, outer: Span) -> bool {
    inner.file == outer.file && inner.start >= outer.start && inner.end <= outer.end
}

/// How many edits findings are compared with, and how long a text is that is looked through: each
/// finding is compared with each edit.
const MOST: usize = 1_000;

/// Shows the edits of variants that a finding is about, unless it stands there.
#[must_use]
pub fn with_changes(mut finding: Diagnostic, changes: &[Change], sources: &SourceMap) -> Diagnostic {
    for change in changes.iter().take(MOST) {
        let shown = |d: &Diagnostic| d.labels.iter().any(|l| within(l.span, change.place));
        let about = finding.labels.iter().any(|label| {
            let text = Some(sources.slice(label.span)).filter(|t| t.len() <= MOST).unwrap_or_default();
            let (head, rest) = (change.path.first(), change.path.last().filter(|_| change.path.len() > 1));
            match rest {
                // A part of a declaration: the finding is about that part, or about the declaration.
                Some(last) => {
                    let named = head.is_some_and(|h| text == h.as_str());
                    within(label.span, change.target) && (named || has_word(text, last))
                }
                None => head.is_some_and(|h| has_word(text, h)),
            }
        });
        if about && !shown(&finding) {
            finding = finding.also(change.place, format!("changed here by the variant `{}`", change.variant));
        }
    }
    finding
}

/// Whether a finding is about a name that is not known.
fn undeclared(finding: &Diagnostic) -> bool {
    finding.code == Code::UNKNOWN_NAME && finding.labels.first().is_some_and(|l| l.text == "not declared")
}

/// Tells once what is not known at several places of a text: one declaration mends them all. What
/// a program can mend is told at each place, for it to do so.
pub(crate) fn told_once(findings: &mut Vec<Diagnostic>) {
    let one_mends_all = |d: &Diagnostic| {
        let absent = d.labels.first().is_some_and(|l| ABSENT.iter().any(|absent| l.text.starts_with(absent)));
        d.fix.is_none() && absent
    };
    let key = |d: &Diagnostic| (d.span().file, d.message.clone());
    let mut places: BTreeMap<_, usize> = BTreeMap::new();
    findings.retain(|d| {
        let count = if one_mends_all(d) { places.entry(key(d)).or_default() } else { &mut 0 };
        *count += 1;
        *count == 1
    });
    for finding in findings.iter_mut().filter(|d| one_mends_all(d)) {
        let more = places.get(&key(finding)).map_or(0, |count| count - 1);
        if let (1.., Some(label)) = (more, finding.labels.first_mut()) {
            let places = if more == 1 { "place" } else { "places" };
            label.text.push_str(&format!(", here and at {more} more {places}"));
        }
    }
}

/// Says which module of the library declares a name that is not known.
pub(crate) fn with_imports(findings: &mut [Diagnostic], loader: &dyn Loader, sources: &SourceMap) {
    let mut library: Option<Vec<(String, Vec<String>)>> = None;
    for finding in findings {
        if !undeclared(finding) {
            continue;
        }
        let word = sources.slice(finding.span());
        let library = library.get_or_insert_with(|| declarations(loader));
        if let Some((module, _)) = library.iter().find(|(_, names)| names.iter().any(|n| n == word)) {
            // The very name is nearer than one that resembles it.
            finding.help = Some(format!("{IMPORT} `use {module} {{ {word} }}`"));
            finding.fix = None;
        }
    }
}

/// What each module of the library declares.
fn declarations(loader: &dyn Loader) -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    for module in loader.library() {
        let Ok(source) = loader.load(&module, "") else { continue };
        let mut texts = SourceMap::default();
        let file: FileId = texts.add(source.name, source.text);
        let (tree, _) = syntax::parse(&texts, file);
        let names = tree.items.iter().filter_map(|i| declared(i).map(|n| n.text.clone())).collect();
        found.push((module, names));
    }
    found
}
