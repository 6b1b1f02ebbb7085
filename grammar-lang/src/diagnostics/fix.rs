//! Mends that a program can make.

use std::collections::BTreeSet;

use crate::source::Span;

/// One replacement; an empty span inserts, an empty replacement removes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// What is replaced.
    pub span: Span,
    /// By what.
    pub replacement: String,
}

/// Edits that belong together and mend one finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What is done, as an order: "write `2 mm`".
    pub message: String,
    /// The edits; they do not overlap.
    pub edits: Vec<Edit>,
}

impl Fix {
    /// Replaces one stretch of text.
    pub fn replace(span: Span, replacement: impl Into<String>, message: impl Into<String>) -> Self {
        Self { message: message.into(), edits: vec![Edit { span, replacement: replacement.into() }] }
    }

    /// Inserts text behind a stretch.
    pub fn insert_after(span: Span, text: impl Into<String>, message: impl Into<String>) -> Self {
        Self::replace(Span { start: span.end, ..span }, text, message)
    }

    /// Replaces one more stretch of text.
    #[must_use]
    pub fn and(mut self, span: Span, replacement: impl Into<String>) -> Self {
        self.edits.push(Edit { span, replacement: replacement.into() });
        self
    }
}

/// A text after edits, all of which are of this text; `None` if two of them overlap or one lies
/// outside the text.
#[must_use]
pub fn apply<'a>(text: &str, edits: impl IntoIterator<Item = &'a Edit>) -> Option<String> {
    let mut edits: Vec<&Edit> = edits.into_iter().collect();
    edits.sort_by_key(|e| (e.span.start, e.span.end));
    let mut out = String::with_capacity(text.len());
    let mut done = 0;
    let mut last: Option<&Edit> = None;
    for edit in edits {
        // Two insertions at one place have no order: they overlap, too.
        if last.is_some_and(|l| l.span == edit.span) {
            return None;
        }
        let range = edit.span.range();
        out.push_str(text.get(done..range.start)?);
        // The stretch must exist and begin and end between characters.
        text.get(range.clone())?;
        out.push_str(&edit.replacement);
        done = range.end;
        last = Some(edit);
    }
    out.push_str(text.get(done..)?);
    Some(out)
}

/// Edits of one text that can be applied together.
#[derive(Clone, Debug, Default)]
pub struct Together {
    /// The stretches that they change.
    taken: BTreeSet<(u32, u32)>,
}

impl Together {
    /// Adds edits, if they can be applied together with those that are there.
    pub fn add(&mut self, text: &str, edits: &[Edit]) -> bool {
        for (i, edit) in edits.iter().enumerate() {
            let stretch = (edit.span.start, edit.span.end);
            let before = self.taken.range(..stretch).next_back().is_none_or(|(_, end)| *end <= stretch.0);
            let after = self.taken.range(stretch..).next().is_none_or(|(start, _)| stretch.1 <= *start);
            // Two insertions at one place overlap, too.
            let free =
                before && after && !self.taken.contains(&stretch) && text.get(edit.span.range()).is_some();
            if !free {
                for edit in edits.iter().take(i) {
                    self.taken.remove(&(edit.span.start, edit.span.end));
                }
                return false;
            }
            self.taken.insert(stretch);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::FileId;

    fn edit(start: usize, end: usize, replacement: &str) -> Edit {
        Edit { span: Span::new(FileId(0), start, end), replacement: replacement.into() }
    }

    #[test]
    fn edits_apply_in_any_order_but_never_on_top_of_each_other() {
        let text = "6 .. 3";
        let swap = [edit(5, 6, "6"), edit(0, 1, "3")];
        assert_eq!(apply(text, &swap).as_deref(), Some("3 .. 6"));
        assert_eq!(apply(text, &[edit(1, 1, " mm")]).as_deref(), Some("6 mm .. 3"));
        assert_eq!(apply(text, &[edit(0, 2, "x"), edit(1, 3, "y")]), None);
        assert_eq!(apply(text, &[edit(1, 1, "x"), edit(1, 1, "y")]), None);
        assert_eq!(apply(text, &[edit(5, 9, "x")]), None);
        assert_eq!(apply("µ", &[edit(1, 2, "x")]), None);
    }

    proptest::proptest! {
        /// Edits are found to go together one by one exactly where they can be applied at once.
        #[test]
        fn what_goes_together_can_be_applied(stretches in proptest::collection::vec((0usize..7, 0usize..3), 0..6)) {
            let text = "aµbcde";
            let (mut together, mut chosen) = (Together::default(), Vec::new());
            for (start, length) in stretches {
                let pair = [edit(start, start + length, "x"), edit(start + 2, start + 2, "y")];
                let with: Vec<Edit> = chosen.iter().chain(&pair).cloned().collect();
                let fits = apply(text, &with).is_some();
                proptest::prop_assert_eq!(together.add(text, &pair), fits, "{:?}", with);
                if fits {
                    chosen = with;
                }
            }
        }
    }
}
