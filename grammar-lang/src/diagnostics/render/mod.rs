//! Renderers: the same findings for people and for programs. One file each.

pub mod ariadne;
pub mod concise;
pub mod json;

use super::Diagnostic;
use crate::source::SourceMap;

/// How findings are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// With the text around them.
    #[default]
    Full,
    /// One line each.
    Concise,
    /// One JSON object each, a line each.
    Json,
}

/// Writes findings, in the order of files and places.
#[must_use]
pub fn render(diagnostics: &[Diagnostic], sources: &SourceMap, format: Format, colour: bool) -> String {
    let mut sorted: Vec<&Diagnostic> = diagnostics.iter().collect();
    sorted.sort_by_key(|d| (d.span().file, d.span().start, d.code.id));
    sorted
        .into_iter()
        .map(|d| match format {
            Format::Full => ariadne::render(d, sources, colour),
            Format::Concise => concise::render(d, sources),
            Format::Json => json::render(d, sources),
        })
        .collect()
}
