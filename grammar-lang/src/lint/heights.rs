//! Objectives that gain by a height: mostly the wrong axis, or a fall that is added where it should be subtracted.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Axis, Direction, Expr, ExprKind, Function, Gather, Operator, RuleSet, Track};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let of_tasks = ruleset.tasks.values().flat_map(|task| task.objectives());
    let gained = of_tasks.filter(|objective| objective.direction == Direction::Maximize);
    for objective in gained {
        for one in summands(&objective.value) {
            let (name, value) = match &one.kind {
                ExprKind::Term(name) => match ruleset.terms.get(name) {
                    Some(term) => (Some(name), &term.value),
                    None => continue,
                },
                _ => (None, one),
            };
            let is_told = findings.iter().any(|known| known.span() == one.span);
            if !is_told && is_height(ruleset, value) {
                let what = name.map_or("this objective".to_owned(), |name| format!("`{name}`"));
                findings.push(
                    Diagnostic::new(
                        Code::UNUSUAL,
                        one.span,
                        format!("{what} is a difference of heights, and the objective gains by it"),
                    )
                    .label("y points up")
                    .help("forward is x, and `fall` is subtracted: `travel - fall`"),
                );
            }
        }
    }
}

/// What an objective adds up.
fn summands(value: &Expr) -> Vec<&Expr> {
    match &value.kind {
        ExprKind::Convert(x, _) | ExprKind::Binary(x, Operator::Subtract, _) => summands(x),
        ExprKind::Binary(a, Operator::Add, b) => [summands(a), summands(b)].concat(),
        ExprKind::Aggregate {
            how: Gather::Min | Gather::Mean | Gather::Quantile, body: Some(body), ..
        } => summands(body),
        _ => vec![value],
    }
}

/// Whether an expression reads positions at two fixed times, and only their heights.
fn is_height(ruleset: &RuleSet, value: &Expr) -> bool {
    let mut times = Vec::new();
    let mut other = false;
    let mut heights = 0;
    value.any(&mut |e| {
        match &e.kind {
            ExprKind::At(what, time) => {
                let of_position =
                    matches!(&what.kind, ExprKind::Attribute(_, Attribute::Track(Track::Position)));
                let is_fixed = !time.any(&mut |e| matches!(e.kind, ExprKind::Local(_)));
                other |= !of_position || !is_fixed;
                if !times.contains(&time.kind) {
                    times.push(time.kind.clone());
                }
            }
            ExprKind::Attribute(_, Attribute::Axis(axis)) => {
                heights += usize::from(*axis == Axis::Y);
                other |= *axis != Axis::Y;
            }
            ExprKind::Call(Function::Height, _) => heights += 1,
            // Whatever else makes a number of a position, or of the rest of a motion.
            ExprKind::Call(
                Function::Length
                | Function::Horizontal
                | Function::Bearing
                | Function::Angle
                | Function::Heading,
                _,
            )
            | ExprKind::Attribute(_, Attribute::Element(_)) => other = true,
            ExprKind::Term(name) => {
                other |= ruleset.terms.get(name).is_none_or(|term| !is_height(ruleset, &term.value))
            }
            _ => {}
        }
        false
    });
    heights > 0 && times.len() == 2 && !other
}
