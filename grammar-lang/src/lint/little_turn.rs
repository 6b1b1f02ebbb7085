//! Servos that use a small part of their turn: a wheel that is too large.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Backend;

use super::instances::driven_range;
use super::known::Known;

/// The least part of its turn that a servo should use: its resolution and its play count against that.
const LEAST: f64 = 0.2;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, target) in &known.ruleset.targets {
        let Backend::Tendon(threads) = &target.backend else { continue };
        let Some(actuator) = known.ruleset.actuators.get(&target.kind) else { continue };
        let Some(bend) = driven_range(known, actuator) else { continue };
        let (low, high) = threads.thread.domain();
        let wound = |bend: f64| threads.thread.at(bend.clamp(low, high)) / threads.wheel;
        let used = (wound(bend.1) - wound(bend.0)).abs();
        let turn = threads.turn.1 - threads.turn.0;
        if used < LEAST * turn {
            let degrees = |x: f64| format!("{:.0} deg", x.to_degrees());
            findings.push(
                Diagnostic::new(
                    Code::LITTLE_TURN,
                    target.span,
                    format!("the servos of `{name}` use only {:.0} % of their range", 100.0 * used / turn),
                )
                .label(format!("{} of {}", degrees(used), degrees(turn)))
                .help("use a smaller wheel: if a servo turns only a little, the bend is coarse"),
            );
        }
    }
}
