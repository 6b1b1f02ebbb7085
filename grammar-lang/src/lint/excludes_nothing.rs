//! A requirement that every design fulfils.

use crate::bounds::{Facts, Reasoning, Truth};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for requirement in &ruleset.requirements {
        if Reasoning::new(&facts, Vec::new()).truth(&requirement.condition) == Truth::Always {
            findings.push(
                Diagnostic::new(
                    Code::EXCLUDES_NOTHING,
                    requirement.condition.span,
                    format!("the requirement `{}` excludes nothing", requirement.name),
                )
                .label("holds for every design")
                .help("leave it out, or say what should not be possible"),
            );
        }
    }
}
