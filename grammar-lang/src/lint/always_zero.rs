//! Products with a zero, and differences of a thing and itself.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Operator, without_spans};
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<Span> = BTreeSet::new();
    for place in places(known) {
        for expr in place.exprs {
            expr.any(&mut |e| {
                if let Some(why) = why_zero(e)
                    && told.insert(e.span)
                {
                    findings.push(
                        Diagnostic::new(Code::POINTLESS, e.span, "this is always zero")
                            .label(why)
                            .help("remove this, or correct it"),
                    );
                }
                false
            });
        }
    }
}

/// Why something is zero as it is written; what a function makes of its arguments is not.
fn why_zero(e: &Expr) -> Option<&'static str> {
    let ExprKind::Binary(a, operator, b) = &e.kind else { return None };
    let is_written = |part: &Expr| {
        part.span.file == e.span.file && e.span.start <= part.span.start && part.span.end <= e.span.end
    };
    let is_zero = |part: &Expr| part.kind == ExprKind::Number(0.0);
    if !is_written(a) || !is_written(b) {
        return None;
    }
    match operator {
        Operator::Multiply if is_zero(a) || is_zero(b) => Some("a product with zero"),
        Operator::Subtract if !is_zero(a) && without_spans(a).ok()? == without_spans(b).ok()? => {
            Some("both sides are the same")
        }
        _ => None,
    }
}
