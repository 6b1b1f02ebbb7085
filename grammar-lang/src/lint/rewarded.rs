//! Objectives that want what costs: work, or a spread between worlds.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Direction, Expr, ExprKind, Gather, Operator, PartAttribute};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for objective in known.ruleset.tasks.values().flat_map(|task| task.objectives()) {
        let wanted = objective.direction == Direction::Maximize;
        let mut addends = Vec::new();
        add(&objective.value, wanted, &mut addends);
        for addend in addends {
            let what = if is_work(known, addend) {
                Some((
                    "this objective wants the actuators to work as much as they can",
                    "work costs energy: subtract it, or write `minimize`",
                ))
            } else if is_spread(addend) {
                Some((
                    "this objective wants values that differ between worlds",
                    "a robust gait has a small deviation: subtract it",
                ))
            } else {
                None
            };
            if let Some((message, help)) = what {
                findings.push(
                    Diagnostic::new(Code::UNUSUAL, addend.span, message)
                        .label("the more, the better")
                        .help(help),
                );
            }
        }
    }
}

/// What an objective is the better for.
fn add<'e>(value: &'e Expr, wanted: bool, into: &mut Vec<&'e Expr>) {
    match &value.kind {
        ExprKind::Convert(x, _) => add(x, wanted, into),
        ExprKind::Negate(x) => add(x, !wanted, into),
        ExprKind::Binary(a, Operator::Add, b) => {
            add(a, wanted, into);
            add(b, wanted, into);
        }
        ExprKind::Binary(a, Operator::Subtract, b) => {
            add(a, wanted, into);
            add(b, !wanted, into);
        }
        ExprKind::Binary(a, Operator::Multiply, b) => {
            for (factor, of) in [(a, b), (b, a)] {
                if let ExprKind::Number(times) = factor.kind {
                    add(of, wanted == (times >= 0.0), into);
                }
            }
        }
        ExprKind::Aggregate {
            how: Gather::Min | Gather::Mean | Gather::Quantile, body: Some(body), ..
        } => {
            add(body, wanted, into);
        }
        _ if wanted => into.push(value),
        _ => {}
    }
}

/// Whether a value is the sum of the work of actuators, and nothing else.
fn is_work(known: &Known<'_>, value: &Expr) -> bool {
    match &value.kind {
        ExprKind::Term(name) => known.ruleset.terms.get(name).is_some_and(|term| is_work(known, &term.value)),
        ExprKind::Aggregate { how: Gather::Sum, body: Some(body), .. } => {
            matches!(&body.kind, ExprKind::Attribute(_, Attribute::Part(PartAttribute::Work)))
        }
        _ => false,
    }
}

/// Whether a value is a deviation over worlds.
fn is_spread(value: &Expr) -> bool {
    let of_worlds = |over: &Expr| matches!(over.kind, ExprKind::Scenarios(_));
    matches!(&value.kind, ExprKind::Aggregate { how: Gather::Deviation, binders, .. } if binders.iter().any(|binder| of_worlds(&binder.over)))
}
