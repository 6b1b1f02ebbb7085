//! Edits of one variant that would undo each other.

use std::collections::BTreeMap;

use super::super::declared;
use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;
use crate::syntax::ast::{Edit, EditKind};

/// What a variant does with each declaration: where it drops or replaces the whole, and where it first changes a part.
#[derive(Default)]
pub(super) struct Heads<'v> {
    whole: BTreeMap<&'v str, (Span, &'static str)>,
    part: BTreeMap<&'v str, Span>,
}

impl<'v> Heads<'v> {
    /// The error of an edit of a part where another takes the whole away, or the other way round: one of them would be lost.
    pub(super) fn clash(&mut self, edit: &'v Edit, span: Span) -> Option<Diagnostic> {
        let (head, part, whole) = match &edit.kind {
            EditKind::Drop(path) => match path.as_slice() {
                [head] => (&head.text, None, Some((span, "dropped"))),
                [head, ..] => (&head.text, Some(span), None),
                [] => return None,
            },
            EditKind::Set(path, _) | EditKind::SetJoint(path, _) | EditKind::Narrow(path, _) => {
                match path.as_slice() {
                    [head, _, ..] => (&head.text, Some(span), None),
                    _ => return None,
                }
            }
            EditKind::Replace(item) => (&declared(item)?.text, None, Some((span, "replaced"))),
            EditKind::DropObserved(_) | EditKind::Allow(_) | EditKind::Add(_) => return None,
        };
        let known = |part: Option<Span>, whole: Option<(Span, &'static str)>| Some((part?, whole?));
        let clash = known(part, self.whole.get(head.as_str()).copied())
            .or_else(|| known(self.part.get(head.as_str()).copied(), whole));
        if let Some(part) = part {
            self.part.entry(head).or_insert(part);
        }
        if let Some(whole) = whole {
            self.whole.entry(head).or_insert(whole);
        }
        let (part, (whole, word)) = clash?;
        let help = match word {
            "dropped" => "remove one of the two edits".to_owned(),
            _ => format!("make this change in the `{head}` that replaces it"),
        };
        Some(
            Diagnostic::new(
                Code::DUPLICATE,
                part,
                format!("this variant changes a part of `{head}`, but the whole declaration is also {word}"),
            )
            .label("this change would be lost")
            .also(whole, format!("{word} here"))
            .help(help),
        )
    }
}
