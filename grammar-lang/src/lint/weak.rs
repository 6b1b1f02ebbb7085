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
        let fewest =
            actuator.params.get("segments").and_then(|p| p.domain).map_or(1.0, |(low, _)| low.max(1.0));
        // All of them in a row, held by the first hinge. Weak is what is so whatever its other parameters are.
        let kind = Kind::Actuator(actuator);
        let margins = made(known, kind).filter_map(|(_, made)| match made {
            Ok(Made::Actuator(made)) => {
                let arm = made.segment.half_extents().x;
                Some((made.effort?, made.mass * gravity * arm * fewest * fewest))
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
                    "`torque` is {}; the weight of {fewest} segments in a row loads the first hinge with {}",
                    torque(held),
                    torque(weight)
                ))
                .help("check the units of `torque`, `mass` and `segment`"),
            );
        }
    }
}
