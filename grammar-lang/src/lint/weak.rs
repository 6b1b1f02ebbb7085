//! Actuators that cannot lift one of their own segments.

use crate::diagnostics::{Code, Diagnostic};
use crate::units::{Dimension, shown};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let gravity = ruleset.tasks.values().map(|task| task.model.gravity).fold(0.0, f64::max);
    for (name, actuator) in &ruleset.actuators {
        // A hinge at one end of a segment, its weight in the middle.
        let arm = actuator.segment.half_extents().x;
        let weight = actuator.mass * gravity * arm;
        if actuator.torque < weight {
            let torque = |x: f64| shown(x, Dimension::TORQUE);
            findings.push(
                Diagnostic::new(
                    Code::WEAK,
                    actuator.span,
                    format!("`{name}` is too weak to lift one of its own segments"),
                )
                .label(format!(
                    "`torque` is {}, the weight of a segment turns a hinge with {}",
                    torque(actuator.torque),
                    torque(weight)
                ))
                .help("check the units of `torque`, `mass` and `segment`"),
            );
        }
    }
}
