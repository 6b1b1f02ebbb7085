//! Invisible characters and texts that are not closed: found before parsing, because the parser
//! would stumble over them much later, or over what nobody can see.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use super::tokens::{Scan, Token, TokenKind};
use crate::diagnostics::{Code, Diagnostic, Fix};
use crate::source::{FileId, Span};

/// A text as the parser should read it.
pub(super) struct Cleaned<'a> {
    /// Of the same length as the text, up to its end, so that places do not move.
    pub(super) text: Cow<'a, str>,
    /// What was found.
    pub(super) errors: Vec<Diagnostic>,
    /// Where texts were closed by force: what the parser finds wrong there is an echo.
    open: Vec<RangeInclusive<usize>>,
}

impl Cleaned<'_> {
    /// Whether a finding of the parser only repeats that a text is open.
    pub(super) fn is_echo(&self, error: &Diagnostic) -> bool {
        // They come in the order of the text, and at most touch each other.
        let place = error.span().range().start;
        let begun = self.open.partition_point(|open| *open.start() <= place);
        begun.checked_sub(1).and_then(|i| self.open.get(i)).is_some_and(|open| open.contains(&place))
    }
}

/// Takes out what the parser should not see.
pub(super) fn cleaned<'a>(scan: &Scan<'a>, file: FileId) -> Cleaned<'a> {
    let text = scan.text;
    let found: Vec<Strange> = scan.tokens().iter().flat_map(strange).collect();
    if found.is_empty() {
        return Cleaned { text: Cow::Borrowed(text), errors: Vec::new(), open: Vec::new() };
    }
    let open = found.iter().filter_map(|s| match s.kind {
        Kind::OpenText { quote } => Some(quote..=s.start + 1),
        _ => None,
    });
    let open = open.collect();
    let mut clean = String::with_capacity(text.len() + 1);
    let mut errors = Vec::new();
    let mut done = 0;
    for strange in &found {
        clean.push_str(text.get(done..strange.start).unwrap_or(""));
        // What follows keeps its place: findings about it are about the text as it was written.
        clean.push_str(&strange.stand_in.repeat(strange.end - strange.start));
        done = strange.end;
        errors.push(strange.diagnostic(text, file));
    }
    clean.push_str(text.get(done..).unwrap_or(""));
    Cleaned { text: Cow::Owned(clean), errors, open }
}

/// Something strange, and what the parser reads in its place.
struct Strange {
    kind: Kind,
    start: usize,
    end: usize,
    stand_in: &'static str,
}

enum Kind {
    /// A character that is a blank to the eye.
    Blank(char),
    /// A character that the eye does not see at all.
    Nothing(char),
    /// A text whose quote, at this place, is not closed on its line.
    OpenText { quote: usize },
}

/// Blanks that the language does not know, such as the no-break space.
fn is_blank(c: char) -> bool {
    (c.is_whitespace() || c.is_control()) && !matches!(c, ' ' | '\t' | '\r' | '\n')
}

/// Characters without width.
fn is_nothing(c: char) -> bool {
    matches!(c, '\u{AD}' | '\u{61C}' | '\u{180E}' | '\u{200B}'..='\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2060}'..='\u{2069}')
}

/// What is strange about a token; invisible characters within a comment or a text in quotes are its own.
fn strange(token: &Token<'_>) -> Vec<Strange> {
    let invisible = |(place, c): (usize, char)| {
        let kind = match c {
            c if is_blank(c) => Kind::Blank(c),
            c if is_nothing(c) => Kind::Nothing(c),
            _ => return None,
        };
        let start = token.start + place;
        Some(Strange { kind, start, end: start + c.len_utf8(), stand_in: " " })
    };
    match token.kind {
        TokenKind::Text { closed: false } => {
            let end = token.end();
            // The quote takes the place of the end of the line.
            vec![Strange {
                kind: Kind::OpenText { quote: token.start },
                start: end,
                end: end + 1,
                stand_in: "\"",
            }]
        }
        TokenKind::Space | TokenKind::Sign => token.text.char_indices().filter_map(invisible).collect(),
        _ => Vec::new(),
    }
}

