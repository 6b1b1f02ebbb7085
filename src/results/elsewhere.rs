//! A saved design in other worlds: those of scenarios.

use grammar_lang::eval::quantile;
use grammar_lang::ir::{Direction, RuleSet};

use super::DesignError;
use super::replay::{Driven, How, candidate};
use super::saved::{InWorld, SavedDesign, SavedTask};
use crate::derive::Candidate;
use crate::scenarios::Scenario;
use crate::score::{self, Recording};
use crate::simulate::{Invalid, Motion};

/// What each of several worlds came to, in their order.
pub(super) type Each = Vec<Result<f64, Invalid>>;

/// What a design came to in one world.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The world.
    pub scenario: Scenario,
    /// The value of the whole grammar's objective there, or why a motion has none.
    pub value: Result<f64, Invalid>,
}

/// What the objective of a task is of the motion in each world, and of that alone.
pub(super) fn values(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    scenarios: &[Scenario],
    how: How<'_>,
) -> Result<Each, DesignError> {
    let driven = Driven::new(candidate, saved, how.precision)?;
    let motions = driven.motions(scenarios, how.solver, how.stop)?;
    each(&driven, scenarios, &motions)
}

/// The same, and what the objective is over all of these worlds, where each has a motion. The first world is the nominal one.
pub(super) fn values_and_whole(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    scenarios: &[Scenario],
    how: How<'_>,
) -> Result<(Each, Option<f64>), DesignError> {
    let driven = Driven::new(candidate, saved, how.precision)?;
    let motions = driven.motions(scenarios, how.solver, how.stop)?;
    let values = each(&driven, scenarios, &motions)?;
    let Ok(mut motions) = motions.into_iter().collect::<Result<Vec<Motion>, Invalid>>() else {
        return Ok((values, None));
    };
    let nominal = motions.remove(0);
    let elsewhere: Vec<(Scenario, Motion)> = scenarios[1..].iter().cloned().zip(motions).collect();
    let recording = Recording { elsewhere: &elsewhere, ..driven.recording(&nominal, None) };
    Ok((values, Some(score::objective(recording)?)))
}

fn each(
    driven: &Driven<'_>,
    scenarios: &[Scenario],
    motions: &[Result<Motion, Invalid>],
) -> Result<Each, DesignError> {
    let value = |(scenario, motion): (&Scenario, &Result<Motion, Invalid>)| match motion {
        Ok(motion) => Ok(Ok(score::objective(driven.recording(motion, Some(scenario)))?)),
        Err(why) => Ok(Err(*why)),
    };
    scenarios.iter().zip(motions).map(value).collect()
}

/// Simulates all tasks of a design in several worlds, the nominal one first: what it comes to in each, and over all of them, if
/// it has a value in each.
///
/// # Errors
///
/// A sentence that says what does not fit, or that it was stopped.
pub fn judge(
    rules: &RuleSet,
    design: &SavedDesign,
    scenarios: Vec<Scenario>,
    how: How<'_>,
) -> Result<(Vec<Judged>, Option<f64>), DesignError> {
    let candidate = candidate(rules, design)?;
    if design.tasks.len() != rules.tasks.len() {
        return Err(DesignError::OtherTasks);
    }
    let mut tasks = Vec::with_capacity(design.tasks.len());
    for saved in &design.tasks {
        tasks.push((saved.name.as_str(), values_and_whole(&candidate, saved, &scenarios, how)?));
    }
    let judged = scenarios.into_iter().enumerate().map(|(place, scenario)| {
        let values: Result<Vec<(&str, f64)>, Invalid> =
            tasks.iter().map(|(name, (values, _))| Ok((*name, values[place]?))).collect();
        let value = match values {
            Err(why) => Err(why),
            Ok(values) => Ok(score::outcome(rules, &candidate.derivation, &values)?),
        };
        Ok(Judged { scenario, value })
    });
    let judged = judged.collect::<Result<Vec<_>, DesignError>>()?;
    let whole: Option<Vec<(&str, f64)>> =
        tasks.iter().map(|(name, (_, whole))| Some((*name, (*whole)?))).collect();
    let whole = whole.map(|values| score::outcome(rules, &candidate.derivation, &values)).transpose()?;
    Ok((judged, whole))
}

/// What several worlds come to. A motion without a value counts as worse than any.
#[derive(Clone, Debug, PartialEq)]
pub struct Together {
    /// In how many worlds there is no value.
    pub without: usize,
    /// The mean of the values; none where a world has none.
    pub mean: Option<f64>,
    /// What nine of ten worlds are at least as good as; none where one in ten has no value.
    pub tenth: Option<f64>,
    /// The place of the world that was worst.
    pub worst: usize,
}

