//! Searches for bodies that do not tune what the actuations vary.

use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let search = &ruleset.search;
    if search.bodies.is_none() || search.curves.is_some() {
        return;
    }
    let used = ruleset.tasks.values().flat_map(|task| task.actuated.values());
    let varied = used.filter_map(|name| ruleset.actuations.get(name)).flat_map(|own| &own.variables).next();
    findings.extend(varied.map(|variable| {
        Diagnostic::new(
            Code::UNUSUAL,
            variable.span,
            format!("`search {}` does not tune `{}`", search.name, variable.name),
        )
        .label("each body gets one value for it, which is drawn at random")
        .help("choose a search with a loop over curves, such as `nested_annealing`, or an actuation that varies nothing")
    }));
}
