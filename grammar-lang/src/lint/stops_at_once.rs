//! A loop of a search that stops after each iteration, or that judges a gain before it has made the iterations of it.

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Function, Operator, SearchWord, Word};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (schedule, _) in known.ruleset.search.loops() {
        let stop = &schedule.stop;
        let is_always = known.reasoning(&[]).truth(stop) == Truth::Always;
        // A plain `true` is meant.
        if is_always && !matches!(stop.kind, ExprKind::Bool(_)) {
            findings.push(
                Diagnostic::new(Code::POINTLESS, stop.span, "the search stops after one iteration")
                    .label("this always holds")
                    .help("write `stop = false` to go on as long as `iterations` says"),
            );
        }
        if let Some(many) = judges_early(known, stop) {
            findings.push(
                Diagnostic::new(
                    Code::POINTLESS,
                    stop.span,
                    format!("the search may stop long before it has made {many} iterations"),
                )
                .label(format!(
                    "`or`: with fewer iterations, `gain({many})` is the gain of those that were made"
                ))
                .help(format!("to judge the gain of {many} iterations, write `and`")),
            );
        }
    }
}

/// Of `iteration >= n or ... gain(n) ...` the number n, if it is the same.
fn judges_early(known: &Known<'_>, stop: &Expr) -> Option<f64> {
    let ExprKind::Binary(a, Operator::Or, b) = &stop.kind else { return None };
    let number = |expr: &Expr| known.value(expr).ok()?.as_number();
    let reached = |expr: &Expr| match &expr.kind {
        ExprKind::Binary(count, Operator::GreaterEqual | Operator::Greater, many) => {
            matches!(count.kind, ExprKind::Word(Word::Search(SearchWord::Iteration))).then(|| number(many))?
        }
        _ => None,
    };
    let judged = |expr: &Expr| {
        let mut many = None;
        expr.any(&mut |part| {
            if let ExprKind::Call(Function::Gain, arguments) = &part.kind {
                many = arguments.first().and_then(number);
            }
            many.is_some()
        });
        many
    };
    [(a, b), (b, a)].into_iter().find_map(|(one, other)| {
        let many = reached(one)?;
        (many > 1.0 && judged(other) == Some(many)).then_some(many)
    })
}
