//! Expressions that have no value whatever they read: `1 / (n - n0)` where that is
//! always zero, the fourth of three items.

use crate::bounds::{Facts, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

use super::places::places;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for place in places(&facts) {
        let mut reasoning = Reasoning::new(&facts, place.locals);
        reasoning.value(place.expr);
        for never in reasoning.never {
            if !findings.iter().any(|d| d.span() == never.span) {
                findings.push(
                    Diagnostic::new(
                        Code::NO_POSSIBLE_VALUE,
                        never.span,
                        "this has no value, whatever the design",
                    )
                    .label(never.reason),
                );
            }
        }
    }
}
