//! A requirement that every design fulfils.

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for requirement in &known.ruleset.requirements {
        if known.reasoning(&[]).truth(&requirement.condition) == Truth::Always {
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
