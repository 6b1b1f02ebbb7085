//! Bodies of which no part has friction, and slopes that all slide down.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{Difference, Field, Group, Kind, RuleSet, Scenarios, Task};
use crate::units::{Dimension, shown};

use super::instances::made;
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    // Balls of a lattice have friction of their own.
    if ruleset.lattice.is_some() {
        return;
    }
    let parts = ruleset.parts.iter().map(|(name, part)| (name, &part.friction, part.span));
    let actuators =
        ruleset.actuators.iter().map(|(name, actuator)| (name, &actuator.friction, actuator.span));
    let mut possible =
        parts.chain(actuators).filter(|(name, ..)| known.possible.contains(&Group::Kind((*name).clone())));
    if let Some((_, first, place)) = possible.next()
        && is_none(first)
        && possible.all(|(_, friction, _)| is_none(friction))
    {
        findings.push(
            Diagnostic::new(Code::NO_GRIP, place, "no part of a robot has friction: it cannot push off the ground")
                .label("slides as on ice, like all other parts")
                .help("measure the friction on a board that you tilt: the friction is `tan(angle)`, where `angle` is the tilt at which the part begins to slide"),
        );
    }
}

/// Worlds so steep that whatever touches the ground slides down.
pub(super) fn slopes(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    let Some(part) = greatest_friction(known) else { return };
    for task in rules.tasks.values() {
        let Some(within) = &task.scenarios else { continue };
        let Some(set) = rules.scenarios.get(&within.name) else { continue };
        let Some((slope, grip)) = too_steep(set, task, part) else { continue };
        let angle = |x: f64| shown(x.to_degrees().round().to_radians(), Dimension::ANGLE);
        findings.push(
            Diagnostic::new(
                Code::NO_GRIP,
                set.span,
                format!("on a slope of {} all robots of this grammar slide", angle(slope)),
            )
            .label(format!(
                "with the greatest friction here, robots can stand on a slope of at most {}",
                angle(libm::atan(grip))
            ))
            .help("is the unit of `slope` right? Make it less steep, or give the parts more friction"),
        );
    }
}

/// The steepest slope of a set of worlds, and the greatest coefficient of a contact there, if every contact slides.
fn too_steep(set: &Scenarios, task: &Task, part: f64) -> Option<(f64, f64)> {
    let most = |difference: Difference, usual: f64| {
        set.ranges.get(&difference).map_or(usual, |(low, high)| high.abs().max(low.abs()))
    };
    let grip = |factor: f64, ground: f64| (part * ground).sqrt() * factor;
    let ground = task.model.ground_friction;
    let drawn = (
        most(Difference::Slope, 0.0),
        grip(most(Difference::Friction, 1.0), most(Difference::GroundFriction, ground)),
    );
    let cases = set.cases.values().map(|case| {
        let value = |difference: Difference, usual: f64| case.get(&difference).copied().unwrap_or(usual);
        let grip = grip(value(Difference::Friction, 1.0), value(Difference::GroundFriction, ground));
        (value(Difference::Slope, 0.0).abs(), grip)
    });
    cases.chain([drawn]).find(|(slope, grip)| libm::tan(*slope) > *grip)
}

/// The greatest friction that a part can have; none where not all that can be is known. A lattice has balls with friction of their own.
fn greatest_friction(known: &Known<'_>) -> Option<f64> {
    let rules: &RuleSet = known.ruleset;
    let blocks = rules.parts.iter().map(|(name, part)| (name, Kind::Block(part)));
    let actuators = rules.actuators.iter().map(|(name, actuator)| (name, Kind::Actuator(actuator)));
    if rules.lattice.is_some() {
        return None;
    }
    let mut greatest = None;
    for (_, kind) in
        blocks.chain(actuators).filter(|(name, _)| known.possible.contains(&Group::Kind((*name).clone())))
    {
        let frictions: Option<Vec<f64>> = made(known, kind)
            .map(|(_, made)| match made.ok()? {
                Made::Block(block) => Some(block.friction),
                Made::Actuator(actuator) => Some(actuator.friction),
                Made::Cell(cell) => Some(cell.friction),
            })
            .collect();
        // Of too many parameters not all are tried.
        let most = frictions?.into_iter().reduce(f64::max)?;
        greatest = Some(greatest.map_or(most, |known: f64| known.max(most)));
    }
    greatest
}

/// Whether parts of a kind never have friction.
fn is_none(friction: &Field<f64>) -> bool {
    friction.fixed() == Some(&0.0)
}
