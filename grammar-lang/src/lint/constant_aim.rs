//! An objective that is the same for every design and every motion.

use crate::bounds::Reasoning;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::ExprKind;
use crate::units::shown;

use super::known::Known;
use super::over_nothing::facts_of;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let of_tasks = ruleset.tasks.values().map(|task| (&task.objective, facts_of(known, task)));
    let of_all = ruleset.objectives().map(|objective| (objective, known.facts.clone()));
    for (objective, facts) in of_tasks.chain(of_all) {
        let value = Reasoning::new(&facts, Vec::new()).numbers(&objective.value).single();
        if let ExprKind::If(_, a, b) = &objective.quantity().kind
            && [a, b].iter().all(|branch| known.numbers(branch).single().is_some())
            && findings.iter().all(|d| d.span() != objective.value.span)
        {
            findings.push(
                Diagnostic::new(
                    Code::CONSTANT_AIM,
                    objective.value.span,
                    "this objective has only two values",
                )
                .label("nothing leads a search from the one to the other")
                .help("let it grow with what is wanted, as in `maximize travel in cm`"),
            );
            continue;
        }
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
