//! Named terms, and what expressions build on.

use crate::ir::MotionWord;
use std::collections::BTreeSet;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer};
use super::{Expr, ExprKind, Function, Group, Ty, Word};
use crate::source::Span;

/// A named term of an objective.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Its type.
    pub ty: Ty,
    /// Its value.
    pub value: Expr,
    /// Where it is declared.
    pub span: Span,
}

/// An expression, and then the terms that it builds on with their names, each once.
pub fn builds_on<'r>(
    expr: &'r Expr,
    terms: &'r IndexMap<String, Term>,
) -> impl Iterator<Item = (Option<&'r str>, &'r Expr)> {
    let mut known: BTreeSet<&str> = BTreeSet::new();
    let mut all = vec![(None, expr)];
    let mut next = 0;
    while let Some((_, expr)) = all.get(next).copied() {
        next += 1;
        expr.any(&mut |e| {
            if let ExprKind::Term(name) = &e.kind
                && let Some((name, term)) = terms.get_key_value(name)
                && known.insert(name)
            {
                all.push((Some(name.as_str()), &term.value));
            }
            false
        });
    }
    all.into_iter()
}

/// What bodies made of parts have, and lattices do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lacking {
    /// The core is the first element; the first of a lattice is any ball.
    Core,
    /// Actuators.
    Actuators,
}

/// Whether this is the first element.
fn is_core(expr: &Expr) -> bool {
    let is_all = |of: &Expr| matches!(of.kind, ExprKind::Word(Word::Motion(MotionWord::Elements)));
    matches!(&expr.kind, ExprKind::Call(Function::First, of) if of.iter().any(is_all))
}

/// What an expression reads that a lattice lacks, with the term that reads it if a term does. Whoever picks the first
/// element out of a list, as in `c in [first(elements)]`, only looks at the others from there: any would do.
#[must_use]
pub fn lacking<'r>(expr: &'r Expr, terms: &'r IndexMap<String, Term>) -> Option<(Lacking, Option<&'r str>)> {
    builds_on(expr, terms).find_map(|(name, expr)| {
        let mut found = None;
        expr.any(&mut |e| {
            found = match &e.kind {
                ExprKind::Attribute(of, _) | ExprKind::Bind { value: of, .. } => {
                    is_core(of).then_some(Lacking::Core)
                }
                ExprKind::Group(Group::Actuator) => Some(Lacking::Actuators),
                _ => None,
            };
            found.is_some()
        });
        Some((found?, name))
    })
}

impl Writer<'_> {
    pub(super) fn term(&mut self, name: &str, term: &Term) {
        let value = self.expr(&term.value, &Names::new());
        self.line(0, format!("term {name} : {} = {value}", term.ty));
    }
}