impl Strange {
    fn diagnostic(&self, text: &str, file: FileId) -> Diagnostic {
        let span = Span::new(file, self.start, self.end);
        match self.kind {
            Kind::Blank(c) => Diagnostic::new(Code::SYNTAX, span, invisible(c))
                .label("looks like a space, but is another character")
                .help("replace it with a space; pasted text often contains such characters")
                .fix(Fix::replace(span, " ", "replace an invisible character with a space")),
            Kind::Nothing(c) => Diagnostic::new(Code::SYNTAX, span, invisible(c))
                .label("there is an invisible character here")
                .help("remove it; pasted text often contains such characters")
                .fix(Fix::replace(span, "", "remove an invisible character")),
            Kind::OpenText { quote } => open_text(text, file, quote, self.start),
        }
    }
}

fn invisible(c: char) -> String {
    let name = match c {
        '\u{A0}' => "a no-break space",
        '\u{202F}' => "a narrow no-break space",
        '\u{AD}' => "a soft hyphen",
        '\u{200B}' => "a zero-width space",
        _ => "an invisible character",
    };
    format!("unexpected character: {name} (U+{:04X})", u32::from(c))
}

/// A text that begins at `quote` and is not closed before its line ends at `end`.
fn open_text(text: &str, file: FileId, quote: usize, end: usize) -> Diagnostic {
    let inner = text.get(quote..end).unwrap_or("").trim_end();
    let last = Span::new(file, quote + inner.len(), quote + inner.len());
    let error = Diagnostic::new(
        Code::SYNTAX,
        Span::new(file, quote, quote + inner.len()),
        "this text in quotes is not closed: a `\"` is missing",
    )
    .label("goes on to the end of the line")
    .help("close it with `\"` on the same line");
    // Where something else may follow the text, only its author knows where it should end.
    let words = inner.get(1..).unwrap_or("");
    let whole = !words.trim().is_empty()
        && !words.contains(['(', ')', '[', ']', '{', '}', '=', '\\'])
        && !words.contains(" #");
    error.fix_if(whole.then(|| Fix::replace(last, "\"", "close the text with `\"`")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mended(text: &str) -> (Vec<String>, String) {
        let errors = cleaned(&Scan::new(text), FileId(0)).errors;
        let edits: Vec<_> = errors.iter().filter_map(|e| e.fix.clone()).flat_map(|f| f.edits).collect();
        let messages = errors.iter().map(|e| e.message.clone()).collect();
        (messages, crate::diagnostics::apply(text, &edits).unwrap())
    }

    #[test]
    fn invisible_characters_become_spaces_or_nothing() {
        let (messages, text) = mended("let a\u{A0}= 3 # not\u{A0}here\nlet b\u{200B} = \"nor\u{A0}here\"\n");
        assert_eq!(text, "let a = 3 # not\u{A0}here\nlet b = \"nor\u{A0}here\"\n");
        assert_eq!(messages[0], "unexpected character: a no-break space (U+00A0)");
        assert_eq!(messages.len(), 2);
    }

    #[test]
    fn an_open_text_is_closed_at_the_end_of_its_line_if_nothing_else_is_on_it() {
        assert_eq!(mended("colour = \"#ffffff \nmass = 3 g").1, "colour = \"#ffffff\" \nmass = 3 g");
        assert_eq!(mended("let a = \"abc").1, "let a = \"abc\"");
        let (messages, text) = mended("let a = f(\"abc)\n");
        assert_eq!((messages.len(), text.as_str()), (1, "let a = f(\"abc)\n"));
        assert_eq!(mended("let a = \"a \\\" b\" # \"").0.len(), 0);
    }

    #[test]
    fn places_do_not_move() {
        let text = "let a\u{2003}= \"abc\nlet b = 4\u{A0}m";
        let Cleaned { text: clean, errors, .. } = cleaned(&Scan::new(text), FileId(0));
        assert_eq!(clean.len(), text.len());
        assert_eq!(errors.len(), 3);
        assert_eq!(clean.find("let b"), text.find("let b"));
    }
}
