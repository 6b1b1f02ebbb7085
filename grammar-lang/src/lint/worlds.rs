//! A set of worlds that differ in what the bodies of the task do not have.

use super::known::Known;
use crate::diagnostics::{Code, Diagnostic};

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    for task in rules.tasks.values() {
        let Some(within) = &task.scenarios else { continue };
        let Some(set) = rules.scenarios.get(&within.name) else { continue };
        let Some((difference, why)) = rules.cannot_apply(set, [task]) else { continue };
        let (field, name) = (difference.text(), &within.name);
        findings.push(
            Diagnostic::new(
                Code::MODEL_MISFIT,
                within.span,
                format!("`{field}` of `{name}` cannot be applied here: {why}"),
            )
            .label("these worlds")
            .also(set.span, "they are declared here")
            .help(format!("take `{field}` out of `{name}`: in a variant, `drop {name}.{field}`")),
        );
    }
}
