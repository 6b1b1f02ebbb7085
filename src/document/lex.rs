//! Cuts a text into pieces to colour: the tokens of the language, with each number and its unit in one.

use std::iter::Peekable;

use grammar_lang::syntax::{Token, TokenKind, tokens};
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
    let mut rest = tokens(text).peekable();
    while let Some(token) = rest.next() {
        let (kind, end) = match token.kind {
            TokenKind::Space => (Kind::Space, token.end()),
            TokenKind::Comment => (Kind::Comment, token.end()),
            TokenKind::Text { .. } => (Kind::Text, token.end()),
            TokenKind::Number => (Kind::Number, quantity(text, token, rest.clone())),
            TokenKind::Word => (Kind::Word, token.end()),
            TokenKind::Sign => (Kind::Sign, token.end()),
        };
        while rest.next_if(|token| token.start < end).is_some() {}
        pieces.push(Piece { kind, text: text.get(token.start..end).unwrap_or("") });
    }
    pieces
}

/// Where a number ends with its unit, if that follows on the same line.
fn quantity<'a>(text: &str, number: Token<'a>, mut rest: Peekable<impl Iterator<Item = Token<'a>>>) -> usize {
    let is_blank = |t: &Token<'_>| t.kind == TokenKind::Space && !t.text.contains('\n');
    let start = rest.next_if(is_blank).map_or(number.end(), |space| space.end());
    let unit = rest.take_while(|t| {
        matches!(t.kind, TokenKind::Word | TokenKind::Number) || ["%", "*", "/", "^", "-"].contains(&t.text)
    });
    let ends = unit.map(|token| token.end());
    let is_unit = |end: &usize| text.get(start..*end).is_some_and(|unit| units::parse(unit).is_ok());
    ends.filter(is_unit).last().unwrap_or(number.end())
}
