//! Actuations whose drive is the same at all times.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Actuation, Expr, ExprKind, Ty, Word};

use super::known::Known;
use crate::units::Dimension;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, actuation) in &known.ruleset.actuations {
        let is_used =
            known.ruleset.tasks.values().any(|task| task.actuated.values().any(|with| with == name));
        if is_used && !changes(actuation) {
            findings.push(
                Diagnostic::new(
                    Code::STILL_DRIVE,
                    actuation.drive.span,
                    format!("`{name}` moves its actuators to one position and keeps them there"),
                )
                .label("does not read the time")
                .help("let it read `t`, as in `swing * sin(t / period * 360 deg)`"),
            );
        }
    }
}

/// Whether what an actuation drives to depends on the time.
fn changes(actuation: &Actuation) -> bool {
    // A cycle of valves says when each of them switches, and what turns at a steady speed moves.
    let speed = Ty::Quantity(Dimension::ANGULAR_VELOCITY);
    if actuation.drive.ty == Ty::Valves || actuation.drive.ty == speed {
        return true;
    }
    let reads_time =
        |expr: &Expr| expr.any(&mut |e| matches!(e.kind, ExprKind::Word(Word::Time | Word::Cycle)));
    let moving = actuation.moving.iter().map(|(_, value)| value);
    moving.chain([&actuation.drive]).any(reads_time)
}
