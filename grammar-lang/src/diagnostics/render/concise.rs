//! Findings in one line each: `file:line:column: error[E0301] message`.

use crate::diagnostics::Diagnostic;
use crate::source::SourceMap;

/// Writes one finding.
#[must_use]
pub fn render(diagnostic: &Diagnostic, sources: &SourceMap) -> String {
    let span = diagnostic.span();
    let (line, column) = sources.line_column(span);
    let name = sources.get(span.file).map_or("", |s| s.name.as_str());
    let severity = diagnostic.code.severity.name();
    let help = diagnostic.help.as_ref().map_or(String::new(), |h| format!("; help: {h}"));
    format!("{name}:{line}:{column}: {severity}[{}] {}{help}\n", diagnostic.code.id, diagnostic.message)
}
