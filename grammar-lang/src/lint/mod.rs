//! Checks of a whole rule set that need no design. One file each.

mod circles;
mod constant_requirement;
mod empty_choice;
mod kinds;
mod never_matches;
mod no_value;

use crate::diagnostics::Diagnostic;
use crate::ir::RuleSet;

/// Runs every check.
pub(crate) fn run(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    circles::check(ruleset, findings);
    if !findings.is_empty() {
        // The others evaluate: not in circles.
        return;
    }
    for lint in [never_matches::check, constant_requirement::check, empty_choice::check, no_value::check] {
        lint(ruleset, findings);
    }
}
