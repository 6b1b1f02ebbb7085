//! Cuts a text into pieces to colour. Not the language's lexer: it reads any text.

use grammar_lang::units;

/// What a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// White space.
    Space,
    /// `#` and the rest of the line.
    Comment,
    /// A text in quotes.
    Text,
    /// A number with its unit.
    Number,
    /// A word.
    Word,
    /// Anything else.
    Sign,
}

/// A piece of a text. All pieces together are the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece<'a> {
    pub(super) kind: Kind,
    pub(super) text: &'a str,
}

/// The pieces of a text.
pub(super) fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let (kind, length) = match first {
            c if c.is_whitespace() => (Kind::Space, run(rest, char::is_whitespace)),
            '#' => (Kind::Comment, run(rest, |c| c != '\n')),
            '"' => (Kind::Text, quoted(rest)),
            c if c.is_ascii_digit() => (Kind::Number, quantity(rest)),
            c if c.is_alphabetic() || c == '_' => {
                (Kind::Word, run(rest, |c| c.is_alphanumeric() || c == '_'))
            }
            c => (Kind::Sign, c.len_utf8()),
        };
        let (text, after) = rest.split_at_checked(length).unwrap_or((rest, ""));
        pieces.push(Piece { kind, text });
        rest = after;
    }
    pieces
}

/// How many bytes at the start hold for all their characters.
fn run(text: &str, holds: impl Fn(char) -> bool) -> usize {
    text.find(|c| !holds(c)).unwrap_or(text.len())
}

/// The length of a text in quotes; one that is not closed ends with its line.
fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (place, c) in text.char_indices().skip(1) {
        match c {
            '\n' => return place,
            '"' if !escaped => return place + 1,
            _ => escaped = c == '\\' && !escaped,
        }
    }
    text.len()
}

/// The length of a number and, on the same line, its unit.
fn quantity(text: &str) -> usize {
    let after = |place: usize| text.get(place..).unwrap_or("");
    let mut end = run(text, |c| c.is_ascii_digit());
    // `1 .. 2` may be written without spaces, so a point needs a digit after it.
    if let Some(digits) = after(end).strip_prefix('.').map(|rest| run(rest, |c| c.is_ascii_digit()))
        && digits > 0
    {
        end += 1 + digits;
    }
    if let Some(power) = after(end).strip_prefix(['e', 'E']) {
        let sign = usize::from(power.starts_with(['+', '-']));
        let digits = run(power.get(sign..).unwrap_or(""), |c| c.is_ascii_digit());
        if digits > 0 {
            end += 1 + sign + digits;
        }
    }
    let space = run(after(end), |c| c == ' ' || c == '\t');
    let unit = run(after(end + space), |c| c.is_alphanumeric() || "%*/^-".contains(c));
    let unit_text = after(end + space).get(..unit).unwrap_or("");
    if unit > 0 && units::parse(unit_text).is_ok() { end + space + unit } else { end }
}
