//! Actuators that cannot hold their own segments, even if they have as few as they may.

use crate::diagnostics::{Code, Diagnostic};
use crate::units::{Dimension, shown};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let gravity = ruleset.tasks.values().map(|task| task.model.gravity).fold(0.0, f64::max);
    for (name, actuator) in &ruleset.actuators {
        let arm = actuator.segment.half_extents().x;
        let fewest =
            actuator.params.get("segments").and_then(|p| p.domain).map_or(1.0, |(low, _)| low.max(1.0));
        // All of them in a row, held by the first hinge.
        let weight = actuator.mass * gravity * arm * fewest * fewest;
        if actuator.torque < weight {
            let torque = |x: f64| shown(x, Dimension::TORQUE);
            findings.push(
                Diagnostic::new(
                    Code::WEAK,
                    actuator.span,
                    format!("`{name}` is too weak to hold its own segments"),
                )
                .label(format!(
                    "`torque` is {}; the weight of {fewest} segments in a row turns the first hinge with {}",
                    torque(actuator.torque),
                    torque(weight)
                ))
                .help("check the units of `torque`, `mass` and `segment`"),
            );
        }
    }
}
