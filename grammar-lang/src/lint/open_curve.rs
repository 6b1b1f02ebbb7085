//! Bezier curves that are driven round and round and end elsewhere than they begin.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Actuation, Expr, ExprKind, Function};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for actuation in known.ruleset.actuations.values() {
        let goes_round = actuation.values().any(|value| {
            value.any(&mut |e| matches!(&e.kind, ExprKind::Apply(_, place) if is_fraction(actuation, place)))
        });
        let open = actuation.lets.iter().find_map(|(_, value)| is_open(value).then_some(value));
        let Some(open) = open.filter(|_| goes_round) else { continue };
        findings.push(
            Diagnostic::new(Code::UNUSUAL, open.span, "this curve jumps where its cycle ends")
                .label("it ends at its last control point, not where it begins")
                .help("add the first control point at the end, as in `bezier(each(points, 3) + repeat(first(points), 3))`"),
        );
    }
}

/// Whether it is what remains of a number without its whole part, itself or as a value of the actuation.
fn is_fraction(actuation: &Actuation, place: &Expr) -> bool {
    match &place.kind {
        ExprKind::Call(Function::Fraction, _) => true,
        ExprKind::Local(slot) => {
            let first = actuation.first_action() + actuation.actions.len();
            let mut values = actuation.lets.iter().chain(&actuation.moving);
            let value = slot.checked_sub(first).and_then(|place| values.nth(place));
            value.is_some_and(|(_, value)| matches!(value.kind, ExprKind::Call(Function::Fraction, _)))
        }
        _ => false,
    }
}

/// A curve through the items of one list of different numbers, as they are.
fn is_open(value: &Expr) -> bool {
    let ExprKind::Call(Function::Bezier, given) = &value.kind else { return false };
    let [points] = given.as_slice() else { return false };
    match &points.kind {
        ExprKind::Local(_) => true,
        ExprKind::Call(Function::Each, given) => {
            given.first().is_some_and(|list| matches!(list.kind, ExprKind::Local(_)))
        }
        _ => false,
    }
}
