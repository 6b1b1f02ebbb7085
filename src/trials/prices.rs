//! What an objective subtracts, if it counts far more than all it adds.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::{Direction, Expr, ExprKind, Gather, Objective, Operator};

use super::{Trials, odd};

/// So many motions have a value, at least.
const ENOUGH: usize = 4;
/// What is subtracted counts too much if in each short motion it is so many times as large as what is gained in any.
const FAR: f64 = 20.0;

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    trials.trials.first()?.drive.task().objectives().find_map(|objective| dear(trials, objective))
}

fn dear(trials: &Trials<'_>, objective: &Objective) -> Option<Diagnostic> {
    let addends = addends(&objective.value);
    let is_gained = |added: bool| added == (objective.direction == Direction::Maximize);
    let sizes = |value: &Expr| -> Vec<f64> { trials.values(value).into_iter().map(f64::abs).collect() };
    let gains: Vec<&Expr> =
        addends.iter().filter(|(added, _)| is_gained(*added)).map(|(_, value)| value).collect();
    let most: f64 = gains.iter().map(|value| sizes(value).into_iter().fold(0.0, f64::max)).sum();
    let (times, value) = addends.iter().filter(|(added, _)| !is_gained(*added)).find_map(|(_, value)| {
        let all = sizes(value);
        let least = all.iter().copied().fold(f64::MAX, f64::min);
        (all.len() >= ENOUGH && most > 0.0 && least > FAR * most).then_some((least / most, value))
    })?;
    Some(
        odd(value.span, "what this costs is far more than what the objective gains".to_owned())
            .label(format!(
                "at least {times:.0} times as much as all that is gained, in each of {} short motions",
                trials.recordings().count()
            ))
            .help("a robot that does nothing would be the best: give this a lower price, or check its unit"),
    )
}

/// What an expression adds up, each in whatever stands around the sum, and whether it is added or subtracted.
fn addends(expr: &Expr) -> Vec<(bool, Expr)> {
    match &expr.kind {
        ExprKind::Convert(x, unit) => {
            let around = |x: Expr| Expr { kind: ExprKind::Convert(Box::new(x), *unit), ..expr.clone() };
            addends(x).into_iter().map(|(added, x)| (added, Expr { span: x.span, ..around(x) })).collect()
        }
        ExprKind::Aggregate {
            how: Gather::Min | Gather::Mean | Gather::Quantile, body: Some(body), ..
        } => {
            let around = |x: Expr| {
                let mut whole = expr.clone();
                whole.span = x.span;
                if let ExprKind::Aggregate { body, .. } = &mut whole.kind {
                    *body = Some(Box::new(x));
                }
                whole
            };
            addends(body).into_iter().map(|(added, x)| (added, around(x))).collect()
        }
        ExprKind::Binary(a, Operator::Add, b) => [addends(a), addends(b)].concat(),
        ExprKind::Binary(a, Operator::Subtract, b) => {
            let taken = addends(b).into_iter().map(|(added, x)| (!added, x));
            addends(a).into_iter().chain(taken).collect()
        }
        _ => vec![(true, expr.clone())],
    }
}
