//! Braces: where blocks open and close, and what to say where they do not.

use crate::diagnostics::{Code, Diagnostic, Edit, Fix, apply};
use crate::source::{FileId, Span};

/// Walks over text outside comments and quotes.
pub(super) fn bare(text: &str) -> impl Iterator<Item = (usize, char)> {
    let (mut quoted, mut escaped, mut comment) = (false, false, false);
    text.char_indices().filter(move |(_, c)| {
        // In quotes, a backslash takes the next character as it is, even the end of a line.
        let is_taken = std::mem::take(&mut escaped);
        match c {
            _ if is_taken => {}
            '\\' if quoted => escaped = true,
            '\n' => (quoted, comment) = (false, false),
            '"' if !comment => quoted = !quoted,
            '#' if !quoted => comment = true,
            _ => {}
        }
        !quoted && !comment
    })
}

/// The first place of a character outside comments and quotes.
pub(super) fn find_bare(text: &str, wanted: char) -> Option<usize> {
    bare(text).find(|(_, c)| *c == wanted).map(|(i, _)| i)
}

/// The `}` that closes the `{` at `open`.
pub(super) fn matching_close(text: &str, open: usize) -> Option<usize> {
    let mut depth = 0usize;
    for (place, c) in bare(text).filter(|(i, _)| *i >= open) {
        match c {
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return Some(place);
                }
            }
            _ => {}
        }
    }
    None
}

/// Whether a block that is open at `open` certainly ends with the text: no other block is open, and every line
/// of it is indented.
pub(super) fn is_all_within(piece: &str, open: usize) -> bool {
    let signs = bare(piece).filter(|(i, _)| *i >= open);
    let depth: i32 = signs.map(|(_, c)| i32::from(c == '{') - i32::from(c == '}')).sum();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let opens = piece.get(..open).and_then(|before| before.rsplit('\n').next()).unwrap_or("");
    let mut lines = piece.get(open..).unwrap_or("").lines().skip(1);
    let told = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    depth == 1 && lines.all(|line| !told(line) || indent(line) > indent(opens))
}

/// Where the last line ends that is more than a comment: comments below it belong to what follows.
pub(super) fn last_line_end(piece: &str) -> usize {
    let mut end = piece.trim_end().len();
    while let Some(start) = piece.get(..end).and_then(|p| p.rfind('\n')) {
        if !piece.get(start..end).is_some_and(|line| line.trim_start().starts_with('#')) {
            break;
        }
        end = piece.get(..start).map_or(0, |p| p.trim_end().len());
    }
    end
}

/// The `{` that follows the one at `open` at once, as no clause begins with it.
pub(super) fn doubled_brace(piece: &str, open: usize) -> Option<usize> {
    let inside = piece.get(open + 1..)?;
    let next = inside.trim_start();
    next.starts_with('{').then_some(piece.len() - next.len())
}

/// Says that a block is opened twice; and the text as it would be, at the same places, without the
/// second `{` and its end.
pub(super) fn two_braces(
    text: &str,
    start: usize,
    end: usize,
    second: usize,
    file: FileId,
) -> (Diagnostic, String) {
    let piece = text.get(start..end).unwrap_or("");
    let brace = |place: usize| Span::new(file, start + place, start + place + 1);
    let mut fix = Fix::replace(brace(second), "", "remove the second `{`");
    let after =
        matching_close(piece, second).and_then(|close| piece.get(close + 1..)).unwrap_or("").trim_start();
    if after.starts_with('}') {
        fix = fix.and(brace(piece.len() - after.len()), "");
    }
    let blanks: Vec<_> =
        fix.edits.iter().map(|e| Edit { replacement: " ".to_owned(), ..e.clone() }).collect();
    let clean = apply(text, &blanks).unwrap_or_default();
    let error = Diagnostic::new(Code::SYNTAX, brace(second), "a block is opened with one `{`")
        .label("a second one")
        .help("remove it, and its `}` if it has one")
        .fix(fix);
    (error, clean)
}
