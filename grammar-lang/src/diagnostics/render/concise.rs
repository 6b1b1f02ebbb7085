//! Findings in one line each: `file:line:column: error[E0301] message`.

use crate::diagnostics::Diagnostic;
use crate::source::SourceMap;

/// How long a help may be to stand on the line: lists of all that is known are longer.
const LONGEST: usize = 160;

/// Writes one finding.
#[must_use]
pub fn render(diagnostic: &Diagnostic, sources: &SourceMap) -> String {
    let span = diagnostic.span();
    let (line, column) = sources.line_column(span);
    let name = sources.get(span.file).map_or("", |s| s.name.as_str());
    let severity = diagnostic.code.severity.name();
    let help = diagnostic.help.as_deref().map(first_of).filter(|h| h.len() <= LONGEST);
    let help = help.map_or(String::new(), |h| format!("; help: {h}"));
    // A note that names or counts something says more than the message.
    let note = diagnostic.labels.first().map_or("", |l| l.text.as_str());
    let tells = note.contains(|c: char| c.is_ascii_digit() || c == '`') && !diagnostic.message.contains(note);
    let note = if tells { format!(": {note}") } else { String::new() };
    format!("{name}:{line}:{column}: {severity}[{}] {}{note}{help}\n", diagnostic.code.id, diagnostic.message)
}

/// A help, or the first of its sentences if all of them are too long.
fn first_of(help: &str) -> &str {
    if help.len() <= LONGEST { help } else { help.split_once(". ").map_or(help, |(first, _)| first) }
}

#[cfg(test)]
mod tests {
    use super::first_of;

    #[test]
    fn of_a_long_help_the_first_sentence_is_shown() {
        let long = format!("write `1/240 s`. {}", "Then more. ".repeat(30));
        assert_eq!(first_of(&long), "write `1/240 s`");
        assert_eq!(first_of("write this. Or that"), "write this. Or that");
    }
}
