//! Warnings that a text allows, with a reason: `allow CODE because TEXT`.
//!
//! In a declaration it holds for what is found there, outside of all declarations, or in a variant, for what is found anywhere in the
//! grammar; outside of the declarations of a module for what is found in that text.

use std::cell::Cell;

use crate::diagnostics::{CODES, Code, Diagnostic, Severity, did_you_mean, find, respell};
use crate::source::{FileId, Span};
use crate::syntax::ast::{Allow, Name};

use super::Program;
use super::blame::within;

/// Where a warning is allowed.
#[derive(Clone, Copy, Debug)]
enum Reach {
    /// In a declaration.
    Declaration(Span),
    /// In a text.
    Text(FileId),
    /// In all of the grammar.
    Grammar,
}

/// One allowed warning.
#[derive(Debug)]
struct One {
    code: &'static Code,
    place: Span,
    reach: Reach,
    /// Whether there was such a warning.
    is_used: Cell<bool>,
}

impl One {
    fn is_about(&self, finding: &Diagnostic) -> bool {
        let here = finding.span();
        self.code == finding.code
            && match self.reach {
                Reach::Declaration(span) => within(here, span),
                Reach::Text(file) => here.file == file,
                Reach::Grammar => true,
            }
    }
}

/// The warnings that a program allows.
#[derive(Debug, Default)]
pub struct Allowed(Vec<One>);

impl Allowed {
    /// What the texts of a program allow. Reports codes that are none, and those of errors.
    pub(crate) fn of(program: &Program, found: &mut Vec<Diagnostic>) -> Self {
        let in_texts = program.modules.iter().enumerate().flat_map(|(place, module)| {
            let own = if program.own.contains(&place) { Reach::Grammar } else { Reach::Text(module.file) };
            let reach = move |allow: &Allow| allow.within.map_or(own, Reach::Declaration);
            module.tree.allows.iter().map(move |allow| (allow, reach(allow)))
        });
        let in_variants = program.allows.iter().map(|allow| (allow, Reach::Grammar));
        let mut all = Vec::new();
        for (allow, reach) in in_texts.chain(in_variants) {
            if allow.because.as_ref().is_none_or(|reason| reason.trim().is_empty()) {
                found.push(without_reason(allow));
            }
            match warning(&allow.code) {
                Ok(code) => all.push(One { code, place: allow.span, reach, is_used: Cell::new(false) }),
                Err(error) => found.push(*error),
            }
        }
        Self(all)
    }

    /// Takes the warnings out that are allowed.
    pub fn hush(&self, findings: &mut Vec<Diagnostic>) {
        findings.retain(|finding| {
            let mut is_told = true;
            for one in self.0.iter().filter(|one| one.is_about(finding)) {
                one.is_used.set(true);
                is_told = false;
            }
            is_told
        });
    }

    /// Warns of what is allowed in a text without need, once everything has been found.
    pub fn unused(&self, text: FileId) -> impl Iterator<Item = Diagnostic> {
        let unused = self.0.iter().filter(move |one| one.place.file == text && !one.is_used.get());
        unused.map(|one| {
            let message = format!("this `allow {}` silences nothing", one.code.id);
            Diagnostic::new(Code::UNUSED_ALLOW, one.place, message)
                .label(format!("nothing here causes the warning {}", one.code.name))
                .help("remove it, or move it into the declaration that the warning is about")
        })
    }
}

/// The warning that is allowed.
fn warning(name: &Name) -> Result<&'static Code, Box<Diagnostic>> {
    let warnings = || CODES.iter().filter(|code| code.severity == Severity::Warning);
    match find(&name.text) {
        Some(code) if code.severity == Severity::Warning => Ok(code),
        Some(code) => Err(Box::new(
            Diagnostic::new(
                Code::BAD_VALUE,
                name.span,
                format!("{} is an error, and cannot be allowed", code.id),
            )
            .label(code.name)
            .help(format!("correct the error: `sgc explain {}` says how", code.id)),
        )),
        None => {
            let names = || warnings().flat_map(|code| [code.id, code.name]);
            let help = did_you_mean(&name.text, names());
            let error = Diagnostic::new(
                Code::UNKNOWN_NAME,
                name.span,
                format!("there is no warning `{}`", name.text),
            )
            .label("not known")
            .help(help.unwrap_or_else(|| {
                "write the code that the warning begins with, as in `allow W0725 because \"...\"`".to_owned()
            }))
            .fix_if(respell(name.span, &name.text, names()));
            Err(Box::new(error))
        }
    }
}

/// Who reads the text later has to know why.
fn without_reason(allow: &Allow) -> Diagnostic {
    let end = Span { start: allow.span.end, ..allow.span };
    Diagnostic::new(Code::MISSING_FIELD, end, "`allow` needs a reason")
        .label("`because` is missing")
        .help(format!("write `allow {} because \"...\"`", allow.code.text))
}
