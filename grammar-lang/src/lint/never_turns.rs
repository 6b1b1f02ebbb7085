//! Rotations of balls, which do not turn.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, ElementAttribute, Expr, ExprKind, Method, Track, builds_on};
use crate::source::Span;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut told: BTreeSet<Span> = BTreeSet::new();
    let balls = ruleset.tasks.values().filter(|task| matches!(task.model.method, Method::Balls(_)));
    for objective in balls.flat_map(|task| task.objectives()) {
        for (term, expr) in builds_on(&objective.value, &ruleset.terms) {
            let Some(read) = first(expr, &reads_rotation) else { continue };
            let (span, what) = match term {
                Some(term) => {
                    let is_it = |e: &Expr| matches!(&e.kind, ExprKind::Term(name) if name == term);
                    let span = first(&objective.value, &is_it).unwrap_or(objective.value.span);
                    (span, format!("`{term}` builds on rotations"))
                }
                None => (read, "this builds on a rotation".to_owned()),
            };
            if told.insert(span) {
                findings.push(
                    Diagnostic::new(
                        Code::CONSTANT_AIM,
                        span,
                        format!("a model of balls has no rotations, but {what}"),
                    )
                    .label("all rotations are zero with `method = balls`")
                    .help(
                        "compare the places of two elements: `bearing((last(elements).position at end) - \
                             (first(elements).position at end))`",
                    ),
                );
            }
        }
    }
}

fn reads_rotation(e: &Expr) -> bool {
    let ExprKind::Attribute(_, attribute) = &e.kind else { return false };
    matches!(attribute, Attribute::Track(Track::Rotation) | Attribute::Element(ElementAttribute::Yaw))
}

/// The place of the first expression in one that is as asked.
fn first(expr: &Expr, is_it: &dyn Fn(&Expr) -> bool) -> Option<Span> {
    let mut found = None;
    expr.any(&mut |e| {
        let here = is_it(e);
        found = here.then_some(e.span).or(found);
        here
    });
    found
}
