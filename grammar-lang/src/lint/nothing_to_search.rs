//! Neither a rule nor a varied quantity: there is only one candidate.

use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let used = ruleset.tasks.values().flat_map(|task| task.actuated.values());
    let varied = used.filter_map(|name| ruleset.actuations.get(name)).any(|a| !a.variables.is_empty());
    if ruleset.rules.is_empty()
        && !varied
        && let Some(core) = ruleset.begin.first()
    {
        findings.push(
            Diagnostic::new(Code::NOTHING_TO_SEARCH, core.span, "there is nothing to search")
                .label("the only design, and nothing of it varies")
                .help("add a rule, or an actuation with a `vary` clause"),
        );
    }
}
