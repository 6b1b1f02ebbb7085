//! A rule with a condition that no design and no choice fulfils.

use crate::bounds::{Facts, Reasoning, Truth, narrowed_locals_of};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

use super::places::conditions;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for rule in &ruleset.rules {
        let locals = narrowed_locals_of(&facts, rule);
        let never = conditions(rule)
            .find(|condition| Reasoning::new(&facts, locals.clone()).truth(condition) == Truth::Never);
        // A port that is not there is told more exactly.
        let told = findings
            .iter()
            .any(|d| d.code == Code::NO_SUCH_PORT && never.is_some_and(|n| n.span.join(d.span()) == n.span));
        if let Some(never) = never.filter(|_| !told) {
            findings.push(
                Diagnostic::new(
                    Code::NEVER_APPLIES,
                    never.span,
                    format!("the rule `{}` can never apply", rule.name),
                )
                .label("this excludes every design and every choice")
                .help("relax the condition, or remove the rule"),
            );
        }
    }
}
