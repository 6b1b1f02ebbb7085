//! A weight that is always negative.

use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset.rules.iter().map(|r| (&r.weight, "the weight of a rule"));
    let preferences = known.ruleset.preferences.iter().map(|p| (&p.weight, "the weight of a preference"));
    for (weight, what) in rules.chain(preferences) {
        if known.numbers(weight).high < 0.0 {
            findings.push(
                Diagnostic::new(Code::NEGATIVE_WEIGHT, weight.span, format!("{what} cannot be negative"))
                    .label("always below zero")
                    .help("a weight says how much something counts: write a number above zero"),
            );
        }
    }
}
