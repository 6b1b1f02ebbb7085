//! Rewards that fall where the objective rises.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::Direction;

use super::{Trial, Trials, odd};
use crate::derive::random::Stream;
use crate::drive::{Conditions, Exploration, Explorer};
use crate::score::{Recording, quantities};
use crate::search::{settings, solver};
use crate::simulate::{Stop, World};

/// How many motions are made with actions at random.
const MOTIONS: u64 = 16;
/// So many of them must have a value and a sum of rewards.
const ENOUGH: usize = 12;
/// A rank correlation below this is no accident: of twelve motions, it happens in one of two hundred rewards that have nothing to do with the objective.
const AGAINST: f64 = -0.7;

/// Decides at random, and adds up what it gains.
#[derive(Debug)]
struct AtRandom {
    outputs: usize,
    random: Stream,
    gained: f64,
}

impl Explorer for AtRandom {
    fn gain(&mut self, reward: f64) {
        self.gained += reward;
    }

    fn decide(&mut self, _: usize, _: &[f64]) -> Vec<f64> {
        // Where the greatest of several outputs is taken, each is as likely.
        (0..self.outputs).map(|_| 4.0 * self.random.unit() - 2.0).collect()
    }
}

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    let trial = trials.trials.first()?;
    let reward = trial.drive.decision()?.policy.reward.as_ref()?;
    let objective = &trial.drive.task().objective;
    let pairs = explored(trial)?;
    let sign = match objective.direction {
        Direction::Maximize => 1.0,
        Direction::Minimize => -1.0,
    };
    let (gained, values): (Vec<f64>, Vec<f64>) =
        pairs.iter().map(|(gain, value)| (*gain, sign * value)).unzip();
    (pairs.len() >= ENOUGH && rank_correlation(&gained, &values)? < AGAINST).then(|| {
        odd(reward.span, "this reward falls where the objective rises".to_owned())
            .label(format!("so in {} short motions with actions at random", pairs.len()))
            .also(objective.value.span, "of this objective")
            .help("a learner makes the reward large: is it subtracted the wrong way round? The way forward is the later position minus the earlier one")
    })
}

/// What motions with random actions gain, and the value of each.
fn explored(trial: &Trial<'_>) -> Option<Vec<(f64, f64)>> {
    let (drive, task) = (&trial.drive, trial.drive.task());
    let candidate = drive.candidate();
    let parameters = &trial.motions.first()?.parameters;
    let outputs = drive.decision()?.spaces.iter().map(|space| space.outputs()).sum();
    let mut simulation =
        solver(candidate.rules).model().prepare(&candidate.body.assembly, &settings(&task.model)).ok()?;
    let mut pairs = Vec::new();
    for number in 0..MOTIONS {
        let random = Stream::named(number, "trials of a reward");
        let mut explorer = AtRandom { outputs, random, gained: 0.0 };
        let conditions = Conditions { world: format!("motion {number}"), ..Conditions::NOMINAL };
        let exploration = Exploration::new(drive, parameters, &conditions, &mut explorer).ok()?;
        let motion = simulation.run_cases(Stop::NEVER, &[exploration.case(&World::NOMINAL)])?.pop()?;
        let (None, Ok(motion)) = (exploration.failed(), motion) else { continue };
        let value = quantities(Recording::nominal(drive, parameters, &motion), &[&task.objective.value]);
        pairs.extend(value.ok().and_then(|mut values| values.pop()).map(|value| (explorer.gained, value)));
    }
    Some(pairs)
}

/// Spearman's rank correlation; none where values are equal.
fn rank_correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let ranks = |of: &[f64]| -> Option<Vec<f64>> {
        let ties = of.iter().enumerate().any(|(place, x)| of[..place].contains(x));
        let rank = |x: &f64| of.iter().filter(|other| *other < x).count() as f64;
        (!ties).then(|| of.iter().map(rank).collect())
    };
    let count = a.len() as f64;
    let squares: f64 = ranks(a)?.iter().zip(ranks(b)?).map(|(x, y)| (x - y) * (x - y)).sum();
    Some(1.0 - 6.0 * squares / (count * (count * count - 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_two_lists_are_compared() {
        assert_eq!(rank_correlation(&[1.0, 2.0, 5.0], &[-3.0, 0.0, 9.0]), Some(1.0));
        assert_eq!(rank_correlation(&[1.0, 2.0, 5.0], &[9.0, 0.0, -3.0]), Some(-1.0));
        assert_eq!(rank_correlation(&[1.0, 1.0, 5.0], &[9.0, 0.0, -3.0]), None);
    }
}
