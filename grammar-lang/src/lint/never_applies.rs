//! A rule with a condition that no design and no choice fulfils.

use std::collections::BTreeSet;

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind, Rule};
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
        findings.extend(port_twice(rule));
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

/// A rule that attaches two parts to one port.
fn port_twice(rule: &Rule) -> Option<Diagnostic> {
    let mut taken: Vec<&Expr> = Vec::new();
    for effect in &rule.effects {
        // What has been done meanwhile may have made room.
        if matches!(effect, Effect::Then) {
            taken.clear();
        }
        let Effect::Attach { on, .. } = effect else { continue };
        if let Some(first) = taken.iter().find(|first| first.kind == on.port.kind) {
            return Some(
                Diagnostic::new(
                    Code::NEVER_APPLIES,
                    on.port.span,
                    format!("the rule `{}` can never apply: it attaches two parts to one port", rule.name),
                )
                .label("this port is already taken")
                .also(first.span, "taken here")
                .help("attach the second one elsewhere: name the first with `as a`, and write `to a.PORT`, with another port of it"),
            );
        }
        if matches!(on.port.kind, ExprKind::Local(_)) {
            taken.push(&on.port);
        }
    }
    None
}
