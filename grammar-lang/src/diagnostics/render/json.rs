//! Findings as JSON, one object a line.

use serde::Serialize;

use crate::diagnostics::{Diagnostic, Severity};
use crate::source::{SourceMap, Span};

#[derive(Serialize)]
struct Finding<'a> {
    code: &'a str,
    name: &'a str,
    severity: &'a str,
    message: &'a str,
    labels: Vec<Place<'a>>,
    help: Option<&'a str>,
}

#[derive(Serialize)]
struct Place<'a> {
    file: &'a str,
    line: usize,
    column: usize,
    start: u32,
    end: u32,
    text: &'a str,
}

/// Writes one finding.
#[must_use]
pub fn render(diagnostic: &Diagnostic, sources: &SourceMap) -> String {
    let place = |span: Span| {
        let (line, column) = sources.line_column(span);
        (sources.get(span.file).map_or("", |s| s.name.as_str()), line, column)
    };
    let labels = diagnostic
        .labels
        .iter()
        .map(|l| {
            let (file, line, column) = place(l.span);
            Place { file, line, column, start: l.span.start, end: l.span.end, text: &l.text }
        })
        .collect();
    let finding = Finding {
        code: diagnostic.code.id,
        name: diagnostic.code.name,
        severity: match diagnostic.code.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        },
        message: &diagnostic.message,
        labels,
        help: diagnostic.help.as_deref(),
    };
    // Plain strings and numbers always serialise.
    serde_json::to_string(&finding).unwrap_or_default() + "\n"
}
