//! The one reading of a text: where its comments, texts in quotes, numbers, words and signs are. Whatever
//! looks at the form of a text looks at these tokens: what comes before the parser, what says why a
//! text cannot be parsed, the formatter, and the colours of a page. `grammar.pest` describes the
//! same tokens; a test compares the two.

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// White space, with the ends of lines.
    Space,
    /// `#` and the rest of the line.
    Comment,
    /// A text in quotes; one that is not `closed` ends with its line.
    Text {
        /// Whether its second quote is there.
        closed: bool,
    },
    /// A number without its unit.
    Number,
    /// A name, a keyword, a unit.
    Word,
    /// Anything else: a bracket, an operator, a character that the language does not know.
    Sign,
}

/// A stretch of a text that is never divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token<'a> {
    /// What it is.
    pub kind: TokenKind,
    /// How it is written.
    pub text: &'a str,
    /// Where it begins, in bytes.
    pub start: usize,
}

/// Signs of more than one character.
const LONG_SIGNS: &[&str] = &["<=", ">=", "==", "!=", "->", ".."];

impl Token<'_> {
    /// One past its last byte.
    #[must_use]
    pub fn end(&self) -> usize {
        self.start + self.text.len()
    }

    /// Whether it says nothing to the parser.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        matches!(self.kind, TokenKind::Space | TokenKind::Comment)
    }
}

/// The tokens of any text, in its order. Together they are the text.
pub fn tokens(text: &str) -> impl Iterator<Item = Token<'_>> + Clone {
    let mut start = 0;
    std::iter::from_fn(move || {
        let rest = text.get(start..)?;
        let (kind, length) = first(rest)?;
        let token = Token { kind, text: rest.get(..length)?, start };
        start += length;
        Some(token)
    })
}

/// The first token of a text: its kind and length.
fn first(text: &str) -> Option<(TokenKind, usize)> {
    let c = text.chars().next()?;
    Some(match c {
        c if is_space(c) => (TokenKind::Space, run(text, is_space)),
        '#' => (TokenKind::Comment, run(text, |c| c != '\n')),
        '"' => quoted(text),
        c if c.is_ascii_digit() => (TokenKind::Number, number(text)),
        c if c == '_' || unicode_ident::is_xid_start(c) => {
            (TokenKind::Word, run(text, unicode_ident::is_xid_continue))
        }
        c => {
            let long = LONG_SIGNS.iter().find(|sign| text.starts_with(**sign));
            (TokenKind::Sign, long.map_or(c.len_utf8(), |sign| sign.len()))
        }
    })
}

/// The byte order mark is one: editors put it at the start of a file.
fn is_space(c: char) -> bool {
    c.is_whitespace() || c == '\u{FEFF}'
}

/// How many bytes at the start hold for all their characters.
fn run(text: &str, holds: impl Fn(char) -> bool) -> usize {
    text.find(|c| !holds(c)).unwrap_or(text.len())
}

/// A text in quotes, where a backslash takes the next character as it is, even the end of a line.
fn quoted(text: &str) -> (TokenKind, usize) {
    let mut escaped = false;
    for (place, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '\n' => return (TokenKind::Text { closed: false }, place),
            '"' => return (TokenKind::Text { closed: true }, place + 1),
            _ => {}
        }
    }
    (TokenKind::Text { closed: false }, text.len())
}

fn number(text: &str) -> usize {
    let after = |place: usize| text.get(place..).unwrap_or("");
    let digits = |text: &str| run(text, |c| c.is_ascii_digit());
    let mut end = digits(text);
    // `1 .. 2` may be written without spaces, so a point needs a digit after it.
    let decimals = after(end).strip_prefix('.').map_or(0, digits);
    if decimals > 0 {
        end += 1 + decimals;
    }
    if let Some(power) = after(end).strip_prefix(['e', 'E']) {
        let sign = usize::from(power.starts_with(['+', '-']));
        let power = power.get(sign..).map_or(0, digits);
        if power > 0 {
            end += 1 + sign + power;
        }
    }
    end
}

/// A text with its tokens.
pub(super) struct Scan<'a> {
    pub(super) text: &'a str,
    tokens: Vec<Token<'a>>,
}

impl<'a> Scan<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, tokens: tokens(text).collect() }
    }

    /// All of them, with space and comments.
    pub(super) fn tokens(&self) -> &[Token<'a>] {
        &self.tokens
    }

    /// Part of the text, from where a token begins to where one ends.
    pub(super) fn stretch(&self, start: usize, end: usize) -> Stretch<'_> {
        Stretch { scan: self, start, end }
    }
}

/// Part of a scanned text. Places are those of the whole text.
#[derive(Clone, Copy)]
pub(super) struct Stretch<'a> {
    scan: &'a Scan<'a>,
    pub(super) start: usize,
    pub(super) end: usize,
}

