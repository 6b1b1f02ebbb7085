//! Aggregates that run over nothing in a motion as short as that of the task.

use std::collections::BTreeSet;

use crate::bounds::{Facts, Interval, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, MotionWord, Task, Word, builds_on};
use crate::source::Span;
use crate::units::{Dimension, shown};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut told: BTreeSet<Span> = BTreeSet::new();
    for task in ruleset.tasks.values() {
        let facts = facts_of(known, task);
        let longest = period_of(known, task).map(|period| period.high);
        let at_longest = longest.map(|period| with_period(facts.clone(), Interval::point(period)));
        for value in task.objectives().map(|objective| &objective.value) {
            for (term, expr) in builds_on(value, &ruleset.terms) {
                let first = |facts: &Facts<'_>| {
                    let mut empty = None;
                    expr.any(&mut |e| {
                        empty = empty.or_else(|| runs_over_nothing(facts, e));
                        empty.is_some()
                    });
                    empty
                };
                // With any period, or else with the longest that a search may choose.
                let always = first(&facts);
                let empty = always.or_else(|| first(at_longest.as_ref()?));
                let period = longest.filter(|_| always.is_none());
                let place = if term.is_some() { value.span } else { empty.unwrap_or_default() };
                if let Some(where_from) = empty
                    && told.insert(place)
                {
                    findings.push(report(term, (task, period), place, where_from));
                }
            }
        }
    }
}

/// What is known of the motion of a task: its duration, and the period of its actuations.
pub(super) fn facts_of<'r>(known: &Known<'r>, task: &Task) -> Facts<'r> {
    let whole = Interval::point(task.model.duration);
    let facts = known.facts.clone();
    let facts = facts.with(Word::Motion(MotionWord::End), whole);
    let facts = facts.with(Word::Motion(MotionWord::Duration), whole);
    match period_of(known, task) {
        Some(period) => with_period(facts, period),
        None => facts,
    }
}

/// The periods that a search may choose for the actuations of a task.
fn period_of(known: &Known<'_>, task: &Task) -> Option<Interval> {
    let actuations = task.actuated.values().filter_map(|name| known.ruleset.actuations.get(name));
    let periods = actuations.flat_map(|a| &a.variables).filter(|v| v.name == "period");
    periods.map(|v| Interval::new(v.domain.0, v.domain.1)).reduce(Interval::hull)
}

fn with_period(facts: Facts<'_>, period: Interval) -> Facts<'_> {
    facts.with(Word::Motion(MotionWord::Period), period)
}

/// Where an aggregate says over what it runs, if that is nothing.
fn runs_over_nothing(facts: &Facts<'_>, expr: &Expr) -> Option<Span> {
    let ExprKind::Aggregate { binders, otherwise: Some(_), .. } = &expr.kind else { return None };
    let empty = binders.iter().find(|binder| match &binder.over.kind {
        ExprKind::Range(low, high) => {
            let mut reasoning = Reasoning::new(facts, Vec::new());
            reasoning.numbers(high).high < reasoning.numbers(low).low
        }
        _ => false,
    });
    empty.map(|binder| binder.over.span)
}

/// The period is told where it is not so with every period.
fn report(term: Option<&str>, (task, period): (&Task, Option<f64>), place: Span, over: Span) -> Diagnostic {
    let duration = shown(task.model.duration, Dimension::TIME);
    let within = match period {
        Some(period) => {
            let period = shown(period, Dimension::TIME);
            format!("in a motion of {duration} with a `period` of {period}, which a search may choose")
        }
        None => format!("in a motion of {duration}"),
    };
    let message = match term {
        Some(term) => format!("{within}, `{term}` has nothing to compare"),
        None => format!("{within}, this has nothing to run over"),
    };
    Diagnostic::new(Code::SETTLES_LATE, place, message)
        .label("this then has the value after `otherwise`")
        .also(over, "this range is empty")
        .help("simulate for longer, choose shorter periods, or use a term that has a value in a short motion")
}
