//! Conditions of rules that hold whatever the design and the choices.

use crate::bounds::{Facts, Reasoning, Truth, locals_of};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

use super::places::conditions;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for rule in &ruleset.rules {
        let locals = locals_of(&facts, rule);
        for condition in conditions(rule) {
            if Reasoning::new(&facts, locals.clone()).truth(condition) == Truth::Always {
                findings.push(
                    Diagnostic::new(
                        Code::POINTLESS,
                        condition.span,
                        format!("this condition of the rule `{}` excludes nothing", rule.name),
                    )
                    .label("holds for every design and every choice")
                    .help("leave it out, or say what should not be possible"),
                );
            }
        }
    }
}
