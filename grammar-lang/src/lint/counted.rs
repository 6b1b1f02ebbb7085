//! Objectives that grow with the number of elements, and objectives that only the better one of several tasks counts for.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Direction, Expr, ExprKind, Function, Gather, MotionWord, Operator, Word};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let of_tasks = ruleset.tasks.values().flat_map(|task| task.objectives());
    for objective in of_tasks.chain(ruleset.objectives()) {
        let found = addends(known, &objective.value).into_iter().find_map(|value| {
            if objective.direction == Direction::Maximize && is_sum_over_elements(value) {
                return Some(more_elements(value));
            }
            let best = match objective.direction {
                Direction::Maximize => Function::Max,
                Direction::Minimize => Function::Min,
            };
            matches!(&value.kind, ExprKind::Call(function, given) if *function == best && given.iter().filter(|one| reads_task(one)).count() > 1)
                .then(|| better_task(value))
        });
        findings.extend(found.filter(|found| findings.iter().all(|known| known.span() != found.span())));
    }
}

/// What an objective consists of that makes it larger.
fn addends<'e>(known: &Known<'e>, value: &'e Expr) -> Vec<&'e Expr> {
    match &value.kind {
        ExprKind::Convert(x, _) => addends(known, x),
        ExprKind::Binary(a, Operator::Add, b) => [addends(known, a), addends(known, b)].concat(),
        ExprKind::Binary(a, Operator::Subtract, _) => addends(known, a),
        ExprKind::Aggregate { binders, body: Some(body), .. }
            if binders.iter().all(|binder| matches!(binder.over.kind, ExprKind::Scenarios(_))) =>
        {
            addends(known, body)
        }
        ExprKind::Term(name) => {
            known.ruleset.terms.get(name).map_or_else(Vec::new, |term| addends(known, &term.value))
        }
        _ => vec![value],
    }
}

fn is_sum_over_elements(value: &Expr) -> bool {
    let ExprKind::Aggregate { how: Gather::Sum, binders, condition: None, body: Some(body), .. } =
        &value.kind
    else {
        return false;
    };
    let all = |over: &Expr| matches!(over.kind, ExprKind::Word(Word::Motion(MotionWord::Elements)));
    binders.len() == 1
        && binders.iter().all(|binder| all(&binder.over))
        && body.any(&mut |e| {
            matches!(e.kind, ExprKind::Call(Function::Length | Function::Horizontal | Function::Abs, _))
        })
}

fn reads_task(value: &Expr) -> bool {
    value.any(&mut |e| matches!(e.kind, ExprKind::Task(_)))
}

fn more_elements(value: &Expr) -> Diagnostic {
    Diagnostic::new(Code::UNUSUAL, value.span, "this objective grows with the number of elements")
        .label("a body of twice as many pieces gets twice as much for the same motion")
        .help("write `mean` in the place of `sum`")
}

fn better_task(value: &Expr) -> Diagnostic {
    Diagnostic::new(Code::UNUSUAL, value.span, "only the task that a body does better counts")
        .label("a body that cannot do the other tasks is as good")
        .help("for a body that does all tasks, use the other of `min` and `max`, or add the values")
}
