//! Objectives that are the same for all motions.

use std::collections::BTreeSet;

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::ir::{Direction, Expr, ExprKind, Function, Gather, Objective, Operator, RuleSet};

use super::Trials;
use crate::score::{quantities, terms};

/// So many motions are compared, at least.
const ENOUGH: usize = 4;
/// Values that differ by less are the same: rounding grows in a motion. Of an objective in its own unit, of a term in SI units.
const SAME: f64 = 1e-4;
const SAME_TERM: f64 = 1e-6;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let Some(first) = trials.trials.first() else { return Vec::new() };
    first.drive.task().objectives().filter_map(|objective| same(trials, objective)).collect()
}

fn same(trials: &Trials<'_>, objective: &Objective) -> Option<Diagnostic> {
    let rules = trials.trials.first()?.drive.candidate().rules;
    let what = if !has_steps(rules, &objective.value) && is_same(&values(trials, &objective.value), SAME) {
        "this objective does not depend on how the robot moves".to_owned()
    } else {
        // What is subtracted may well be zero.
        let gained = gained(objective).filter(|_| objective.direction == Direction::Maximize)?;
        let is_constant = |name: &&str| {
            let values = trials.recordings().filter_map(|recording| {
                let all = terms(recording).ok()?;
                all.into_iter().find(|(term, _)| term == name).map(|(_, value)| value)
            });
            let has_steps = rules.terms.get(*name).is_none_or(|term| has_steps(rules, &term.value));
            !has_steps && is_same(&values.collect::<Vec<_>>(), SAME_TERM)
        };
        if gained.is_empty() || !gained.iter().all(is_constant) {
            return None;
        }
        let names: Vec<String> = gained.iter().map(|name| format!("`{name}`")).collect();
        format!("{} does not depend on how the robot moves", names.join(" + "))
    };
    Some(
        Diagnostic::new(Code::CONSTANT_AIM, objective.value.span, what)
            .label(format!("the same in {} short motions of several bodies", trials.recordings().count()))
            .help("what can change it? If both sides of a mirror move alike, the core stays in the plane of the mirror; y points up"),
    )
}

fn values(trials: &Trials<'_>, wanted: &Expr) -> Vec<f64> {
    trials.recordings().filter_map(|recording| quantities(recording, &[wanted]).ok()?.pop()).collect()
}

fn is_same(values: &[f64], by: f64) -> bool {
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    values.len() >= ENOUGH && high - low <= by
}

/// The terms that an objective adds up, without what it subtracts; none if it is made otherwise.
fn gained(objective: &Objective) -> Option<BTreeSet<&str>> {
    fn add<'e>(value: &'e Expr, into: &mut BTreeSet<&'e str>) -> bool {
        match &value.kind {
            ExprKind::Term(name) => {
                into.insert(name.as_str());
                true
            }
            ExprKind::Convert(x, _) | ExprKind::Binary(x, Operator::Subtract, _) => add(x, into),
            ExprKind::Binary(a, Operator::Add, b) => add(a, into) && add(b, into),
            ExprKind::Aggregate {
                how: Gather::Min | Gather::Mean | Gather::Quantile,
                body: Some(body),
                ..
            } => add(body, into),
            _ => false,
        }
    }
    let mut names = BTreeSet::new();
    add(&objective.value, &mut names).then_some(names)
}

/// Whether a short motion may have the same value as another although a longer one has not: something is compared, limited or counted.
fn has_steps(rules: &RuleSet, value: &Expr) -> bool {
    value.any(&mut |e| match &e.kind {
        ExprKind::If(..) | ExprKind::Not(_) | ExprKind::Table(_) | ExprKind::Task(_) | ExprKind::Bool(_) => {
            true
        }
        ExprKind::Aggregate { condition, body, .. } => condition.is_some() || body.is_none(),
        ExprKind::Binary(_, operator, _) => {
            !matches!(operator, Operator::Add | Operator::Subtract | Operator::Multiply | Operator::Divide)
        }
        ExprKind::Call(function, _) => matches!(
            function,
            Function::Min
                | Function::Max
                | Function::Clamp
                | Function::Floor
                | Function::Ceil
                | Function::Round
                | Function::Fraction
                | Function::Count
        ),
        ExprKind::Term(name) => rules.terms.get(name).is_none_or(|term| has_steps(rules, &term.value)),
        _ => false,
    })
}
