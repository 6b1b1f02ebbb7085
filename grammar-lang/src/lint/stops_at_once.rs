//! A loop of a search that stops or begins anew after each iteration, that stops where it gains, or that judges a gain before it has made the
//! iterations of it.

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{Scope, Value};
use crate::ir::{Expr, ExprKind, Function, Operator, RuleSet, SearchWord, Word};
use crate::units::{Dimension, shown};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (schedule, method) in known.ruleset.search.loops() {
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
        if let Some(gain) = stops_on_success(stop) {
            findings.push(
                Diagnostic::new(Code::POINTLESS, gain.span, "the search stops where it makes progress")
                    .label("true as long as the best improves")
                    .help("a search stops where it gains little: write `<` in place of `>`"),
            );
        }
        if let Some((restart, spread)) = method.restart_and_spread() {
            let begins = Begins { rules: known.ruleset, spread };
            if known.value_in(restart, &begins) == Ok(Value::Bool(true)) {
                findings.push(
                    Diagnostic::new(
                        Code::POINTLESS,
                        restart.span,
                        "this search begins anew in every iteration",
                    )
                    .label(format!(
                        "true at its first `spread`, {} %",
                        shown(100.0 * spread, Dimension::NUMBER)
                    ))
                    .help("write a far smaller limit, such as `spread < 1 %`"),
                );
            }
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

/// A condition that holds where a gain is large, of those that `and` and `or` join.
fn stops_on_success(stop: &Expr) -> Option<&Expr> {
    let is_gain = |expr: &Expr| matches!(&expr.kind, ExprKind::Call(Function::Gain, _));
    match &stop.kind {
        ExprKind::Binary(a, Operator::And | Operator::Or, b) => {
            stops_on_success(a).or_else(|| stops_on_success(b))
        }
        ExprKind::Binary(a, Operator::Greater | Operator::GreaterEqual, _) if is_gain(a) => Some(stop),
        ExprKind::Binary(_, Operator::Less | Operator::LessEqual, b) if is_gain(b) => Some(stop),
        _ => None,
    }
}

/// A search by `cma_es` that begins. What it knows only later has no value.
struct Begins<'r> {
    rules: &'r RuleSet,
    spread: f64,
}

impl Scope for Begins<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.rules)
    }

    fn word(&self, word: Word) -> Option<Value> {
        matches!(word, Word::Search(SearchWord::Spread)).then_some(Value::Number(self.spread))
    }
}
