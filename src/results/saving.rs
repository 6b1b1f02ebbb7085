//! Makes the saved form of a best design.

use std::sync::Arc;

use grammar_lang::ir::{Objective, RuleSet, objective_name};

use super::DesignError;
use super::names::Names;
use super::replay::{Driven, Precision, Replayed, drive_of};
use super::saved::{Beside, Check, Grammar, Measured, SavedDesign, SavedTask};
use super::verdict::HALF_STEP;
use crate::derive::Candidate;
use crate::drive::Drive;
use crate::score;
use crate::search::Best;
use crate::simulate::Stop;

/// Makes the saved form of a best design.
///
/// # Errors
///
/// A sentence; a best design has been simulated before, so there should be none.
pub fn save(
    rules: &RuleSet,
    grammar: Grammar,
    seed: u64,
    solver: &str,
    best: &Best,
) -> Result<SavedDesign, DesignError> {
    let candidate = Candidate::new(rules, Arc::clone(&best.derivation));
    let mut design = SavedDesign::new(
        grammar,
        seed,
        solver,
        best.found_at,
        (best.value, &rules.objective.unit),
        (&best.derivation, best.derivation.design.canonical_hash()),
    );
    design.beside = beside(rules, &best.beside);
    design.penalties = score::penalties(rules, &best.derivation)?;
    design.observed = rules.observed.iter().cloned().zip(best.observed().iter().cloned()).collect();
    design.own_names = Names::of(rules, &best.derivation.design);
    let names = design.own_names.clone();
    for (task, tune) in rules.tasks.values().zip(&best.tasks) {
        let drive = Drive::new(&candidate, task)?;
        let mut saved = SavedTask {
            name: task.name.clone(),
            value: tune.value,
            nominal: tune.nominal,
            at_rest: at_rest(&drive, &tune.parameters),
            unit: task.objective.unit.clone(),
            terms: Vec::new(),
            checks: Vec::new(),
            tests: Vec::new(),
            tested: None,
            drive: drive
                .labels(|id| names.get(id).unwrap_or_default().to_owned())
                .into_iter()
                .zip(tune.parameters.iter().copied())
                .collect(),
        };
        let driven = Driven::new(&candidate, &saved, Precision::Model)?;
        if let Ok(motion) = driven.motion(solver, Stop::NEVER)? {
            saved.terms = score::terms(driven.recording(&motion, None))?;
        }
        if let Some(half) = tune.half_step {
            saved.checks.push(Check::new(HALF_STEP, Measured::Value, Ok(half)));
        }
        design.tasks.push(saved);
    }
    Ok(design)
}

/// What this version of sgc says of a design of another: the same body and curves with the values of `replayed`. What
/// came out at other steps and in other worlds was said by the other version, and is left out.
///
/// # Errors
///
/// A sentence: a motion is not valid, or a preference has no value.
pub fn as_simulated(
    rules: &RuleSet,
    design: &SavedDesign,
    replayed: &Replayed<'_>,
) -> Result<SavedDesign, DesignError> {
    let mut now = design.clone();
    now.value = replayed.value.ok_or(DesignError::OtherValue)?;
    now.beside = beside(rules, &replayed.beside);
    now.penalties = score::penalties(rules, &replayed.candidate.derivation)?;
    now.observed = replayed.observed.clone();
    for (saved, task) in now.tasks.iter_mut().zip(&replayed.tasks) {
        let score = task.score.as_ref().ok_or(DesignError::OtherValue)?;
        saved.value = score.value;
        saved.terms = score.terms.clone();
        saved.nominal = task.nominal;
        (saved.checks, saved.tests, saved.tested) = (Vec::new(), Vec::new(), None);
    }
    now.of_all = None;
    Ok(now)
}

/// What a design comes to in the objectives beside the first, as it is saved.
pub(super) fn beside(rules: &RuleSet, values: &[f64]) -> Vec<Beside> {
    let one = |(objective, value): (&Objective, &f64)| Beside {
        objective: objective_name(rules, objective),
        value: *value,
        unit: objective.unit.clone(),
    };
    rules.beside().iter().zip(values).map(one).collect()
}

/// What each objective of the whole grammar is where nothing moves; what has no value there, such as a ratio of two tasks, is 0.
pub(super) fn all_at_rest(candidate: &Candidate<'_>, design: &SavedDesign) -> Result<Vec<f64>, DesignError> {
    let rules = candidate.rules;
    let (mut tasks, mut each) = (Vec::with_capacity(design.tasks.len()), Vec::new());
    for saved in &design.tasks {
        let (drive, parameters) = drive_of(candidate, saved)?;
        let values = score::at_rest(&drive, &parameters).unwrap_or_default();
        tasks.push((saved.name.as_str(), values.first().copied().unwrap_or(0.0)));
        each = values;
    }
    let first = score::outcome(rules, &candidate.derivation, &tasks).unwrap_or(0.0);
    let beside = score::beside(rules, &candidate.derivation, &tasks, &each).unwrap_or_default();
    let beside = beside.into_iter().chain(std::iter::repeat(0.0)).take(rules.beside().len());
    Ok(std::iter::once(first)
        .chain(beside)
        .map(|value| if value.is_finite() { value } else { 0.0 })
        .collect())
}

/// What the objective of a task is where nothing moves, if its text does not say that.
pub(super) fn at_rest(drive: &Drive<'_>, parameters: &[f64]) -> Option<f64> {
    let (rules, objective) = (drive.candidate().rules, &drive.task().objective);
    let value = score::at_rest(drive, parameters)?.first().copied()?;
    (value != objective.offset(rules)).then_some(value)
}
