//! The one layout of a text: lines, columns and spaces; never words.
//!
//! A text is read as tokens with the pairs of the grammar around them
//! (`lines` says which stand on a line together, `gaps` what may stand between
//! two of them), padded into columns (`align`), broken where it is too wide
//! (`layout`) and written (`print`). What is particular to the language is in
//! `table`.

mod align;
mod gaps;
mod layout;
mod lines;
mod print;
mod table;
#[cfg(test)]
mod tests;
mod trivia;

use std::collections::BTreeMap;

use crate::diagnostics::Diagnostic;
use crate::source::{FileId, SourceMap};
use crate::syntax::{self, Node, Tree};
use layout::Layout;

/// Why a text is left as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unformatted {
    /// It has these errors.
    Errors(Vec<Diagnostic>),
    /// Its layout would have changed what it says: a bug of this module.
    Altered,
}

/// Lays out a text. Only white space differs from the text as it was.
///
/// # Errors
///
/// The text has errors, or would say something else.
pub fn format(sources: &SourceMap, file: FileId) -> Result<String, Unformatted> {
    let (_, found) = syntax::parse(sources, file);
    if found.iter().any(Diagnostic::is_error) {
        return Err(Unformatted::Errors(found));
    }
    let text = sources.get(file).map_or("", |s| s.text.as_str());
    let tree = syntax::tree(text).ok_or(Unformatted::Altered)?;
    let formatted = lay_out(text, &tree);
    match syntax::tree(&formatted) {
        Some(after) if same(&tree, &after) => Ok(formatted),
        _ => Err(Unformatted::Altered),
    }
}

fn lay_out(text: &str, tree: &Tree<'_>) -> String {
    let trivia = trivia::trivia(text, tree);
    let lines = lines::lines(tree);
    let mut layout = Layout { gaps: gaps::gaps(tree, &trivia), breaks: BTreeMap::new() };
    let limits = align::align(tree, &trivia, &lines, &mut layout);
    for (line, limit) in lines.iter().zip(limits) {
        layout.plan(line.first..line.end, line.indent, line.indent, limit);
    }
    print::print(tree, &trivia, &lines, &layout)
}

/// Whether two texts have the same tokens in the same pairs, with the same
/// comments at the same places.
fn same(a: &Tree<'_>, b: &Tree<'_>) -> bool {
    let words = a.leaves.iter().map(|t| t.text).eq(b.leaves.iter().map(|t| t.text));
    let pair = |node: &'_ Node| (node.first, node.end);
    let pairs = a.nodes().iter().map(pair).eq(b.nodes().iter().map(pair))
        && a.nodes().iter().map(|n| &n.rule).eq(b.nodes().iter().map(|n| &n.rule));
    let place = |tree: &Tree<'_>, start| tree.leaves.partition_point(|t| t.start < start);
    let comments = a.comments.iter().map(|c| (c.text, place(a, c.start)));
    let comments = comments.eq(b.comments.iter().map(|c| (c.text, place(b, c.start))));
    words && pairs && comments
}
