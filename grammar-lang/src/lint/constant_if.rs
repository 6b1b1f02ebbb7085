//! `if` with a condition that is always the same, or with branches that are.

use std::mem::discriminant;

use indexmap::IndexMap;

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, without_spans};
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // An `if` may be evaluated in several places: only one that is the same in all is told.
    let mut all: IndexMap<Span, Truth> = IndexMap::new();
    let mut even: IndexMap<Span, Span> = IndexMap::new();
    for place in places(known) {
        let mut reasoning = known.reasoning(&place.locals);
        for expr in &place.exprs {
            expr.any(&mut |e| {
                if let ExprKind::If(_, then, otherwise) = &e.kind
                    && are_same(then, otherwise)
                {
                    even.insert(e.span, otherwise.span);
                }
                false
            });
        }
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
            Diagnostic::new(Code::CONSTANT_IF, span, "this condition is always the same")
                .label(label)
                .help(format!("keep only the value after `{kept}`; in a rule, remove the condition, or everything that depends on it")),
        );
    }
    for (span, otherwise) in even {
        findings.push(
            Diagnostic::new(Code::CONSTANT_IF, span, "both branches of this `if` are the same")
                .label("the same value, whatever the condition")
                .also(otherwise, "the same value again")
                .help("write only the value, or change one of the two branches"),
        );
    }
}

/// Whether two expressions are the same text, but for their places.
fn are_same(a: &Expr, b: &Expr) -> bool {
    discriminant(&a.kind) == discriminant(&b.kind)
        && matches!((without_spans(a), without_spans(b)), (Ok(a), Ok(b)) if a == b)
}
