//! Checks of a whole rule set that need no design. One file each.

mod constant_requirement;
mod empty_choice;
mod kinds;
mod never_matches;

use crate::diagnostics::Diagnostic;
use crate::ir::RuleSet;

/// Runs every check.
pub(crate) fn run(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    for lint in [never_matches::check, constant_requirement::check, empty_choice::check] {
        lint(ruleset, findings);
    }
}
