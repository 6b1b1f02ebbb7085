//! `if` with a condition that is always the same.

use indexmap::IndexMap;

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // An `if` may be evaluated in several places: only one that is the same in all is told.
    let mut all: IndexMap<Span, Truth> = IndexMap::new();
    for place in places(known) {
        let mut reasoning = known.reasoning(&place.locals);
        place.exprs.into_iter().for_each(|expr| drop(reasoning.value(expr)));
        for (span, truth) in reasoning.conditions {
            let before = all.entry(span).or_insert(truth);
            if *before != truth {
                *before = Truth::Sometimes;
            }
        }
    }
    for (span, truth) in all {
        let (label, kept) = match truth {
            Truth::Always => ("always true", "then"),
            Truth::Never => ("always false", "else"),
            Truth::Sometimes => continue,
        };
        findings.push(
            Diagnostic::new(Code::CONSTANT_IF, span, "this `if` always takes the same branch")
                .label(label)
                .help(format!("write only what follows `{kept}`")),
        );
    }
}
