//! What no motion can do whose two halves mirror each other: gain by some objectives, and steer.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::{Actuation, Attribute, Axis, Direction, ElementAttribute, Expr, ExprKind, Symmetry};

use super::aims::gained;
use super::{Moved, Trial, Trials, odd};
use crate::design::assembly::Travel;

/// So many motions are looked at, at least.
const ENOUGH: usize = 4;
/// A joint turns within a plane if the cosine of the angle between its axis and the normal is larger.
const WITHIN: f64 = 0.999;
/// Targets that differ by less are the same, to rounding, rad, m or rad/s.
const SAME: f64 = 1e-9;

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    let rules = trials.whole;
    let Symmetry::Mirror(normal) = rules.symmetry else { return None };
    let moved =
        || trials.trials.iter().flat_map(|trial| trial.motions.iter().map(move |moved| (trial, moved)));
    if moved().count() < ENOUGH || !moved().all(|(trial, moved)| is_symmetric(trial, moved, normal)) {
        return None;
    }
    let task = trials.trials.first()?.drive.task();
    let objective = task.objectives().find(|objective| objective.direction == Direction::Maximize)?;
    let names = gained(objective)?;
    let (name, what) = names.into_iter().find_map(|name| {
        let value = &rules.terms.get(name)?.value;
        // The mirror stands upright unless its normal is y.
        let cannot = if normal != 1 && reads(value, &Attribute::Element(ElementAttribute::Yaw)) {
            "cannot turn"
        } else if normal == 0 && reads(value, &Attribute::Axis(Axis::X)) {
            "cannot go forward"
        } else {
            return None;
        };
        Some((name, cannot))
    })?;
    let plane = ["yz", "xz", "xy"].get(normal)?;
    Some(
        odd(objective.value.span, format!("a robot whose two halves move alike {what}: `{name}` gains nothing"))
            .label(format!("`symmetry mirror {plane}`, and all images do what their originals do"))
            .help(if normal == 0 {
                "`mirror xy` separates left from right; or let the drive of an image differ, as in `if a.image > 0 then -1 else 1`"
            } else {
                "let the drive of an image differ, as in `if a.image > 0 then -1 else 1`"
            }),
    )
}

/// Wheels of both sides of a mirror that are driven against each other.
pub(super) fn against_each_other(trials: &Trials<'_>) -> Option<Diagnostic> {
    let rules = trials.whole;
    if !matches!(rules.symmetry, Symmetry::Mirror(_)) {
        return None;
    }
    let task = trials.trials.first()?.drive.task();
    let turns = |value: &Expr| reads(value, &Attribute::Element(ElementAttribute::Yaw));
    let is_for_turns = task.objectives().any(|objective| {
        objective.value.any(&mut |e| match &e.kind {
            ExprKind::Term(name) => rules.terms.get(name).is_none_or(|term| turns(&term.value)),
            _ => turns(e),
        })
    });
    if is_for_turns {
        return None;
    }
    let (mut pairs, mut driven) = (0, None);
    for trial in &trials.trials {
        let candidate = trial.drive.candidate();
        let actuators = &candidate.body.actuators;
        let dofs = || candidate.body.assembly.joints.iter().flat_map(|joint| joint.kind.dofs());
        for (place, name, span) in trial.drive.driven_ahead() {
            let part = actuators.get(place).and_then(|id| candidate.design().parts.get(id));
            let own = part.and_then(|part| actuators.iter().position(|id| Some(*id) == part.image_of));
            let Some(own) = own.filter(|_| dofs().any(|dof| dof.is_spun() && dof.actuator() == Some(place)))
            else {
                continue;
            };
            for moved in &trial.motions {
                let targets = &moved.law.targets;
                let at =
                    |actuator: usize| targets.angles.iter().skip(actuator).step_by(targets.actuators.max(1));
                let opposite = at(place).zip(at(own)).all(|(a, b)| (a + b).abs() < SAME);
                let turns = at(place).any(|a| a.abs() > SAME);
                if !opposite || !turns {
                    return None;
                }
                pairs += 1;
                driven = Some((name, span));
            }
        }
    }
    let (name, span) = driven.filter(|_| pairs >= ENOUGH)?;
    Some(
        odd(span, format!("`{name}` drives the motors of both sides against each other"))
            .label("an image always turns the other way than its original")
            .help("an image is mirrored already: with the same speed, the wheels of both sides roll forward together"),
    )
}

