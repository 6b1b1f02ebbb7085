//! Phases of whole cycles, which shift nothing.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Actuation, Expr, ExprKind, Function, Operator};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    for (_, name) in rules.tasks.values().flat_map(|task| &task.actuated) {
        let Some(actuation) = rules.actuations.get(name) else { continue };
        for value in actuation.values() {
            value.any(&mut |part| {
                let ExprKind::Call(Function::Fraction, arguments) = &part.kind else { return false };
                let Some(whole) = arguments.first().and_then(|sum| shift(actuation, sum)) else {
                    return false;
                };
                if findings.iter().all(|known| known.span() != whole.span) {
                    findings.push(
                        Diagnostic::new(
                            Code::POINTLESS,
                            whole.span,
                            "this phase is always a whole number of cycles",
                        )
                        .label("it shifts nothing: `fraction` takes whole cycles away")
                        .help("half a cycle is `1 / 2`"),
                    );
                }
                false
            });
        }
    }
}

/// What is added to a cycle, if it is always a whole number, and not always zero.
fn shift<'e>(actuation: &'e Actuation, sum: &'e Expr) -> Option<&'e Expr> {
    let ExprKind::Binary(a, Operator::Add | Operator::Subtract, b) = &sum.kind else { return None };
    [a, b].into_iter().find_map(|part| {
        let part = resolved(actuation, part);
        let mut all = Vec::new();
        (leaves(part, &mut all) && all.iter().any(|x| *x != 0.0)).then_some(part)
    })
}

/// What a name of the actuation stands for.
fn resolved<'e>(actuation: &'e Actuation, value: &'e Expr) -> &'e Expr {
    let ExprKind::Local(slot) = value.kind else { return value };
    let first = 1 + actuation.variables.len() + actuation.states.len() + actuation.actions.len();
    let named = actuation.lets.iter().chain(&actuation.moving);
    let own = slot.checked_sub(first).and_then(|place| named.map(|(_, value)| value).nth(place));
    own.unwrap_or(value)
}

/// Adds the numbers that a value is one of; whether it is always one of these, and all are whole.
fn leaves(value: &Expr, into: &mut Vec<f64>) -> bool {
    match &value.kind {
        ExprKind::Number(x) => {
            into.push(*x);
            x.fract() == 0.0
        }
        ExprKind::If(_, yes, no) => leaves(yes, into) && leaves(no, into),
        _ => false,
    }
}
