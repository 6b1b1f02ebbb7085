//! A choice that has nothing to choose from, whatever the design.

use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.narrowed);
        for choice in &rule.choices {
            if reasoning.is_empty_domain(&choice.domain) {
                findings.push(
                    Diagnostic::new(
                        Code::EMPTY_DOMAIN,
                        choice.domain.span,
                        format!("`{}` has nothing to choose from in any design", choice.name),
                    )
                    .label("always empty")
                    .help("write the lower end first"),
                );
            }
        }
    }
}
