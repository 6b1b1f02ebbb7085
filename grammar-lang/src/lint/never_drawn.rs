//! A rule whose weight is never above zero.

use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for rule in &known.ruleset.rules {
        if known.numbers(&rule.weight).high <= 0.0 {
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
