//! A requirement that is false whatever the design.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for requirement in &known.ruleset.requirements {
        // A condition that reads the design has no value here.
        if known.value(&requirement.condition) == Ok(Value::Bool(false)) {
            findings.push(
                Diagnostic::new(
                    Code::CONSTANT_REQUIRE,
                    requirement.condition.span,
                    format!("the requirement `{}` never holds", requirement.name),
                )
                .label("false for every design")
                .help("a requirement reads the design, as in `count(part) <= 20`"),
            );
        }
    }
}
