//! Which names an expression reads.

use super::ast::{Expr, ExprKind};
use crate::source::Span;

impl Expr {
    /// Calls `told` with each name that it reads and its place.
    pub fn each_name(&self, told: &mut impl FnMut(&str, Span)) {
        let mut next = vec![self];
        while let Some(expr) = next.pop() {
            match &expr.kind {
                ExprKind::Quantity(..) | ExprKind::Text(_) | ExprKind::Bool(_) => {}
                ExprKind::Name(name) => told(name, expr.span),
                ExprKind::Member(of, _)
                | ExprKind::Convert(of, _)
                | ExprKind::Negate(of)
                | ExprKind::Not(of) => {
                    next.push(of);
                }
                ExprKind::Call(callee, arguments) => {
                    next.push(callee);
                    next.extend(arguments.iter().map(|argument| &argument.value));
                }
                ExprKind::Index(a, b)
                | ExprKind::At(a, b)
                | ExprKind::Binary(a, _, b)
                | ExprKind::Narrowed(a, b)
                | ExprKind::Exchanged(a, b)
                | ExprKind::Range(a, b) => next.extend([&**a, &**b]),
                ExprKind::If(a, b, c) => next.extend([&**a, &**b, &**c]),
                ExprKind::Cases(of, cases, otherwise) => {
                    next.push(of);
                    next.extend(cases.iter().flat_map(|(case, value)| [case, value]));
                    next.extend(otherwise.as_deref());
                }
                ExprKind::Aggregate { share, binders, condition, body, otherwise, .. } => {
                    next.extend(binders.iter().map(|binder| &binder.over));
                    next.extend(
                        [share, condition, body, otherwise].into_iter().filter_map(|part| part.as_deref()),
                    );
                }
                ExprKind::Set(items) | ExprKind::List(items) => next.extend(items),
            }
        }
    }
}
