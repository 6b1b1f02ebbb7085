//! Bodies of which no part has friction.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Field, Group};

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
                .help("measure the friction on a board that you tilt: at the angle at which the part begins to slide, it is `tan(angle)`"),
        );
    }
}

/// Whether parts of a kind never have friction.
fn is_none(friction: &Field<f64>) -> bool {
    friction.fixed() == Some(&0.0)
}
