//! Actuations whose drive is the same at all times, or nearly.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Actuation, Expr, ExprKind, Ty, Word};

use super::instances::driven_range;
use super::known::{Actuated, Known};
use crate::bounds::actuation_locals;
use crate::units::Dimension;

/// A drive that moves an actuator by less than this share of its range might as well not.
const HARDLY: f64 = 0.03;

/// A cell that grows by so many times its size was meant to grow by as many per cent.
const GROWS: f64 = 5.0;
/// A cell keeps at least a tenth of its size.
const LEAST: f64 = -0.9;

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
                .help("let it read `t`, as in `swing * sin(t / period * 360 deg)`; if the position is meant to be fixed, write `allow W0738 because \"...\"` in the actuation"),
            );
        }
    }
    for actuation in known.ruleset.actuations.values().filter(|actuation| actuation.drive.ty == Ty::Valves) {
        let inflates = |expr: &Expr| expr.any(&mut |e| e.kind == ExprKind::Word(Word::Inflate));
        let vents = |expr: &Expr| expr.any(&mut |e| e.kind == ExprKind::Word(Word::Vent));
        if actuation.values().any(inflates) && !actuation.values().any(vents) {
            findings.push(
                Diagnostic::new(Code::STILL_DRIVE, actuation.drive.span, "no valve ever lets air out")
                    .label("without `vent` what is bent stays bent")
                    .help("write a cycle such as `cycle(period, share, [inflate, closed, vent, closed], phase)`"),
            );
        }
        if !actuation.values().any(inflates) {
            findings.push(
                Diagnostic::new(Code::STILL_DRIVE, actuation.drive.span, "no valve ever lets air in")
                    .label("without `inflate` nothing bends")
                    .help("write a cycle such as `cycle(period, share, [inflate, closed, vent, closed], phase)`"),
            );
        }
    }
    let mut told: Option<Diagnostic> = None;
    for actuated in known.actuated().filter(|actuated| changes(actuated.actuation)) {
        told = told.or_else(|| hardly_moves(known, &actuated));
    }
    findings.extend(told);
}

/// Strains that no soft material has.
pub(super) fn grows(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for (name, actuation) in &ruleset.actuations {
        let of_cells = ruleset.tasks.values().flat_map(|task| &task.actuated);
        if !{ of_cells }.any(|(kind, with)| with == name && ruleset.is_cell(kind)) {
            continue;
        }
        let asked = known.reasoning(&actuation_locals(&known.facts, actuation)).numbers(&actuation.drive);
        if asked.is_finite() && asked.low < LEAST {
            findings.push(
                Diagnostic::new(Code::UNUSUAL, actuation.drive.span, "a strain below -90 % is cut off")
                    .label(format!("down to {:.0} %", 100.0 * asked.low))
                    .help("a cell keeps at least a tenth of its size: let the drive ask for less, as in `20 % * sin(t / period * 360 deg)`"),
            );
        } else if asked.is_finite() && asked.high > GROWS {
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    actuation.drive.span,
                    "no soft material can be strained this far",
                )
                .label(format!("up to {:.0} %", 100.0 * asked.high))
                .help("is a percent sign missing? Write for example `20 % * sin(t / period * 360 deg)`"),
            );
        }
    }
}

/// A drive that moves an actuator by next to nothing of what it can, whatever it varies.
fn hardly_moves(known: &Known<'_>, actuated: &Actuated<'_>) -> Option<Diagnostic> {
    let &Actuated { kind, actuator, actuation, .. } = actuated;
    if actuation.drive.ty != Ty::Quantity(actuator.joint.kind.driven()) {
        return None;
    }
    let (low, high) = driven_range(known, actuator)?;
    let asked = known.reasoning(&actuation_locals(&known.facts, actuation)).numbers(&actuation.drive);
    let share = (asked.high - asked.low) / (high - low);
    (share < HARDLY).then(|| {
        Diagnostic::new(Code::STILL_DRIVE, actuation.drive.span, format!("this drive hardly moves `{kind}`"))
            .label(match share > 0.0 {
                true => format!(
                    "by at most {} % of its range",
                    crate::units::shown(100.0 * share, Dimension::default())
                ),
                false => "always to the same place".to_owned(),
            })
            .help("widen what the drive varies, or check the units")
    })
}

/// Whether what an actuation drives to depends on the time, or on what is measured or remembered.
fn changes(actuation: &Actuation) -> bool {
    // A cycle of valves says when each of them switches, and what turns at a steady speed moves.
    let speed = Ty::Quantity(Dimension::ANGULAR_VELOCITY);
    if actuation.drive.ty == Ty::Valves || actuation.drive.ty == speed || actuation.is_closed_loop() {
        return true;
    }
    let reads_time =
        |expr: &Expr| expr.any(&mut |e| matches!(e.kind, ExprKind::Word(Word::Time | Word::Cycle)));
    let moving = actuation.moving.iter().map(|(_, value)| value);
    moving.chain([&actuation.drive]).any(reads_time)
}
