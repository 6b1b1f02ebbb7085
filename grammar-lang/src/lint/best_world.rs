//! An objective that is the value in the world where a gait does best.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Direction;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let of_tasks = ruleset.tasks.values().flat_map(|task| task.objectives());
    for objective in of_tasks.chain(ruleset.objectives()).filter(|objective| objective.is_best_case()) {
        if findings.iter().any(|known| known.span() == objective.value.span) {
            continue;
        }
        let (best, worst) = match objective.direction {
            Direction::Maximize => ("max", "min"),
            Direction::Minimize => ("min", "max"),
        };
        findings.push(
            Diagnostic::new(
                Code::UNUSUAL,
                objective.value.span,
                "this objective counts only the world in which a gait does best",
            )
            .label("the other worlds do not count")
            .help(format!(
                "for a gait that works in every world, write `{worst} over` instead of `{best} over`; `mean over` lies between the two"
            )),
        );
    }
}
