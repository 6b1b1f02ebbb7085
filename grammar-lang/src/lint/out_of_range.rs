//! Bends that the servos of a target do not reach.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Backend, Tendon};
use crate::units::{Dimension, shown};

use super::instances::driven_range;
use super::known::Known;

/// Rounding of what is written in other units is no shortage.
const CLOSE: f64 = 1e-6;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, target) in &known.ruleset.targets {
        let Backend::Tendon(threads) = &target.backend else { continue };
        let Some(actuator) = known.ruleset.actuators.get(&target.kind) else { continue };
        let Some(bend) = driven_range(known, actuator) else { continue };
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
                .label("the limit of its servos or of its table")
                .also(actuator.span, "this actuator may bend further")
                .help(format!(
                    "{}; or set `{}.bend = {}`",
                    mends(threads, bend).join(", and "),
                    target.kind,
                    range((low, high))
                )),
            );
        }
    }
}

/// What lets threads reach all of a bend: each is needed.
fn mends(threads: &Tendon, bend: (f64, f64)) -> Vec<String> {
    let (least, most) = threads.thread.domain();
    let wound = [bend.0, bend.1].map(|bend| threads.thread.at(bend.clamp(least, most)) / threads.wheel);
    let (back, forth) = (wound[0].min(wound[1]), wound[0].max(wound[1]));
    let degrees = |x: f64| format!("{:.0} deg", x.to_degrees());
    let mut mends = Vec::new();
    if bend.0 < least - CLOSE || bend.1 > most + CLOSE {
        mends.push("measure all of these bends for the table".to_owned());
    }
    // A larger wheel turns less for the same thread, but in the same direction.
    if back < threads.turn.0 - CLOSE && threads.turn.0 >= 0.0 {
        mends.push(format!("let `turn` begin at {}", degrees(back)));
    } else if forth > threads.turn.1 + CLOSE && threads.turn.1 <= 0.0 {
        mends.push(format!("let `turn` end at {}", degrees(forth)));
    } else if back < threads.turn.0 - CLOSE || forth > threads.turn.1 + CLOSE {
        let turn = format!("{} .. {}", degrees(back), degrees(forth));
        mends.push(format!("use a larger wheel or a `turn` of {turn}"));
    }
    if mends.is_empty() {
        mends.push("measure larger bends for the table".to_owned());
    }
    mends
}
