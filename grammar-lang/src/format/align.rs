//! Columns: lines of one table that follow one upon the other are padded.

use super::layout::Layout;
use super::lines::Line;
use super::table::{Columns, SECOND, TABLES, WIDTH};
use super::trivia::Trivia;
use crate::syntax::{Node, Tree};

/// A line of a table.
struct Row<'a> {
    line: &'a Line,
    table: usize,
    /// The token that begins each column, where the row has one.
    cells: Vec<Option<usize>>,
}

/// Pads the places of all tables. Gives how wide each line may be.
pub(super) fn align(
    tree: &Tree<'_>,
    trivia: &[Trivia<'_>],
    lines: &[Line],
    layout: &mut Layout,
) -> Vec<usize> {
    for line in lines.iter().filter(|l| l.keyword > 0) {
        let width = layout.width(line.first..line.first + 1);
        pad(layout, line.first + 1, line.keyword.saturating_sub(width));
    }
    let rows: Vec<Option<Row<'_>>> = lines.iter().map(|line| row(tree, line)).collect();
    let together = |a: &Option<Row<'_>>, b: &Option<Row<'_>>| match (a, b) {
        (Some(a), Some(b)) => a.table == b.table && !trivia.get(b.line.first).is_some_and(Trivia::has_blank),
        _ => false,
    };
    let mut limits = Vec::with_capacity(lines.len());
    for run in rows.chunk_by(together) {
        let run_rows: Vec<&Row<'_>> = run.iter().flatten().collect();
        let table = run_rows.first().and_then(|r| TABLES.get(r.table)).filter(|_| run.len() > 1);
        let limit = table.map_or(WIDTH, |t| t.width);
        if let Some(table) = table {
            settle(layout, table, &run_rows);
        }
        limits.extend(run.iter().map(|_| limit));
    }
    limits
}

fn pad(layout: &mut Layout, token: usize, space: usize) {
    if let Some(gap) = layout.gaps.get_mut(token) {
        gap.space = space.max(1);
    }
}

/// A line as a row of its table, if it has one.
fn row<'a>(tree: &Tree<'_>, line: &'a Line) -> Option<Row<'a>> {
    let inside = tree.nodes().iter().enumerate().skip(line.whole?);
    let inside = inside.take_while(|(_, n)| n.first < line.end);
    let of = |rule: &str| TABLES.iter().position(|t| t.rows.contains(&rule));
    let (node, table) = inside.clone().find_map(|(i, n)| of(&n.rule).map(|table| (i, table)))?;
    let begins = |column: &[&str]| {
        if column == SECOND {
            return Some(line.first + 1);
        }
        let part = |n: &&(usize, &Node)| n.1.parent == node && column.contains(&&*n.1.rule);
        inside.clone().find(|n| part(&n)).map(|(_, n)| n.first)
    };
    let cells = TABLES.get(table)?.columns.iter().map(|c| begins(c)).collect();
    Some(Row { line, table, cells })
}

/// Pads the rows of one run: as many columns as there is room for.
fn settle(layout: &mut Layout, table: &Columns, rows: &[&Row<'_>]) {
    let width = |layout: &Layout, row: &Row<'_>| row.line.indent + layout.width(row.line.first..row.line.end);
    let fits = |layout: &Layout, row: &Row<'_>| {
        width(layout, row) <= table.width && !layout.is_broken(row.line.first..row.line.end)
    };
    // A row that takes several lines follows the first column and widens none. A
    // list that is opened in it stays with the word before.
    let (flat, tall): (Vec<&Row<'_>>, Vec<&Row<'_>>) = rows.iter().partition(|row| fits(layout, row));
    let followers: Vec<&Row<'_>> = tall.into_iter().filter(|row| !opens_list(layout, row)).collect();
    for columns in (0..=table.columns.len()).rev() {
        for column in 0..table.columns.len() {
            let target = flat.iter().filter_map(|row| place(layout, row, column)).max().unwrap_or(0);
            let followers = followers.iter().filter(|_| column == 0);
            for row in flat.iter().chain(followers) {
                let Some((token, at)) =
                    row.cells.get(column).copied().flatten().zip(place(layout, row, column))
                else {
                    continue;
                };
                let space = if column < columns { (target + 1).saturating_sub(at) } else { 1 };
                pad(layout, token, space);
            }
        }
        if flat.iter().all(|row| width(layout, row) <= table.width) {
            return;
        }
    }
}

/// Whether the first column of a row begins with a bracket.
fn opens_list(layout: &Layout, row: &Row<'_>) -> bool {
    let token = row.cells.first().copied().flatten();
    token.and_then(|t| layout.gaps.get(t)).is_some_and(|g| g.close.is_some())
}

/// Where a row stands before it is padded for a column.
fn place(layout: &Layout, row: &Row<'_>, column: usize) -> Option<usize> {
    let token = row.cells.get(column).copied().flatten()?;
    Some(layout.width(row.line.first..token))
}
