//! Findings with the text around them. The only place that names ariadne.

use ariadne::{CharSet, Color, Config, IndexType, Label, Report, ReportKind};

use crate::diagnostics::{Diagnostic, Severity};
use crate::source::SourceMap;

/// Writes one finding.
#[must_use]
pub fn render(diagnostic: &Diagnostic, sources: &SourceMap, colour: bool) -> String {
    let name = |file| sources.get(file).map_or_else(String::new, |s| s.name.clone());
    let (kind, tint) = match diagnostic.code.severity {
        Severity::Error => (ReportKind::Error, Color::Red),
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
    };
    let main = diagnostic.span();
    // A place within a character would not be drawn: widen it to the whole of it.
    let range = |span: crate::source::Span| {
        let text = sources.get(span.file).map_or("", |s| s.text.as_str());
        let range = span.range();
        let mut start = range.start.min(text.len());
        let mut end = range.end.clamp(start, text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        while !text.is_char_boundary(end) {
            end += 1;
        }
        start..end
    };
    let config =
        Config::default().with_color(colour).with_index_type(IndexType::Byte).with_char_set(CharSet::Unicode);
    let mut report = Report::build(kind, (name(main.file), range(main)))
        .with_config(config)
        .with_code(diagnostic.code.id)
        .with_message(&diagnostic.message);
    for (i, label) in diagnostic.labels.iter().enumerate() {
        let text = if label.text.is_empty() { "here" } else { &label.text };
        report =
            report.with_label(
                Label::new((name(label.span.file), range(label.span)))
                    .with_message(text)
                    .with_color(if i == 0 { tint } else { Color::Blue }),
            );
    }
    if let Some(help) = &diagnostic.help {
        report = report.with_help(help);
    }
    let mut out = Vec::new();
    let texts = sources.iter().map(|(_, s)| (s.name.clone(), s.text.clone()));
    // A finding that cannot be drawn is still told, in one line.
    match report.finish().write(ariadne::sources(texts), &mut out) {
        Ok(()) => String::from_utf8_lossy(&out).into_owned(),
        Err(_) => super::concise::render(diagnostic, sources),
    }
}
