//! An objective that is the same for every design and every motion.

use crate::diagnostics::{Code, Diagnostic};
use crate::units::shown;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for objective in ruleset.tasks.values().map(|task| &task.objective).chain(ruleset.objectives()) {
        let value = known.numbers(&objective.value).single();
        let Some(value) = value.filter(|_| findings.iter().all(|d| d.span() != objective.value.span)) else {
            continue;
        };
        let dimension = objective.value.ty.dimension().unwrap_or_default();
        findings.push(
            Diagnostic::new(Code::CONSTANT_AIM, objective.value.span, "every design has the same value")
                .label(format!("always {}", shown(value, dimension)))
                .help("let the objective read the motion or the design, as in `maximize travel in cm`"),
        );
    }
}
