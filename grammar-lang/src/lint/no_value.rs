//! Expressions that have no value whatever the design: `1 / 0`, an index beyond a list.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{EvalError, UNKNOWN_HERE};
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // What several expressions build on is told once.
    let mut told: BTreeSet<Span> = BTreeSet::new();
    for expr in places(known).into_iter().flat_map(|place| place.exprs) {
        // What reads the design has no value here either, but for another reason.
        if let Err(EvalError { span, reason }) = known.value(expr)
            && reason != UNKNOWN_HERE
            && known.spent().is_none()
            && told.insert(span)
        {
            findings.push(Diagnostic::new(Code::BAD_VALUE, span, "this never has a value").label(reason));
        }
    }
    if let Some(EvalError { span, reason }) = known.spent() {
        findings.push(
            Diagnostic::new(Code::BAD_VALUE, span, "the check stops here: this is not evaluated")
                .label(reason),
        );
    }
}
