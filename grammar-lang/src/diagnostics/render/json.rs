//! Findings as JSON, one object a line.

use serde::Serialize;

use super::place::LineColumn;
use crate::diagnostics::{Diagnostic, Fix};
use crate::source::SourceMap;

#[derive(Serialize)]
struct Finding<'a> {
    code: &'a str,
    name: &'a str,
    severity: &'a str,
    message: &'a str,
    labels: Vec<Label<'a>>,
    help: Option<&'a str>,
    fix: Option<Mend<'a>>,
}

#[derive(Serialize)]
struct Label<'a> {
    #[serde(flatten)]
    place: LineColumn<'a>,
    text: &'a str,
}

#[derive(Serialize)]
struct Mend<'a> {
    message: &'a str,
    edits: Vec<Replacement<'a>>,
}

#[derive(Serialize)]
struct Replacement<'a> {
    #[serde(flatten)]
    place: LineColumn<'a>,
    replacement: &'a str,
}

fn mend<'a>(fix: &'a Fix, sources: &'a SourceMap) -> Mend<'a> {
    let edits = fix
        .edits
        .iter()
        .map(|e| Replacement { place: LineColumn::of(e.span, sources), replacement: &e.replacement })
        .collect();
    Mend { message: &fix.message, edits }
}

/// Writes one finding.
#[must_use]
pub fn render(diagnostic: &Diagnostic, sources: &SourceMap) -> String {
    let labels = diagnostic
        .labels
        .iter()
        .map(|l| Label { place: LineColumn::of(l.span, sources), text: &l.text })
        .collect();
    let finding = Finding {
        code: diagnostic.code.id,
        name: diagnostic.code.name,
        severity: diagnostic.code.severity.name(),
        message: &diagnostic.message,
        labels,
        help: diagnostic.help.as_deref(),
        fix: diagnostic.fix.as_ref().map(|fix| mend(fix, sources)),
    };
    // Plain strings and numbers always serialise.
    serde_json::to_string(&finding).unwrap_or_default() + "\n"
}
