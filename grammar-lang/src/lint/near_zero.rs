//! Actuations that divide by a varied quantity which may be zero.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Actuation, Expr, ExprKind, Operator};
use crate::units::shown;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for actuation in known.ruleset.actuations.values() {
        for expr in actuation.values() {
            visit(actuation, expr, findings);
        }
    }
}

fn visit(actuation: &Actuation, expr: &Expr, findings: &mut Vec<Diagnostic>) {
    match &expr.kind {
        // A condition may keep the zero away.
        ExprKind::If(..) => return,
        ExprKind::Binary(_, Operator::Divide, divisor) => findings.extend(zero(actuation, divisor)),
        _ => {}
    }
    expr.each(&mut |inner| visit(actuation, inner, findings));
}

/// The finding of a divisor that is a variable, and may be zero.
fn zero(actuation: &Actuation, divisor: &Expr) -> Option<Diagnostic> {
    let variable = match &divisor.kind {
        // The actuator has the first slot.
        ExprKind::Local(slot) => actuation.variables.get(slot.checked_sub(1)?)?,
        ExprKind::Negate(inner) => return zero(actuation, inner),
        _ => return None,
    };
    let (low, high) = variable.domain;
    if low > 0.0 || high < 0.0 {
        return None;
    }
    let dimension = variable.ty.dimension().unwrap_or_default();
    let range = format!("{} .. {}", shown(low, dimension), shown(high, dimension));
    Some(
        Diagnostic::new(
            Code::NEAR_ZERO,
            divisor.span,
            format!("this divides by `{}`, which may be zero", variable.name),
        )
        .label(format!("its value lies within {range}"))
        .also(variable.span, "declared here")
        .help("begin its domain above zero: an evaluation that divides by zero has no value, and near zero the quotient is huge"),
    )
}
