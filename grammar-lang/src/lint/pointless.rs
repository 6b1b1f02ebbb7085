//! Conditions of rules that hold whatever the design and the choices.

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;
use super::places::conditions;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.all);
        for condition in conditions(rule) {
            if reasoning.truth(condition) == Truth::Always {
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
