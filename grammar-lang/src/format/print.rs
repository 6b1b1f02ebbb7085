//! Writes the lines: indentation, comments, blank lines.

use super::layout::Layout;
use super::lines::Line;
use super::table::STEP;
use super::trivia::{Note, Trivia};
use crate::syntax::Tree;

/// How far a comment at least stands from the text before it.
const BEFORE_COMMENT: usize = 3;

/// A line of the result; one without text is blank.
#[derive(Default)]
struct Row<'a> {
    indent: usize,
    text: String,
    /// The comment after the text.
    comment: Option<&'a str>,
}

/// Writes all lines as they are laid out.
pub(super) fn print(tree: &Tree<'_>, trivia: &[Trivia<'_>], lines: &[Line], layout: &Layout) -> String {
    let mut printer = Printer { tree, trivia, layout, rows: Vec::new() };
    let mut previous = None;
    for line in lines {
        printer.line(line, previous.is_none_or(|indent| indent < line.indent));
        previous = Some(line.indent);
    }
    if let Some(end) = trivia.get(tree.leaves.len()) {
        printer.notes(&end.before, 0, previous.is_none());
    }
    text(&printer.rows)
}

struct Printer<'a> {
    tree: &'a Tree<'a>,
    trivia: &'a [Trivia<'a>],
    layout: &'a Layout,
    rows: Vec<Row<'a>>,
}

impl<'a> Printer<'a> {
    /// Writes one line with all that precedes it. No blank line comes first or
    /// last in a block.
    fn line(&mut self, line: &Line, opens_block: bool) {
        for token in line.first..line.end {
            let Some(trivia) = self.trivia.get(token) else { continue };
            if token > line.first {
                self.inside(token, line, trivia);
            } else {
                let indent = if line.head { line.indent } else { line.indent + STEP };
                self.notes(&trivia.before, indent, opens_block);
                if trivia.blank && line.head && !(opens_block && trivia.before.is_empty()) {
                    self.rows.push(Row::default());
                }
                self.rows.push(Row { indent: line.indent, ..Row::default() });
            }
            let text = self.tree.leaves.get(token).map_or("", |t| t.text);
            if let Some(row) = self.rows.last_mut() {
                row.text += text;
                row.comment = trivia.after;
            }
        }
    }

    /// What precedes a token inside its line: spaces, or a break with comments.
    fn inside(&mut self, token: usize, line: &Line, trivia: &'a Trivia<'a>) {
        let gap = self.layout.gaps.get(token);
        let commented = gap.is_some_and(|g| g.must_break);
        let indent = self.layout.breaks.get(&token).copied();
        if let Some(indent) = indent.or(commented.then_some(line.indent + STEP)) {
            let closes = gap.and_then(|g| g.bracket).and_then(|b| self.layout.gaps.get(b)?.close);
            let inner = if closes == Some(token) { indent + STEP } else { indent };
            trivia.before.iter().for_each(|note| self.note(note, inner));
            self.rows.push(Row { indent, ..Row::default() });
        } else if let Some(row) = self.rows.last_mut() {
            row.text += &" ".repeat(gap.map_or(1, |g| g.space));
        }
    }

    /// Comments on lines of their own.
    fn notes(&mut self, notes: &[Note<'a>], indent: usize, opens_block: bool) {
        for (i, note) in notes.iter().enumerate() {
            if note.blank && !(opens_block && i == 0) {
                self.rows.push(Row::default());
            }
            self.note(note, indent);
        }
    }

    fn note(&mut self, note: &Note<'a>, indent: usize) {
        self.rows.push(Row { indent, text: note.text.to_owned(), comment: None });
    }
}

/// Whether the comments of two rows that follow one upon the other share a
/// column: not across blank lines, nor in and out of blocks.
fn together(a: &Row<'_>, b: &Row<'_>) -> bool {
    let apart = |row: &Row<'_>| row.text.is_empty() || row.text.ends_with('{') || row.text.starts_with('}');
    a.indent == b.indent && !apart(a) && !apart(b)
}

/// Joins the rows, with the comments after them in columns.
fn text(rows: &[Row<'_>]) -> String {
    let mut out = String::new();
    for run in rows.chunk_by(together) {
        let width = |row: &Row<'_>| row.indent + row.text.chars().count();
        let commented = run.iter().filter(|row| row.comment.is_some());
        let column = commented.map(width).max().unwrap_or(0) + BEFORE_COMMENT;
        for row in run {
            if !row.text.is_empty() {
                out += &" ".repeat(row.indent);
                out += &row.text;
            }
            if let Some(comment) = row.comment {
                out += &" ".repeat(column.saturating_sub(width(row)));
                out += comment;
            }
            out.push('\n');
        }
    }
    out
}
