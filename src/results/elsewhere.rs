//! What a saved design is worth in other worlds.

use grammar_lang::ir::{Direction, RuleSet};

use super::DesignError;
use super::replay::{Precision, candidate, drive_of};
use super::saved::SavedDesign;
use crate::scenarios::Scenario;
use crate::score::{self, Recording};
use crate::search::settings;
use crate::simulate::{self, Case, Invalid, Stop};

/// What a design came to in one world.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The world.
    pub scenario: Scenario,
    /// The value of the whole grammar's objective there, or why a motion has none.
    pub value: Result<f64, Invalid>,
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
    solver: &str,
    precision: Precision,
    stop: Stop<'_>,
) -> Result<Vec<Judged>, DesignError> {
    let candidate = candidate(rules, design)?;
    let model = simulate::model(solver).ok_or_else(|| DesignError::NoSolver(solver.to_owned()))?;
    if design.tasks.len() != rules.tasks.len() {
        return Err(DesignError::OtherTasks);
    }
    let mut values: Vec<Vec<(&str, f64)>> = vec![Vec::new(); scenarios.len()];
    let mut failed: Vec<Option<Invalid>> = vec![None; scenarios.len()];
    for saved in &design.tasks {
        let (drive, parameters) = drive_of(&candidate, saved)?;
        let count = candidate.body.actuators.len();
        let mut moving = Vec::with_capacity(scenarios.len());
        for scenario in &scenarios {
            let targets = drive.targets_under(&parameters, &scenario.conditions(count))?;
            moving.push((targets, scenario.world()));
        }
        let cases: Vec<Case<'_>> = moving.iter().map(|(drive, world)| Case { drive, world }).collect();
        let settings = precision.apply(settings(&drive.task().model));
        let mut simulation = model.prepare(&candidate.body.assembly, &settings)?;
        let motions =
            simulation.run_cases(stop, &cases).ok_or(DesignError::Stopped("all worlds were simulated"))?;
        for (((motion, scenario), values), failed) in
            motions.iter().zip(&scenarios).zip(&mut values).zip(&mut failed)
        {
            match motion {
                Ok(motion) => {
                    let recording = Recording {
                        scenario: Some(scenario),
                        ..Recording::nominal(&drive, &parameters, motion)
                    };
                    values.push((saved.name.as_str(), score::objective(recording)?));
                }
                Err(why) => *failed = failed.or(Some(*why)),
            }
        }
    }
    let judged = scenarios.into_iter().zip(values).zip(failed).map(|((scenario, values), failed)| {
        let value = match failed {
            Some(why) => Err(why),
            None => Ok(score::outcome(rules, &candidate.derivation, &values)?),
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

/// Sums up; none of no world.
#[must_use]
pub fn together(direction: Direction, judged: &[Judged]) -> Option<Together> {
    let fitness = |judged: &Judged| judged.value.map_or(f64::NEG_INFINITY, |value| direction.fitness(value));
    let mut order: Vec<usize> = (0..judged.len()).collect();
    // Stable: of several the first is the worst.
    order.sort_by(|a, b| fitness(&judged[*a]).total_cmp(&fitness(&judged[*b])));
    let worst = *order.first()?;
    let values: Vec<f64> = judged.iter().filter_map(|judged| judged.value.ok()).collect();
    let without = judged.len() - values.len();
    let mean = (without == 0).then(|| values.iter().sum::<f64>() / values.len() as f64);
    // Between two worlds in proportion, as quantiles are elsewhere.
    let place = 0.1 * (judged.len() - 1) as f64;
    let (low, part) = (libm::floor(place) as usize, place - libm::floor(place));
    let of = |place: usize| order.get(place).and_then(|one| judged[*one].value.ok());
    let tenth = match of(low) {
        Some(value) if part > 0.0 => of(low + 1).map(|next| value + (next - value) * part),
        value => value,
    };
    Some(Together { without, mean, tenth, worst })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(values: &[Option<f64>]) -> Vec<Judged> {
        let set = grammar_lang::ir::Scenarios {
            ranges: indexmap::IndexMap::new(),
            drawn: values.len() - 1,
            cases: indexmap::IndexMap::new(),
            span: grammar_lang::source::Span::default(),
        };
        let worlds = crate::scenarios::worlds("any", &set);
        let one = |(scenario, value): (Scenario, &Option<f64>)| Judged {
            scenario,
            value: value.ok_or(Invalid::TooFast),
        };
        worlds.into_iter().zip(values).map(one).collect()
    }

    #[test]
    fn nine_of_ten_worlds_are_better_than_the_tenth() {
        let values: Vec<_> = (0..11).map(|n| Some(f64::from((n * 7) % 11))).collect();
        let up = together(Direction::Maximize, &judged(&values)).unwrap();
        assert_eq!((up.mean, up.tenth, up.worst, up.without), (Some(5.0), Some(1.0), 0, 0));
        let down = together(Direction::Minimize, &judged(&values)).unwrap();
        assert_eq!((down.tenth, values[down.worst]), (Some(9.0), Some(10.0)));
        let three = together(Direction::Maximize, &judged(&[Some(1.0), Some(3.0), Some(2.0)])).unwrap();
        assert!((three.tenth.unwrap() - 1.2).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_value_is_worse_than_any() {
        let values: Vec<_> = (0..21).map(|n| (n != 5).then_some(f64::from(n) - 30.0)).collect();
        for direction in [Direction::Maximize, Direction::Minimize] {
            let found = together(direction, &judged(&values)).unwrap();
            assert_eq!((found.mean, found.worst, found.without), (None, 5, 1));
            assert!(found.tenth.is_some());
        }
        let half: Vec<_> = (0..4).map(|n| (n > 1).then_some(1.0)).collect();
        assert_eq!(together(Direction::Maximize, &judged(&half)).unwrap().tenth, None);
        assert_eq!(together(Direction::Maximize, &[]), None);
    }
}
