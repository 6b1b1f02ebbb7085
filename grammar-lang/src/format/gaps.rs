//! The places between tokens: how wide they are, and whether a line may end there.

use super::table::{BREAK_BEFORE, PREFIXES, SUFFIXES};
use super::trivia::Trivia;
use crate::syntax::Tree;

/// The place before a token.
#[derive(Default)]
pub(super) struct Gap {
    /// How many spaces, if the line does not end here.
    pub(super) space: usize,
    /// How wide the token is.
    pub(super) width: usize,
    /// Whether a line that is too long may end here.
    pub(super) may_break: bool,
    /// Whether a comment makes the line end here.
    pub(super) must_break: bool,
    /// Whether `=` precedes it.
    pub(super) after_equals: bool,
    /// Whether a comma precedes it.
    pub(super) after_comma: bool,
    /// Whether a line ended here before.
    pub(super) newline: bool,
    /// The innermost pair around both tokens, and how deep that is.
    pub(super) pair: (usize, usize),
    /// The token that opens the bracket around this place.
    pub(super) bracket: Option<usize>,
    /// How many brackets are around this place.
    pub(super) nesting: usize,
    /// If the token opens a bracket, the one that closes it.
    pub(super) close: Option<usize>,
}

pub(super) fn gaps(tree: &Tree<'_>, trivia: &[Trivia<'_>]) -> Vec<Gap> {
    let mut gaps: Vec<Gap> = Vec::with_capacity(tree.leaves.len());
    let mut open: Vec<usize> = Vec::new();
    for (i, token) in tree.leaves.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|b| tree.leaves.get(b)).map_or("", |t| t.text);
        let commented = i.checked_sub(1).and_then(|b| trivia.get(b)).is_some_and(|t| t.after.is_some());
        let here = trivia.get(i);
        let pair = tree.meeting(i);
        let indexes =
            open.last().is_some_and(|open| is_index(tree, *open)) && (before == "[" || token.text == "]");
        gaps.push(Gap {
            space: usize::from(i > 0 && !tight(tree, i, before, token.text)),
            width: token.text.chars().count(),
            may_break: !indexes && may_break(tree, i, before, token.text),
            must_break: commented || here.is_some_and(|t| !t.before.is_empty()),
            after_equals: before == "=",
            after_comma: before == ",",
            newline: here.is_some_and(|t| t.newline),
            pair: (pair, tree.nodes().get(pair).map_or(0, |n| n.depth)),
            bracket: open.last().copied(),
            nesting: open.len(),
            close: None,
        });
        if opens(token.text) {
            open.push(i);
        } else if closes(token.text)
            && let Some(opener) = open.pop().and_then(|o| gaps.get_mut(o))
        {
            opener.close = Some(i);
        }
    }
    gaps
}

/// Whether a bracket takes items of what it follows: it is short, and no line begins inside it.
fn is_index(tree: &Tree<'_>, open: usize) -> bool {
    let text = |token: usize| tree.leaves.get(token).map_or("", |leaf| leaf.text);
    text(open) == "[" && open > 0 && ends_a_value(tree, open - 1, text(open - 1))
}

fn opens(text: &str) -> bool {
    ["(", "[", "{"].contains(&text)
}

fn closes(text: &str) -> bool {
    [")", "]", "}"].contains(&text)
}

/// The name of the pair that a token is a direct part of.
fn holder<'t>(tree: &'t Tree<'_>, token: usize) -> &'t str {
    tree.nodes().get(tree.holder(token)).map_or("", |n| &*n.rule)
}

/// Whether two tokens touch.
fn tight(tree: &Tree<'_>, i: usize, before: &str, text: &str) -> bool {
    let is = |signs: &[(&str, &str)], token: usize, text: &str| {
        signs.iter().any(|(pair, sign)| *sign == text && *pair == holder(tree, token))
    };
    match (before, text) {
        ("(" | "[" | ".", _) | (_, ")" | "]" | "," | ".") | ("{", "}") => true,
        (_, "(" | "[") => ends_a_value(tree, i - 1, before),
        _ => is(PREFIXES, i - 1, before) || is(SUFFIXES, i, text),
    }
}

/// Whether a bracket after this token calls it or takes an item of it.
fn ends_a_value(tree: &Tree<'_>, token: usize, text: &str) -> bool {
    let word = text.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '"');
    let reserved = tree.beginning_with(token).any(|pair| pair.starts_with("kw_"));
    closes(text) && text != "}" || word && !reserved
}

fn may_break(tree: &Tree<'_>, i: usize, before: &str, text: &str) -> bool {
    match (before, text) {
        ("{", "}") | ("(", ")") | ("[", "]") => false,
        ("(" | "[" | "{" | ",", _) | (_, ")" | "]" | "}") => true,
        ("=", _) => holder(tree, i - 1) != "argument",
        (":", _) => SUFFIXES.contains(&(holder(tree, i - 1), ":")),
        _ => tree.beginning_with(i).any(|pair| BREAK_BEFORE.contains(&pair)),
    }
}
