//! `if` with a condition that is always the same.

use crate::bounds::{Facts, Reasoning, Truth};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::RuleSet;
use crate::source::Span;

use super::places::places;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    // An `if` may be evaluated in several places: only one that is the same in all is told.
    let mut all: Vec<(Span, Truth)> = Vec::new();
    for place in places(&facts) {
        let mut reasoning = Reasoning::new(&facts, place.locals);
        reasoning.value(place.expr);
        for (span, truth) in reasoning.conditions {
            match all.iter_mut().find(|(s, _)| *s == span) {
                Some((_, known)) if *known != truth => *known = Truth::Sometimes,
                Some(_) => {}
                None => all.push((span, truth)),
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
            Diagnostic::new(Code::CONSTANT_IF, span, "this `if` always goes the same way")
                .label(label)
                .help(format!("write only what follows `{kept}`")),
        );
    }
}
