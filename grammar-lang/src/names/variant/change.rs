//! What a variant does with a value of its base.

use crate::syntax::ast::{Expr, ExprKind};

/// What is done with a value.
pub(super) enum Change<'a> {
    Set(&'a Expr),
    Narrow(&'a Expr),
}

impl Change<'_> {
    /// The value that stands in the variant.
    pub(super) fn expr(&self) -> &Expr {
        match self {
            Self::Set(e) | Self::Narrow(e) => e,
        }
    }

    /// Gives an expression its new form.
    pub(super) fn make(&self, old: &Expr) -> Expr {
        match self {
            Self::Set(new) => (*new).clone(),
            Self::Narrow(new) => Expr {
                kind: ExprKind::Narrowed(Box::new((*new).clone()), Box::new(old.clone())),
                span: new.span,
            },
        }
    }

    /// The word of the edit.
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::Set(_) => "set",
            Self::Narrow(_) => "narrow",
        }
    }
}
