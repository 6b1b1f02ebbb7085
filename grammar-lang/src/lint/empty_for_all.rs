//! A choice that has nothing to choose from, whatever the design.

use crate::bounds::{Facts, narrowed_locals_of};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for rule in &ruleset.rules {
        let locals = narrowed_locals_of(&facts, rule);
        for choice in &rule.choices {
            if facts.is_empty_domain(&choice.domain, &locals) {
                findings.push(
                    Diagnostic::new(
                        Code::EMPTY_DOMAIN,
                        choice.domain.span,
                        format!("`{}` has nothing to choose from, whatever the design", choice.name),
                    )
                    .label("always empty")
                    .help("write the lower end first"),
                );
            }
        }
    }
}
