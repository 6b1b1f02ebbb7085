//! Sines that do not come round with their period: mostly one radian where a full turn was meant.

use std::f64::consts::PI;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Function, Operator, Word};
use crate::units::{Dimension, shown};

use super::known::Known;

/// Half turns are common: a squared or absolute sine repeats with them. What is so close to a whole number of them is one.
const CLOSE: f64 = 1e-3;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for actuation in known.ruleset.actuations.values() {
        let values = actuation.lets.iter().map(|(_, value)| value).chain([&actuation.drive]);
        for value in values {
            value.any(&mut |e| {
                let ExprKind::Call(function @ (Function::Sin | Function::Cos), given) = &e.kind else {
                    return false;
                };
                let turn = given.first().and_then(|angle| turn_of_period(known, angle));
                let half_turns = turn.unwrap_or_default().abs() / PI;
                if (half_turns - half_turns.round()).abs() > CLOSE {
                    findings.push(told(e, *function, half_turns * PI));
                }
                false
            });
        }
    }
}

fn told(sine: &Expr, function: Function, turn: f64) -> Diagnostic {
    Diagnostic::new(Code::UNUSUAL, sine.span, "this does not repeat with its period")
        .label(format!("it turns by {} in each period", shown(turn, Dimension::ANGLE)))
        .help(format!(
            "a full turn is `360 deg`: write for example `{}(t / period * 360 deg)`",
            function.text()
        ))
}

/// By what angle an expression grows while the time grows by what the time is divided by, if that is something that varies, rad.
fn turn_of_period(known: &Known<'_>, angle: &Expr) -> Option<f64> {
    match rate(known, angle)? {
        (turn, true) => Some(turn),
        (_, false) => None,
    }
}

/// By what an expression grows with the time, and whether the time is divided by something that varies.
fn rate(known: &Known<'_>, expr: &Expr) -> Option<(f64, bool)> {
    let constant = |e: &Expr| known.value(e).ok()?.as_number();
    match &expr.kind {
        ExprKind::Word(Word::Time) => Some((1.0, false)),
        ExprKind::Negate(x) => rate(known, x).map(|(rate, divided)| (-rate, divided)),
        ExprKind::Binary(a, Operator::Add | Operator::Subtract, b) => {
            rate(known, a).or_else(|| rate(known, b))
        }
        ExprKind::Binary(a, Operator::Multiply, b) => {
            let times = |(rate, divided): (f64, bool), by: &Expr| Some((rate * constant(by)?, divided));
            match (rate(known, a), rate(known, b)) {
                (Some(own), None) => times(own, b),
                (None, Some(own)) => times(own, a),
                _ => None,
            }
        }
        ExprKind::Binary(a, Operator::Divide, b) => {
            let (rate, divided) = rate(known, a)?;
            match constant(b) {
                Some(by) => Some((rate / by, divided)),
                None if !divided && matches!(b.kind, ExprKind::Local(_)) => Some((rate, true)),
                None => None,
            }
        }
        _ => None,
    }
}
