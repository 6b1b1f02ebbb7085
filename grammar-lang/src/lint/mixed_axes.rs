//! A difference of places that takes another component of one than of the other: mostly a slip of a copied line.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Axis, Expr, ExprKind, Operator, Track};

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for scoped in places(known) {
        for expr in scoped.exprs {
            expr.any(&mut |e| {
                if let ExprKind::Binary(a, Operator::Subtract, b) = &e.kind
                    && let Some((one, other)) = component(a).zip(component(b))
                    && one != other
                {
                    let (one, other) = (Attribute::Axis(one), Attribute::Axis(other));
                    let (one, other) = (one.text(), other.text());
                    findings.push(
                        Diagnostic::new(
                            Code::POINTLESS,
                            e.span,
                            format!("this subtracts the {other} of one place from the {one} of another"),
                        )
                        .label("two directions")
                        .help(format!(
                            "how far something went along {one} is `(core.position at end).{one} - (core.position at start).{one}`"
                        )),
                    );
                }
                false
            });
        }
    }
}

/// Which component of a place at a time an expression is.
fn component(e: &Expr) -> Option<Axis> {
    let ExprKind::Attribute(of, Attribute::Axis(axis)) = &e.kind else { return None };
    let ExprKind::At(place, _) = &of.kind else { return None };
    matches!(place.kind, ExprKind::Attribute(_, Attribute::Track(Track::Position))).then_some(*axis)
}
