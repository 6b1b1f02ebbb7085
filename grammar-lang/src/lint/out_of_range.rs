//! Bends that the servos of a target do not reach.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Backend;
use crate::units::{Dimension, shown};

use super::known::Known;

/// Rounding of what is written in other units is no shortage.
const CLOSE: f64 = 1e-6;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, target) in &known.ruleset.targets {
        let Backend::Tendon(threads) = &target.backend else { continue };
        let Some(actuator) = known.ruleset.actuators.get(&target.kind) else { continue };
        let Some(bend) = actuator.joint.range else { continue };
        let (low, high) = threads.reach();
        if low > bend.0 + CLOSE || high < bend.1 - CLOSE {
            let range = |(a, b)| format!("{} .. {}", shown(a, Dimension::ANGLE), shown(b, Dimension::ANGLE));
            findings.push(
                Diagnostic::new(
                    Code::OUT_OF_RANGE,
                    target.span,
                    format!(
                        "`{name}` can bend `{}` only within {}, not {}",
                        target.kind,
                        range((low, high)),
                        range(bend)
                    ),
                )
                .label("its servos or its table reach no further")
                .also(actuator.span, "this actuator may bend further")
                .help(format!(
                    "set `{}.bend = {}`, use a larger wheel, or measure larger bends for the table",
                    target.kind,
                    range((low, high))
                )),
            );
        }
    }
}
