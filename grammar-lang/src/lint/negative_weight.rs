//! A weight that is always negative.

use crate::bounds::{Facts, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    let rules = ruleset.rules.iter().map(|r| (&r.weight, "the weight of a rule"));
    let preferences = ruleset.preferences.iter().map(|p| (&p.weight, "the weight of a preference"));
    for (weight, what) in rules.chain(preferences) {
        if Reasoning::new(&facts, Vec::new()).numbers(weight).high < 0.0 {
            findings.push(
                Diagnostic::new(Code::NEGATIVE_WEIGHT, weight.span, format!("{what} cannot be negative"))
                    .label("always below zero")
                    .help("a weight says how much more something counts: write a number above zero"),
            );
        }
    }
}
