//! What a variant does with a value of its base.

use std::cell::Cell;

use crate::source::Span;
use crate::syntax::ast::{Expr, ExprKind};

/// What is done with a value.
pub(super) enum Change<'a> {
    /// Another value, and where the one stood whose place it took.
    Set(&'a Expr, &'a Cell<Option<Span>>),
    Narrow(&'a Expr),
}

impl Change<'_> {
    /// The value that stands in the variant.
    pub(super) fn expr(&self) -> &Expr {
        match self {
            Self::Set(e, _) | Self::Narrow(e) => e,
        }
    }

    /// Gives an expression its new form.
    pub(super) fn make(&self, old: &Expr) -> Expr {
        match self {
            Self::Set(new, replaced) => {
                replaced.set(Some(old.span));
                (*new).clone()
            }
            Self::Narrow(new) => Expr {
                kind: ExprKind::Narrowed(Box::new((*new).clone()), Box::new(old.clone())),
                span: new.span,
            },
        }
    }

    /// The word of the edit.
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::Set(..) => "set",
            Self::Narrow(_) => "narrow",
        }
    }
}
