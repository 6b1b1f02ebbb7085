//! Adds to findings what only the whole program knows: that a variant has changed what they are
//! about, and which module of the library declares a name that is missing.

use crate::diagnostics::{Code, Diagnostic};
use crate::source::{FileId, SourceMap, Span, World};
use crate::syntax;

use super::declared;

/// What helps where nothing else is known about a name.
pub(crate) const UNDECLARED: &str = "declare it, or import it with `use`";

/// One edit of a variant.
#[derive(Clone, Debug)]
pub struct Change {
    /// The words of what it changes: `grow`, `n`.
    pub(super) path: Vec<String>,
    /// Where the variant says so.
    pub(super) place: Span,
    /// The declaration that it changes.
    pub(super) target: Span,
    /// What the variant is called.
    pub(super) variant: String,
}

/// Whether a text has this word.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|w| w == word)
}

fn within(inner: Span, outer: Span) -> bool {
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

/// Says which module of the library declares a name that is not known.
pub(crate) fn with_imports(findings: &mut [Diagnostic], world: &dyn World, sources: &SourceMap) {
    let mut library: Option<Vec<(String, Vec<String>)>> = None;
    for finding in findings {
        let undeclared = finding.labels.first().is_some_and(|l| l.text == "not declared");
        if finding.code != Code::UNKNOWN_NAME || !undeclared {
            continue;
        }
        let word = sources.slice(finding.span());
        let library = library.get_or_insert_with(|| declarations(world));
        if let Some((module, _)) = library.iter().find(|(_, names)| names.iter().any(|n| n == word)) {
            // The very name is nearer than one that resembles it.
            finding.help = Some(format!("import it: `use {module} {{ {word} }}`"));
            finding.fix = None;
        }
    }
}

/// What each module of the library declares.
fn declarations(world: &dyn World) -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    for module in world.library() {
        let Ok(source) = world.load(&module, "") else { continue };
        let mut texts = SourceMap::default();
        let file: FileId = texts.add(source.name, source.text);
        let (tree, _) = syntax::parse(&texts, file);
        let names = tree.items.iter().filter_map(|i| declared(i).map(|n| n.text.clone())).collect();
        found.push((module, names));
    }
    found
}