impl<'a> Stretch<'a> {
    pub(super) fn text(self) -> &'a str {
        self.scan.text.get(self.start..self.end).unwrap_or("")
    }

    /// Part of this stretch.
    pub(super) fn part(self, start: usize, end: usize) -> Self {
        Self { start, end, ..self }
    }

    /// What the line of the stretch's beginning holds before it.
    pub(super) fn before_on_line(self) -> &'a str {
        self.scan.text.get(..self.start).unwrap_or("").rsplit('\n').next().unwrap_or("")
    }

    /// Its tokens with comments and space.
    pub(super) fn all(self) -> &'a [Token<'a>] {
        let tokens = self.scan.tokens();
        let place = |at: usize| tokens.partition_point(|token| token.start < at);
        tokens.get(place(self.start)..place(self.end)).unwrap_or(&[])
    }

    /// Its tokens without comments and space.
    pub(super) fn tokens(self) -> impl DoubleEndedIterator<Item = &'a Token<'a>> + Clone {
        self.all().iter().filter(|token| !token.is_silent())
    }

    /// Its first token.
    pub(super) fn first(self) -> Option<&'a Token<'a>> {
        self.tokens().next()
    }

    /// The word or number that it begins with; empty if it begins with something else.
    pub(super) fn first_word(self) -> &'a str {
        let is_word = |t: &&Token<'_>| matches!(t.kind, TokenKind::Word | TokenKind::Number);
        self.first().filter(|t| t.start == self.start).filter(is_word).map_or("", |t| t.text)
    }

    /// Its words.
    pub(super) fn words(self) -> impl Iterator<Item = &'a str> {
        self.tokens().filter(|t| t.kind == TokenKind::Word).map(|t| t.text)
    }

    /// Where its last line ends that holds more than a comment, with a comment that ends it.
    pub(super) fn line_end(self) -> usize {
        let lines = self.lines().filter(|line| line.first().is_some());
        lines.last().map_or(self.start, |line| line.start + line.text().trim_end().len())
    }

    /// What stands at a place or, after space and comments, first behind it: a token, or the rest of one.
    /// A text in quotes is its first quote.
    pub(super) fn token_from(self, place: usize) -> Option<(usize, &'a str)> {
        let tokens = self.scan.tokens();
        let from = tokens.partition_point(|token| token.end() <= place);
        let token = tokens.get(from..)?.iter().find(|token| !token.is_silent())?;
        let start = place.max(token.start);
        let rest = token.text.get(start - token.start..).filter(|_| start < self.end)?;
        let is_text = matches!(token.kind, TokenKind::Text { .. });
        let length = if is_text { rest.chars().next()?.len_utf8() } else { rest.len() };
        Some((start, rest.get(..length)?))
    }

    /// What follows on the line that the stretch begins in, without a comment.
    pub(super) fn rest_of_line(self) -> &'a str {
        let ends = |t: &&Token<'_>| t.text.contains('\n') || t.kind == TokenKind::Comment;
        let end = self.all().iter().find(ends).map_or(self.end, |t| t.start);
        self.part(self.start, end).text().trim()
    }

    /// Its lines that hold more than space; in the middle of a text in quotes none begins.
    pub(super) fn lines(self) -> impl Iterator<Item = Stretch<'a>> {
        let mut rest = self;
        std::iter::from_fn(move || {
            let first = rest.all().iter().find(|t| t.kind != TokenKind::Space)?;
            let ends = |t: &&Token<'_>| t.kind == TokenKind::Space && t.text.contains('\n');
            let start = first.start;
            let end = rest.part(start, rest.end).all().iter().find(ends).map_or(rest.end, |t| t.start);
            rest = rest.part(end, rest.end);
            Some(rest.part(start, end))
        })
    }
}

/// By how much a token makes brackets deeper.
pub(super) fn deeper(token: &Token<'_>, open: &[&str], close: &[&str]) -> i32 {
    if token.kind != TokenKind::Sign {
        return 0;
    }
    i32::from(open.contains(&token.text)) - i32::from(close.contains(&token.text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<(&str, TokenKind)> {
        tokens(text).filter(|t| t.kind != TokenKind::Space).map(|t| (t.text, t.kind)).collect()
    }

    #[test]
    fn quotes_and_comments_hide_each_other() {
        use TokenKind::{Comment, Text, Word};
        let closed = Text { closed: true };
        assert_eq!(
            kinds("a \"# no\" # \"no\nb"),
            [("a", Word), ("\"# no\"", closed), ("# \"no", Comment), ("b", Word)]
        );
        assert_eq!(kinds("\"a \\\" b\" c"), [("\"a \\\" b\"", closed), ("c", Word)]);
        assert_eq!(kinds("\"a\\\nb\""), [("\"a\\\nb\"", closed)]);
        assert_eq!(kinds("\"a\nb"), [("\"a", Text { closed: false }), ("b", Word)]);
    }

    #[test]
    fn numbers_end_before_ranges_members_and_units() {
        let texts = |text| kinds(text).into_iter().map(|(text, _)| text).collect::<Vec<_>>();
        assert_eq!(texts("1..2.5e-3mm"), ["1", "..", "2.5e-3", "mm"]);
        assert_eq!(texts("3e 4.x"), ["3", "e", "4", ".", "x"]);
        assert_eq!(texts("a<=-b->c"), ["a", "<=", "-", "b", "->", "c"]);
    }

    proptest::proptest! {
        #[test]
        fn tokens_make_up_any_text(text in "[ -~\\n\\t#\"\\\\é]{0,80}") {
            let all: String = tokens(&text).map(|t| t.text).collect();
            proptest::prop_assert_eq!(all, text);
        }
    }
}
