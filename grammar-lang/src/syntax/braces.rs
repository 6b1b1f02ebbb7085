//! Braces: where blocks open and close, and what to say where they do not.

use super::tokens::{Scan, Stretch, Token, deeper};
use crate::diagnostics::{Code, Diagnostic, Edit, Fix, apply};
use crate::source::{FileId, Span};

/// By how much a token makes braces deeper.
pub(super) fn brace(token: &Token<'_>) -> i32 {
    deeper(token, &["{"], &["}"])
}

/// The span of a token.
pub(super) fn span(token: &Token<'_>, file: FileId) -> Span {
    Span::new(file, token.start, token.end())
}

/// The first `{`.
pub(super) fn opening(piece: Stretch<'_>) -> Option<&Token<'_>> {
    piece.tokens().find(|token| brace(token) > 0)
}

/// The `}` that closes the `{` with which a stretch begins.
pub(super) fn matching_close(block: Stretch<'_>) -> Option<&Token<'_>> {
    let mut depth = 0;
    block.tokens().find(|token| {
        let change = brace(token);
        depth = (depth + change).max(0);
        change < 0 && depth == 0
    })
}

/// Whether the block that a stretch begins with certainly ends with it: no other block is open, and every line
/// of it is indented.
pub(super) fn is_all_within(block: Stretch<'_>) -> bool {
    let before = block.before_on_line();
    let indent = before.len() - before.trim_start().len();
    let depth: i32 = block.tokens().map(brace).sum();
    let mut lines = block.lines().skip(1).filter(|line| line.first().is_some());
    depth == 1 && lines.all(|line| line.before_on_line().len() > indent)
}

/// The `{` that follows the one that a block begins with at once, as no clause begins with it.
pub(super) fn doubled_brace(block: Stretch<'_>) -> Option<&Token<'_>> {
    block.tokens().nth(1).filter(|token| brace(token) > 0)
}

/// Says that a block is opened twice; and the text as it would be, at the same places, without the
/// second `{` and its end.
pub(super) fn two_braces(
    scan: &Scan<'_>,
    piece: Stretch<'_>,
    second: &Token<'_>,
    file: FileId,
) -> (Diagnostic, String) {
    let mut fix = Fix::replace(span(second, file), "", "remove the second `{`");
    let close = matching_close(piece.part(second.start, piece.end));
    let after = close.and_then(|close| piece.part(close.end(), piece.end).first());
    if let Some(after) = after.filter(|token| brace(token) < 0) {
        fix = fix.and(span(after, file), "");
    }
    let blanks: Vec<_> =
        fix.edits.iter().map(|e| Edit { replacement: " ".to_owned(), ..e.clone() }).collect();
    let clean = apply(scan.text, &blanks).unwrap_or_default();
    let error = Diagnostic::new(Code::SYNTAX, span(second, file), "a second `{` opens this block")
        .label("a second one")
        .help("remove it, and its `}` if it has one")
        .fix(fix);
    (error, clean)
}