/// Sums values of worlds up; none of no world.
#[must_use]
pub fn together(direction: Direction, values: &[Option<f64>]) -> Option<Together> {
    let fitness = |value: &Option<f64>| value.map_or(f64::NEG_INFINITY, |value| direction.fitness(value));
    let mut all: Vec<f64> = values.iter().map(fitness).collect();
    // Of several the first is the worst.
    let worst = (0..all.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    let known: Vec<f64> = values.iter().filter_map(|value| *value).collect();
    let without = values.len() - known.len();
    let mean = (without == 0).then(|| known.iter().sum::<f64>() / known.len() as f64);
    let tenth = (all.len() >= 10).then(|| quantile(&mut all, 0.1));
    let tenth = tenth.filter(|tenth| tenth.is_finite()).map(|tenth| direction.fitness(tenth));
    Some(Together { without, mean, tenth, worst })
}

/// What a design comes to in the worlds that it was tested in at the end of its run.
#[derive(Clone, Debug, PartialEq)]
pub enum Tested {
    /// In each of them.
    Each(Together),
    /// Over all of them, where no world alone shows what the objective asks for; none where one has no value.
    Whole(Option<f64>),
}

impl Tested {
    /// What each world comes to, where that tells.
    #[must_use]
    pub fn each(&self) -> Option<&Together> {
        if let Self::Each(together) = self { Some(together) } else { None }
    }

    /// What all of them come to, where they do not tell one by one.
    #[must_use]
    pub fn whole(&self) -> Option<f64> {
        if let Self::Whole(value) = self { *value } else { None }
    }
}

/// What a design comes to in the worlds that it was tested in at the end of its run. Of several tasks: by the objective of the whole grammar,
/// if all of them were tested in the same worlds, and each world alone tells what they ask for.
#[must_use]
pub fn tested(rules: &RuleSet, design: &SavedDesign) -> Option<Tested> {
    if !rules.tasks.contains_key(RuleSet::ONLY_TASK) {
        return tested_in_tasks(rules, design);
    }
    let saved = design.tasks.iter().find(|saved| !saved.tests.is_empty())?;
    let objective = &rules.tasks.get(&saved.name)?.objective;
    let less = |value: f64| design.less_penalties(objective.direction, value);
    if !objective.is_told_by_each_world() {
        return Some(Tested::Whole(saved.tested.map(less)));
    }
    let values: Vec<Option<f64>> = saved.tests.iter().map(|world| world.value.map(less)).collect();
    together(objective.direction, &values).map(Tested::Each)
}

fn tested_in_tasks(rules: &RuleSet, design: &SavedDesign) -> Option<Tested> {
    let first = &design.tasks.first()?.tests;
    let is_alike = |saved: &SavedTask| {
        let names = |worlds: &[InWorld]| -> Vec<(String, String)> {
            worlds.iter().map(|world| (world.name.clone(), world.differs.clone())).collect()
        };
        let told = rules.tasks.get(&saved.name).is_some_and(|task| task.objective.is_told_by_each_world());
        told && names(&saved.tests) == names(first)
    };
    if design.tasks.len() != rules.tasks.len() || !design.tasks.iter().all(is_alike) {
        return None;
    }
    let candidate = candidate(rules, design).ok()?;
    let in_world = |place: usize| {
        let values =
            design.tasks.iter().map(|saved| Some((saved.name.as_str(), saved.tests.get(place)?.value?)));
        score::outcome(rules, &candidate.derivation, &values.collect::<Option<Vec<_>>>()?).ok()
    };
    let values: Vec<Option<f64>> = (0..first.len()).map(in_world).collect();
    together(rules.objective.direction, &values).map(Tested::Each)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_of_ten_worlds_are_better_than_the_tenth() {
        let values: Vec<_> = (0..11).map(|n| Some(f64::from((n * 7) % 11))).collect();
        let up = together(Direction::Maximize, &values).unwrap();
        assert_eq!((up.mean, up.tenth, up.worst, up.without), (Some(5.0), Some(1.0), 0, 0));
        let down = together(Direction::Minimize, &values).unwrap();
        assert_eq!((down.tenth, values[down.worst]), (Some(9.0), Some(10.0)));
        let ten: Vec<_> = (0..10).map(|n| Some(f64::from(n))).collect();
        assert!((together(Direction::Maximize, &ten).unwrap().tenth.unwrap() - 0.9).abs() < 1e-12);
        assert_eq!(
            together(Direction::Maximize, &ten[1..]).unwrap().tenth,
            None,
            "of nine there is no tenth"
        );
    }

    #[test]
    fn what_has_no_value_is_worse_than_any() {
        let values: Vec<_> = (0..21).map(|n| (n != 5).then_some(f64::from(n) - 30.0)).collect();
        for direction in [Direction::Maximize, Direction::Minimize] {
            let found = together(direction, &values).unwrap();
            assert_eq!((found.mean, found.worst, found.without), (None, 5, 1));
            assert!(found.tenth.is_some());
        }
        let half: Vec<_> = (0..20).map(|n| (n > 9).then_some(1.0)).collect();
        assert_eq!(together(Direction::Maximize, &half).unwrap().tenth, None);
        assert_eq!(together(Direction::Maximize, &[]), None);
    }
}
