//! Motors that turn so far in a step of the model that their way and their work are wrong.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{JointKind, Method};

use super::instances::driven_range;
use super::known::Known;

/// A motor may turn so far in a step, rad: solvers take the chord for the arc, which is a hundredth shorter. What refuses such
/// motions is the solver, which knows no grammars; a test compares the two numbers.
pub const MOST: f64 = 0.25;
/// It may turn so far between two recorded frames, rad: beyond half a turn they do not tell which way it went.
const MOST_RECORDED: f64 = 2.8;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told: Vec<Diagnostic> = Vec::new();
    for actuated in known.actuated() {
        let (model, joint) = (&actuated.task.model, actuated.actuator.joint.kind);
        if joint != JointKind::Spin {
            continue;
        }
        let Some((_, speed)) = driven_range(known, actuated.actuator) else { continue };
        if model.method != Method::Hinges {
            continue;
        }
        let (field, time, most) = match speed * model.step > MOST {
            true => ("step", model.step, MOST),
            false => ("record", model.record, MOST_RECORDED),
        };
        if speed * time <= most {
            continue;
        }
        let kind = actuated.kind;
        let finding = Diagnostic::new(
            Code::UNUSUAL,
            actuated.actuator.span,
            format!("`{kind}` can turn too fast for `{}`", model.name),
        )
        .label(format!("by {:.0} deg in a `{field}` of {:.3} ms", (speed * time).to_degrees(), time * 1e3))
        .help(format!(
            "{}. `{field} = 1 s / {:.0}` is short enough; or lower its `speed`",
            if field == "step" {
                "motions in which it does are refused"
            } else {
                "`slid`, `sliding` and `yaw` are then wrong"
            },
            (speed / most).ceil()
        ));
        if told.iter().all(|known| known.message != finding.message) {
            told.push(finding);
        }
    }
    findings.extend(told);
}
