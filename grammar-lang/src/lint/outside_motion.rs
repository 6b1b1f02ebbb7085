//! `e.position at 30 s` in a motion of 20 s.

use std::collections::BTreeSet;

use crate::bounds::{Interval, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, MotionWord, Word, builds_on};
use crate::source::Span;
use crate::units;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut told: BTreeSet<Span> = findings.iter().map(Diagnostic::span).collect();
    for (name, task) in &ruleset.tasks {
        let duration = task.model.duration;
        let whole = Interval::point(duration);
        let facts = known
            .facts
            .clone()
            .with(Word::Motion(MotionWord::End), whole)
            .with(Word::Motion(MotionWord::Duration), whole);
        let wanted = task.objectives().map(|objective| &objective.value);
        for (_, expr) in wanted.flat_map(|value| builds_on(value, &ruleset.terms)) {
            for time in times(expr) {
                let at = Reasoning::new(&facts, Vec::new()).numbers(time);
                if (at.high < 0.0 || at.low > duration * (1.0 + 1e-9)) && told.insert(time.span) {
                    findings.push(report(name, time, duration));
                }
            }
        }
    }
}

fn report(task: &str, time: &Expr, duration: f64) -> Diagnostic {
    let dimension = time.ty.dimension().unwrap_or_default();
    let of = if task.is_empty() { String::new() } else { format!(" of the task `{task}`") };
    let whole = format!("{} .. {}", units::shown(0.0, dimension), units::shown(duration, dimension));
    Diagnostic::new(Code::OUTSIDE_MOTION, time.span, format!("this time lies outside the motion{of}"))
        .label(format!("the motion is recorded over {whole}"))
        .help("write `start`, `end` or a part of `duration`, or simulate for longer")
}

/// The times at which an expression reads the motion.
fn times(expr: &Expr) -> Vec<&Expr> {
    let mut found: Vec<&Expr> = Vec::new();
    gather(expr, &mut found);
    found
}

fn gather<'e>(expr: &'e Expr, found: &mut Vec<&'e Expr>) {
    if let ExprKind::At(_, time) = &expr.kind {
        found.push(time);
    }
    expr.each(&mut |inner| gather(inner, found));
}
