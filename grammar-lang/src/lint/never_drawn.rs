//! A rule whose weight is never above zero.

use crate::bounds::{Facts, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for rule in &ruleset.rules {
        if Reasoning::new(&facts, Vec::new()).numbers(&rule.weight).high <= 0.0 {
            findings.push(
                Diagnostic::new(
                    Code::NEVER_DRAWN,
                    rule.weight.span,
                    format!("the rule `{}` is never drawn", rule.name),
                )
                .label("never above zero")
                .help("give it a weight above zero, or remove the rule"),
            );
        }
    }
}
