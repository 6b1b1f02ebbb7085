//! Where an expression stands, and which names it can read there.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::stage::Stage;
use crate::ir::{Expr, ExprKind, Group, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Name};

/// A name that only part of a declaration can read.
#[derive(Clone, Debug)]
pub(in crate::types) struct Local {
    pub(in crate::types) name: String,
    pub(in crate::types) ty: Ty,
    pub(in crate::types) span: Span,
    /// Whether a name below may mean something else.
    pub(in crate::types) may_be_hidden: bool,
}

impl Local {
    /// One that no other name hides.
    pub(in crate::types) fn new(name: impl Into<String>, ty: Ty, span: Span) -> Self {
        Self { name: name.into(), ty, span, may_be_hidden: false }
    }

    /// The same slot for a text that does not know the name.
    pub(in crate::types) fn hidden(&self) -> Self {
        Self { name: String::new(), ..self.clone() }
    }
}

/// Where an expression stands.
#[derive(Clone, Debug)]
pub(in crate::types) struct Context {
    /// When it is evaluated.
    pub(in crate::types) stage: Stage,
    /// Names by slot.
    pub(in crate::types) locals: Vec<Local>,
    /// Whether clauses around it were lost, so that unknown names mean nothing.
    pub(in crate::types) damaged: bool,
    /// The other fields of the part around it, which it can read by their names.
    pub(in crate::types) fields: OwnFields,
}

/// The fields of a part, for those that read others of them.
#[derive(Clone, Debug, Default)]
pub(in crate::types) struct OwnFields {
    /// All of them.
    pub(in crate::types) all: Rc<[(Name, ast::Expr)]>,
    /// Those that read themselves in the end, which has been told.
    pub(in crate::types) circular: Rc<BTreeSet<String>>,
    /// How many locals all of them know: the parameters of the part.
    pub(in crate::types) params: usize,
}

impl Context {
    pub(in crate::types) fn new(stage: Stage, damaged: bool) -> Self {
        Self { stage, locals: Vec::new(), damaged, fields: OwnFields::default() }
    }
}

pub(in crate::types) fn unknown(span: Span) -> Expr {
    Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span }
}

/// A kind of part used as the collection of its parts.
pub(super) fn as_group(expr: &Expr) -> Option<Expr> {
    match &expr.kind {
        ExprKind::Kind(name, params) if params.is_empty() => {
            Some(Expr { kind: ExprKind::Group(Group::Kind(name.clone())), ty: Ty::Group, span: expr.span })
        }
        _ => None,
    }
}
