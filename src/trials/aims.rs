//! Objectives that are the same for all motions.

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::ir::{Expr, ExprKind, Function, Objective, Operator, RuleSet};

use super::Trials;
use crate::score::quantities;

/// So many motions are compared, at least.
const ENOUGH: usize = 4;
/// Values that differ by less, in the unit of the objective, are the same: rounding grows in a motion.
const SAME: f64 = 1e-4;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let Some(first) = trials.trials.first() else { return Vec::new() };
    let (task, rules) = (first.drive.task(), first.drive.candidate().rules);
    task.objectives().filter(|objective| !has_steps(rules, &objective.value)).filter_map(|one| same(trials, one)).collect()
}

fn same(trials: &Trials<'_>, objective: &Objective) -> Option<Diagnostic> {
    let values: Vec<f64> =
        trials.recordings().filter_map(|recording| quantities(recording, &[&objective.value]).ok()?.pop()).collect();
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    if values.len() < ENOUGH || !(high - low <= SAME) {
        return None;
    }
    Some(
        Diagnostic::new(
            Code::CONSTANT_AIM,
            objective.value.span,
            "this objective does not depend on how the robot moves",
        )
        .label(format!("the same in {} short motions of different bodies or curves", values.len()))
        .help("what can change it? In the mirror of `symmetry`, the core stays in the plane of the mirror if both sides move alike; y points up"),
    )
}

/// Whether a short motion may have the same value as another although a longer one has not: it is compared, limited or counted.
fn has_steps(rules: &RuleSet, value: &Expr) -> bool {
    value.any(&mut |e| match &e.kind {
        ExprKind::If(..) | ExprKind::Not(_) | ExprKind::Table(_) | ExprKind::Task(_) | ExprKind::Bool(_) => true,
        ExprKind::Aggregate { condition, body, .. } => condition.is_some() || body.is_none(),
        ExprKind::Binary(_, operator, _) => {
            !matches!(operator, Operator::Add | Operator::Subtract | Operator::Multiply | Operator::Divide)
        }
        ExprKind::Call(function, _) => !matches!(function, Function::Abs | Function::Sqrt),
        ExprKind::Term(name) => rules.terms.get(name).is_none_or(|term| has_steps(rules, &term.value)),
        _ => false,
    })
}
