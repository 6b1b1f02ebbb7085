//! Objectives that are the same for all motions.

use std::collections::BTreeSet;

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::ir::{Direction, Expr, ExprKind, Function, Gather, Objective, Operator, RuleSet};

use super::{Moved, Trial, Trials};
use crate::score::terms;

/// So many motions are compared, at least.
const ENOUGH: usize = 4;
/// So many motions in which two objectives have one ratio.
const MULTIPLES: usize = 6;
/// Values that differ by less are the same, to rounding: a body that hardly moves differs by more. Of an objective in its own unit, of a
/// term in SI units.
const SAME: f64 = 1e-8;
const SAME_TERM: f64 = 1e-10;

/// An actuator that is asked for less than this is not asked to move, rad, m or rad/s.
const STILL: f64 = 1e-4;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let Some(first) = trials.trials.first() else { return Vec::new() };
    let task = first.drive.task();
    if trials.trials.iter().all(|trial| trial.motions.iter().all(|moved| is_still(trials, trial, moved))) {
        let told = Diagnostic::new(Code::CONSTANT_AIM, task.objective.value.span, "no actuator ever moves")
            .label("all drives hold them in one place")
            .help("what do the drives ask for? A pattern that no rule sets stays `rest`");
        return vec![told];
    }
    let mut found: Vec<Diagnostic> =
        task.objectives().filter_map(|objective| same(trials, objective)).collect();
    if found.is_empty() {
        found.extend(alike(trials, &task.objectives().collect::<Vec<_>>()));
    }
    found
}

/// A warning for the first objective that is a multiple of one before it, in all motions.
fn alike(trials: &Trials<'_>, objectives: &[&Objective]) -> Option<Diagnostic> {
    let values: Vec<Vec<f64>> = objectives.iter().map(|one| trials.values(&one.value)).collect();
    let is_multiple = |a: &[f64], b: &[f64]| {
        let most = |all: &[f64]| all.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let (least, greatest) =
            a.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        let (Some(&one), Some(&other)) = (a.first(), b.first()) else { return false };
        let close = 1e-9 * most(a) * most(b);
        a.len() >= MULTIPLES
            && a.len() == b.len()
            && greatest - least > 1e-6 * most(a)
            && a.iter().zip(b).all(|(x, y)| (x * other - y * one).abs() <= close)
    };
    let (before, objective) = objectives.iter().enumerate().skip(1).find_map(|(place, objective)| {
        let before = (0..place).find(|before| is_multiple(&values[*before], &values[place]))?;
        Some((objectives[before], *objective))
    })?;
    Some(
        Diagnostic::new(
            Code::SAID_TWICE,
            objective.value.span,
            "this objective is a multiple of another one",
        )
        .label("the same ratio in all short motions: a front of the two is one robot")
        .also(before.value.span, "of this one")
        .help("choose an objective that costs something in the other one"),
    )
}

fn same(trials: &Trials<'_>, objective: &Objective) -> Option<Diagnostic> {
    let rules = trials.trials.first()?.drive.candidate().rules;
    let what = if !has_steps(rules, &objective.value) && is_same(&trials.values(&objective.value), SAME) {
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
            .label(format!("the same in {} short motions", trials.recordings().count()))
            .help("what can change it? If both sides of a mirror move alike, the core stays in the plane of the mirror; y points up"),
    )
}

/// Whether all actuators are asked to stay in one place for the whole of a motion, and motors to stand still. Drives that read sensors may
/// wait for something.
fn is_still(trials: &Trials<'_>, trial: &Trial<'_>, moved: &Moved<'_>) -> bool {
    let targets = if moved.law.is_closed_loop() {
        let motion = moved.motion.as_ref().ok().filter(|_| trials.whole.sensors.is_empty());
        motion.and_then(|motion| motion.commands.clone())
    } else {
        trials.whole_drive(trial).and_then(|drive| drive.targets(&moved.parameters).ok())
    };
    let Some(targets) = targets else { return false };
    let joints = &trial.drive.candidate().body.assembly.joints;
    let dofs = || joints.iter().flat_map(|joint| joint.kind.dofs());
    let is_motor = |actuator| dofs().any(|dof| dof.is_spun() && dof.actuator() == Some(actuator));
    let is_held = |actuator: usize| {
        let places = targets.angles.iter().skip(actuator).step_by(targets.actuators);
        let (low, high) = places.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        high - low < STILL && (!is_motor(actuator) || high.abs() < STILL)
    };
    (0..targets.actuators).all(is_held)
}

fn is_same(values: &[f64], by: f64) -> bool {
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    values.len() >= ENOUGH && high - low <= by
}

/// The terms that an objective adds up, without what it subtracts; none if it is made otherwise.
pub(super) fn gained(objective: &Objective) -> Option<BTreeSet<&str>> {
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
