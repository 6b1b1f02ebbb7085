//! Renderers: the same findings for people and for programs. One file each.

pub mod ariadne;
pub mod concise;
pub mod json;
mod place;
pub mod sarif;

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
    /// One SARIF document for all.
    Sarif,
}

/// The findings in the order of files and places.
fn sorted(diagnostics: &[Diagnostic]) -> Vec<&Diagnostic> {
    let mut sorted: Vec<&Diagnostic> = diagnostics.iter().collect();
    sorted.sort_by_key(|d| (d.span().file, d.span().start, d.code.id));
    sorted
}

/// How many findings are drawn: nobody reads more, and each takes its time.
const MOST: usize = 500;

/// Draws findings, and says how many more there are.
fn drawn(diagnostics: &[&Diagnostic], sources: &SourceMap, colour: bool) -> String {
    let mut out = ariadne::render_all(diagnostics.iter().take(MOST).copied(), sources, colour);
    if let Some(more) = diagnostics.len().checked_sub(MOST).filter(|n| *n > 0) {
        out += &format!("and {more} more: these are the first {MOST}\n");
    }
    out
}

/// Writes findings, in the order of files and places.
#[must_use]
pub fn render(diagnostics: &[Diagnostic], sources: &SourceMap, format: Format, colour: bool) -> String {
    let one = |d| match format {
        Format::Concise => concise::render(d, sources),
        Format::Json => json::render(d, sources),
        Format::Full | Format::Sarif => String::new(),
    };
    match format {
        Format::Sarif => sarif::render(&[(diagnostics, sources)]),
        Format::Full => drawn(&sorted(diagnostics), sources, colour),
        _ => sorted(diagnostics).into_iter().map(one).collect(),
    }
}

/// A line that says where findings are explained; empty if there are none.
#[must_use]
pub fn more<'a>(diagnostics: impl IntoIterator<Item = &'a Diagnostic>) -> String {
    let codes: std::collections::BTreeSet<&str> = diagnostics.into_iter().map(|d| d.code.id).collect();
    let codes: Vec<&str> = codes.into_iter().collect();
    match codes.as_slice() {
        [] => String::new(),
        [one] => format!("for more: sgc explain {one}\n"),
        [first, ..] => format!("for more about {}: sgc explain {first}\n", codes.join(", ")),
    }
}
