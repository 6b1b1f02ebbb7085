//! Which tokens stand on a line together: a line of its own for every pair of
//! the table, interrupted by the lines inside it.

use super::table::{FIRST_WORDS, LINES, STEP};
use crate::syntax::Tree;

/// Tokens that stand on one line if there is room.
#[derive(Clone)]
pub(super) struct Line {
    /// Its first token.
    pub(super) first: usize,
    /// One past its last token.
    pub(super) end: usize,
    /// How far it stands in.
    pub(super) indent: usize,
    /// Whether it begins a declaration or clause, rather than ending a block.
    pub(super) head: bool,
    /// The pair, if nothing inside it has lines of its own.
    pub(super) whole: Option<usize>,
    /// The width of its first word's column.
    pub(super) keyword: usize,
}

/// A pair that has lines of its own.
struct Owner {
    node: usize,
    first: usize,
    end: usize,
    level: usize,
    keyword: usize,
}

pub(super) fn lines(tree: &Tree<'_>) -> Vec<Line> {
    let owners = owners(tree);
    let mut owner_of: Vec<Option<usize>> = vec![None; tree.leaves.len()];
    for (i, owner) in owners.iter().enumerate() {
        // Inner owners come later and take over.
        owner_of.iter_mut().take(owner.end).skip(owner.first).for_each(|o| *o = Some(i));
    }
    let mut lines = Vec::new();
    let mut first = 0;
    for stretch in owner_of.chunk_by(|a, b| a == b) {
        let end = first + stretch.len();
        let owner = stretch.first().copied().flatten().and_then(|i| owners.get(i));
        lines.push(Line {
            first,
            end,
            indent: owner.map_or(0, |o| STEP * o.level),
            head: owner.is_none_or(|o| o.first == first),
            whole: owner.filter(|o| (o.first, o.end) == (first, end)).map(|o| o.node),
            // The first line of a block stands for itself.
            keyword: owner.filter(|o| (o.first, o.end) == (first, end)).map_or(0, |o| o.keyword),
        });
        first = end;
    }
    lines
}

fn owners(tree: &Tree<'_>) -> Vec<Owner> {
    let mut owners: Vec<Owner> = Vec::new();
    // Those around the pair at hand, as (first token, one past the last), and where the last one ended.
    let mut around: Vec<(usize, usize)> = Vec::new();
    let mut ended = 0;
    for (node, pair) in tree.nodes().iter().enumerate() {
        let (first, end) = (pair.first, pair.end);
        if first == end || !LINES.iter().any(|ending| pair.rule.ends_with(ending)) {
            continue;
        }
        while let Some((_, last)) = around.pop_if(|(_, last)| *last <= first) {
            ended = last;
        }
        // A declaration in the middle of a line, after a word, goes on in that line.
        let before = first.checked_sub(1).and_then(|i| tree.leaves.get(i));
        let begins = ended == first || before.is_none_or(|t| t.text == "{");
        if begins && around.last().is_none_or(|(outer, _)| *outer != first) {
            owners.push(Owner { node, first, end, level: around.len(), keyword: first_word(&pair.rule) });
            around.push((first, end));
        }
    }
    owners
}

fn first_word(rule: &str) -> usize {
    FIRST_WORDS.iter().find(|(name, _)| *name == rule).map_or(0, |(_, width)| *width)
}
