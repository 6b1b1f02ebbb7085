//! Which tokens stand on a line together: a line of its own for every pair of
//! the table, interrupted by the lines inside it.

use super::table::{LINES, STEP};
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
    let mut owner_of: Vec<Option<usize>> = vec![None; tree.tokens.len()];
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
            keyword: owner.filter(|o| o.first == first).map_or(0, |o| o.keyword),
        });
        first = end;
    }
    lines
}

fn owners(tree: &Tree<'_>) -> Vec<Owner> {
    let mut owners: Vec<Owner> = Vec::new();
    let mut ends: Vec<usize> = Vec::new();
    for (node, pair) in tree.nodes().iter().enumerate() {
        let Some((_, keyword)) = LINES.iter().find(|(name, _)| *name == &*pair.rule) else { continue };
        ends.retain(|end| *end > pair.first);
        let (first, end, level) = (pair.first, pair.end, ends.len());
        owners.push(Owner { node, first, end, level, keyword: *keyword });
        ends.push(end);
    }
    owners
}
