//! A rule with a condition that no design and no choice fulfils.

use std::collections::BTreeSet;

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;

use super::known::Known;
use super::places::conditions;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // A port that is not there is told more exactly.
    let told: BTreeSet<Span> =
        findings.iter().filter(|d| d.code == Code::NO_SUCH_PORT).map(Diagnostic::span).collect();
    let told = |condition: Span| {
        let after = Span { end: condition.start, ..condition };
        told.range(after..)
            .take_while(|s| s.file == condition.file && s.start < condition.end)
            .any(|s| s.end <= condition.end)
    };
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.narrowed);
        let never = conditions(rule).find(|condition| reasoning.truth(condition) == Truth::Never);
        if let Some(never) = never.filter(|never| !told(never.span)) {
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
