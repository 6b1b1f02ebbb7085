//! Bodies of which no part has friction.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Group;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    // Balls of a lattice have friction of their own.
    if ruleset.lattice.is_some() {
        return;
    }
    let parts = ruleset.parts.iter().map(|(name, part)| (name, part.friction, part.span));
    let actuators = ruleset.actuators.iter().map(|(name, actuator)| (name, actuator.friction, actuator.span));
    let mut possible =
        parts.chain(actuators).filter(|(name, ..)| known.possible.contains(&Group::Kind((*name).clone())));
    if let Some((_, first, place)) = possible.next()
        && first == 0.0
        && possible.all(|(_, friction, _)| friction == 0.0)
    {
        findings.push(
            Diagnostic::new(Code::NO_GRIP, place, "no part of a robot has friction: it cannot push off the ground")
                .label("slides as on ice, like all others")
                .help("measure it on a board that you tilt: where the part begins to slide, friction is `tan(angle)`"),
        );
    }
}
