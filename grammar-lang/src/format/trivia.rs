//! What stands between tokens: comments, line breaks and blank lines.

use crate::syntax::Tree;

/// A comment on a line of its own.
#[derive(Clone)]
pub(super) struct Note<'a> {
    pub(super) text: &'a str,
    /// Whether a blank line precedes it.
    pub(super) blank: bool,
}

/// What stands around a token.
#[derive(Clone, Default)]
pub(super) struct Trivia<'a> {
    /// The comments before it that have lines of their own.
    pub(super) before: Vec<Note<'a>>,
    /// Whether a blank line precedes it, after those comments.
    pub(super) blank: bool,
    /// Whether it begins a line.
    pub(super) newline: bool,
    /// The comment that follows it on its line.
    pub(super) after: Option<&'a str>,
}

impl Trivia<'_> {
    /// Whether a blank line comes between the token and the one before it.
    pub(super) fn has_blank(&self) -> bool {
        self.blank || self.before.iter().any(|n| n.blank)
    }
}

/// The trivia of every token, and of the end of the text.
pub(super) fn trivia<'a>(text: &str, tree: &Tree<'a>) -> Vec<Trivia<'a>> {
    let mut all: Vec<Trivia<'a>> = Vec::new();
    let mut comments = tree.comments.iter().peekable();
    let lines = |from: usize, to: usize| text.get(from..to).unwrap_or("").matches('\n').count();
    let mut end = 0;
    let places = tree.leaves.iter().map(|t| (t.start, t.text.len())).chain([(text.len(), 0)]);
    for (start, length) in places {
        let mut here = Trivia::default();
        while let Some(comment) = comments.next_if(|c| c.start < start) {
            let breaks = lines(end, comment.start);
            here.newline |= breaks > 0;
            match all.last_mut() {
                Some(last) if breaks == 0 => last.after = Some(comment.text),
                _ => here.before.push(Note { text: comment.text, blank: breaks > 1 }),
            }
            end = comment.start + comment.text.len();
        }
        let breaks = lines(end, start);
        here.newline |= breaks > 0;
        here.blank = breaks > 1;
        all.push(here);
        end = start + length;
    }
    all
}
