//! Expressions that have no value whatever they read: `1 / (n - n0)` where that is
//! always zero, the fourth of three items.

use std::collections::BTreeSet;

use crate::bounds::Repeated;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Effect;
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<Span> = findings.iter().map(Diagnostic::span).collect();
    let mut all = Vec::new();
    for place in places(known) {
        let mut reasoning = known.reasoning(&place.locals);
        place.exprs.into_iter().for_each(|expr| drop(reasoning.value(expr)));
        all.append(&mut reasoning.never);
    }
    // What is repeated is worked out for each of its numbers.
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.narrowed);
        reasoning.through_effects(&rule.effects, Repeated::FirstAndLast, &mut |reasoning, effect| {
            if !matches!(effect, Effect::Repeat { .. }) {
                effect.exprs().into_iter().for_each(|expr| drop(reasoning.value(expr)));
            }
        });
        all.append(&mut reasoning.never);
    }
    for never in all {
        if told.insert(never.span) {
            findings.push(
                Diagnostic::new(Code::NO_POSSIBLE_VALUE, never.span, "this has no value for any design")
                    .label(never.reason),
            );
        }
    }
}
