//! Actuators that cannot hold their own segments, even if they have as few as they may.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{Actuator, JointKind, Kind};
use crate::units::{Dimension, shown};

use super::instances::made;
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let gravity = ruleset.tasks.values().map(|task| task.model.gravity).fold(0.0, f64::max);
    // A twist need not hold what hangs on it, and the weight does not load it with a torque.
    let bends = |actuator: &&Actuator| actuator.joint.kind == JointKind::Bend;
    for (name, actuator) in ruleset.actuators.iter().filter(|(_, actuator)| bends(actuator)) {
        // Most of all it loads a hinge that lies level; one that stands upright need not hold it.
        if actuator.joint.axis.fixed().is_some_and(|axis| axis[2].abs() < axis[1].abs()) {
            continue;
        }
        let fewest =
            actuator.params.get("segments").and_then(|p| p.domain).map_or(2.0, |(low, _)| low.max(2.0));
        // What is beyond the first hinge: each stands in the middle of its share of the row. Weak is what is so whatever its
        // other parameters are.
        let beyond = 1.0 - 0.5 / (fewest - 1.0);
        let kind = Kind::Actuator(actuator);
        let margins = made(known, kind).filter_map(|(_, made)| match made {
            Ok(Made::Actuator(made)) => {
                let arm = made.segment.half_extents().x;
                let row = fewest * beyond;
                Some((made.motor.as_ref()?.effort, made.mass * gravity * arm * row * row))
            }
            _ => None,
        });
        let strongest = margins.max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
        if let Some((held, weight)) = strongest
            && held < weight
        {
            let torque = |x: f64| shown(x, Dimension::TORQUE);
            findings.push(
                Diagnostic::new(
                    Code::WEAK,
                    actuator.span,
                    format!("`{name}` is too weak to hold its own segments"),
                )
                .label(format!(
                    "`torque` is {}; a level row of {fewest} segments loads its first hinge with {}",
                    torque(held),
                    torque(weight)
                ))
                .help("check the units of `torque`, `mass` and `segment`"),
            );
        }
    }
}
