//! Findings with the text around them. The only place that names ariadne.

use ariadne::{Cache, CharSet, Color, Config, IndexType, Label, Report, ReportKind};

use crate::diagnostics::{Diagnostic, Severity};
use crate::source::{SourceMap, Span};

/// The longest line that is drawn, in bytes: no terminal has room for more.
const LONGEST_LINE: usize = 2000;

/// Writes one finding; in one line if the text around it cannot be drawn.
#[must_use]
pub fn render(diagnostic: &Diagnostic, sources: &SourceMap, colour: bool) -> String {
    render_all([diagnostic], sources, colour)
}

/// Writes findings, one after the other; the texts are taken apart only once.
pub(super) fn render_all<'d>(
    diagnostics: impl IntoIterator<Item = &'d Diagnostic>,
    sources: &SourceMap,
    colour: bool,
) -> String {
    let texts = sources.iter().map(|(_, s)| (s.name.clone(), s.text.as_str()));
    let mut cache = ariadne::sources(texts);
    diagnostics.into_iter().map(|d| one(d, sources, colour, &mut cache)).collect()
}

fn one(diagnostic: &Diagnostic, sources: &SourceMap, colour: bool, cache: impl Cache<String>) -> String {
    if diagnostic.labels.iter().any(|l| sources.line_length(l.span) > LONGEST_LINE) {
        return super::concise::render(diagnostic, sources);
    }
    let name = |file| sources.get(file).map_or_else(String::new, |s| s.name.clone());
    let (kind, tint) = match diagnostic.code.severity {
        Severity::Error => (ReportKind::Error, Color::Red),
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
    };
    let main = diagnostic.span();
    // ariadne says where a second text is in characters, whatever its spans are counted in.
    let config =
        Config::default().with_color(colour).with_index_type(IndexType::Char).with_char_set(CharSet::Unicode);
    let mut report = Report::build(kind, (name(main.file), characters(main, sources)))
        .with_config(config)
        .with_code(diagnostic.code.id)
        .with_message(&diagnostic.message);
    let mut labels: Vec<_> = diagnostic.labels.iter().enumerate().collect();
    // ariadne opens another excerpt, with the place of the first, when a label lies above the one
    // before it: so they come in the order of the text, those of the main file first.
    labels.sort_by_key(|(_, l)| (l.span.file != main.file, l.span));
    for (i, label) in labels {
        let text = if label.text.is_empty() { "here" } else { &label.text };
        report = report.with_label(
            Label::new((name(label.span.file), characters(label.span, sources)))
                .with_message(text)
                .with_color(if i == 0 { tint } else { Color::Blue }),
        );
    }
    if let Some(help) = &diagnostic.help {
        report = report.with_help(help);
    }
    let mut out = Vec::new();
    // A finding that cannot be drawn is still told, in one line.
    match report.finish().write(cache, &mut out) {
        Ok(()) => String::from_utf8_lossy(&out).into_owned(),
        Err(_) => super::concise::render(diagnostic, sources),
    }
}

/// A span in characters. A place within a character is widened to the whole of it.
fn characters(span: Span, sources: &SourceMap) -> std::ops::Range<usize> {
    let text = sources.get(span.file).map_or("", |s| s.text.as_str());
    let mut start = span.range().start.min(text.len());
    let mut end = span.range().end.clamp(start, text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    while !text.is_char_boundary(end) {
        end += 1;
    }
    sources.characters_before(span.file, start)..sources.characters_before(span.file, end)
}