/// Drives that react to a heading in the same way on both sides: the halves go on mirroring each other, and nothing turns the robot back.
pub(super) fn steers_alike(trials: &Trials<'_>) -> Option<Diagnostic> {
    let rules = trials.whole;
    // The mirror stands upright unless its normal is y.
    if !matches!(rules.symmetry, Symmetry::Mirror(normal) if normal != 1) {
        return None;
    }
    let is_in_pairs = |trial: &Trial<'_>| {
        let candidate = trial.drive.candidate();
        let parts = &candidate.design().parts;
        let original = |id| parts.get(id).and_then(|part| part.image_of);
        let actuators = &candidate.body.actuators;
        parts.values().all(|part| !part.alone)
            && actuators.iter().all(|id| {
                original(id).is_some() || actuators.iter().any(|other| original(other) == Some(*id))
            })
    };
    if !trials.trials.iter().all(is_in_pairs) || rules.actuations.values().any(knows_its_side) {
        return None;
    }
    let mut values = rules.actuations.values().flat_map(Actuation::values);
    let value = values.find(|value| rules.knows_a_side(value))?;
    Some(
        odd(value.span, "both sides of the robot react alike to its heading".to_owned())
            .label("an image does what its original does, so nothing turns the robot back")
            .help("let the sign differ between the sides: multiply the heading by `(if a.image > 0 then -1 else 1)`"),
    )
}

/// Whether an actuator of one side may do something else than that of the other.
fn knows_its_side(actuation: &Actuation) -> bool {
    let reads_itself = |value: &Expr| {
        value.any(&mut |e| match &e.kind {
            ExprKind::Attribute(of, attribute) => {
                of.kind == ExprKind::Local(0) && !matches!(attribute, Attribute::Track(_))
            }
            _ => false,
        })
    };
    let begun = actuation.states.iter().map(|state| &state.from);
    !actuation.actions.is_empty() || actuation.values().chain(begun).any(reads_itself)
}

fn reads(value: &Expr, wanted: &Attribute) -> bool {
    value.any(&mut |e| matches!(&e.kind, ExprKind::Attribute(_, attribute) if attribute == wanted))
}

/// Whether each actuator has an image that is asked for the same, or turns within the plane of the mirror.
fn is_symmetric(trial: &Trial<'_>, moved: &Moved<'_>, normal: usize) -> bool {
    let candidate = trial.drive.candidate();
    let turns_within = |actuator: usize| {
        let joints = candidate.body.assembly.joints.iter().flat_map(|joint| joint.kind.dofs());
        let mut own = joints.filter(|dof| dof.actuator() == Some(actuator));
        own.all(|dof| dof.travel == Travel::Turn && dof.axis[normal].abs() > WITHIN)
    };
    let parts = &candidate.design().parts;
    let actuators = &candidate.body.actuators;
    let targets = &moved.law.targets;
    let original = |id| parts.get(id).and_then(|part| part.image_of);
    let does_as = |image: usize, own: usize| {
        let at = |actuator: usize| targets.angles.iter().skip(actuator).step_by(targets.actuators);
        at(image).zip(at(own)).all(|(a, b)| (a - b).abs() < SAME)
    };
    let has_image = |id| actuators.iter().any(|other| original(other) == Some(id));
    !moved.law.is_closed_loop()
        && parts.values().all(|part| !part.alone)
        && actuators.iter().enumerate().all(|(place, id)| match original(id) {
            Some(own) => {
                actuators.iter().position(|other| *other == own).is_some_and(|own| does_as(place, own))
            }
            None => has_image(*id) || turns_within(place),
        })
}
