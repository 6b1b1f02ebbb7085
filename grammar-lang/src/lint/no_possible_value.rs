//! Expressions that have no value whatever they read: `1 / (n - n0)` where that is
//! always zero, the fourth of three items.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<Span> = findings.iter().map(Diagnostic::span).collect();
    for place in places(known) {
        let mut reasoning = known.reasoning(&place.locals);
        place.exprs.into_iter().for_each(|expr| drop(reasoning.value(expr)));
        for never in reasoning.never {
            if told.insert(never.span) {
                findings.push(
                    Diagnostic::new(
                        Code::NO_POSSIBLE_VALUE,
                        never.span,
                        "this has no value, whatever the design",
                    )
                    .label(never.reason),
                );
            }
        }
    }
}
