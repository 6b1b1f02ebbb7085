//! A saved design in other worlds: those of scenarios.

use grammar_lang::eval::quantile;
use grammar_lang::ir::{Direction, RuleSet};

use super::DesignError;
use super::replay::{Driven, How, candidate};
use super::saved::{SavedDesign, SavedTask};
use crate::derive::Candidate;
use crate::scenarios::Scenario;
use crate::score;
use crate::simulate::Invalid;

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
) -> Result<Vec<Result<f64, Invalid>>, DesignError> {
    let driven = Driven::new(candidate, saved, how.precision)?;
    let motions = driven.motions(scenarios, how.solver, how.stop)?;
    let value = |(scenario, motion): (&Scenario, Result<_, Invalid>)| match motion {
        Ok(motion) => Ok(Ok(score::objective(driven.recording(&motion, Some(scenario)))?)),
        Err(why) => Ok(Err(why)),
    };
    scenarios.iter().zip(motions).map(value).collect()
}

/// Simulates all tasks of a design in several worlds.
///
/// # Errors
///
/// A sentence that says what does not fit, or that it was stopped.
pub fn judge(
    rules: &RuleSet,
    design: &SavedDesign,
    scenarios: Vec<Scenario>,
    how: How<'_>,
) -> Result<Vec<Judged>, DesignError> {
    let candidate = candidate(rules, design)?;
    if design.tasks.len() != rules.tasks.len() {
        return Err(DesignError::OtherTasks);
    }
    let mut tasks = Vec::with_capacity(design.tasks.len());
    for saved in &design.tasks {
        tasks.push((saved.name.as_str(), values(&candidate, saved, &scenarios, how)?));
    }
    let judged = scenarios.into_iter().enumerate().map(|(place, scenario)| {
        let values: Result<Vec<(&str, f64)>, Invalid> =
            tasks.iter().map(|(name, values)| Ok((*name, values[place]?))).collect();
        let value = match values {
            Err(why) => Err(why),
            Ok(values) => Ok(score::outcome(rules, &candidate.derivation, &values)?),
        };
        Ok(Judged { scenario, value })
    });
    judged.collect()
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

/// What a design comes to in the worlds that it was tested in at the end of its run: in its first task that was.
#[must_use]
pub fn tested(rules: &RuleSet, design: &SavedDesign) -> Option<Together> {
    let saved = design.tasks.iter().find(|saved| !saved.tests.is_empty())?;
    let values: Vec<Option<f64>> = saved.tests.iter().map(|world| world.value).collect();
    together(rules.tasks.get(&saved.name)?.objective.direction, &values)
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
