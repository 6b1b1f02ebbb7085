//! Nested simulated annealing: bodies outside, curves of a body inside
//! (thesis 5.3, algorithm 5.12 with the readings given in `docs/search.md`).
//!
//! The same rule set and seed give the same result, bit for bit, whatever the
//! number of threads: every move has its own named stream of random numbers, and
//! evaluations that were started ahead of time but turn out not to be needed
//! are neither counted nor used.
//!
//! All that the loops know is in [`State`]: it can be saved between any two batches of
//! evaluations, and a search that goes on from it gives the same result, bit for bit.

mod aim;
mod bodies;
mod body;
mod cache;
mod crew;
mod curves;
mod evaluated;
mod evaluator;
mod fidelity;
mod gains;
mod learned;
mod observer;
mod schedule;
mod state;
mod tally;

use std::sync::atomic::AtomicBool;
use thiserror::Error;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::Direction;

pub(crate) use bodies::front::hypervolume;
pub use bodies::{go_on, run, tune_body};
pub use crew::{Jobs, Threads};
pub use evaluator::{settings, solver, unfit};
pub use learned::Learned;
pub use observer::{Observer, Outcome, Row};
pub use state::{Best, State, Tune};
pub use tally::Tally;

use crate::simulate::{Stop, Unfit};

/// So many moves in a row that can do nothing end a search.
const MOST_IDLE_MOVES: usize = 1000;

/// What bounds a search from outside.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The seed of every random stream.
    pub seed: u64,
    /// The threads that evaluate.
    pub jobs: Jobs,
    /// How many evaluations each thread makes side by side at most, if not as many as the solver can. It changes
    /// nothing but speed.
    pub lanes: Option<usize>,
    /// Whether simulations are given up that cannot come to a value that would be accepted. It changes nothing
    /// but speed.
    pub gives_up: bool,
    /// The search ends when it has spent this many evaluations.
    pub max_evaluations: Option<u64>,
    /// The search is stopped at this time.
    pub deadline: Option<std::time::Instant>,
}

/// Why an [`Observer`] cannot keep what a search found.
pub type Unkept = Box<dyn std::error::Error + Send + Sync>;

/// Why a search cannot go on.
#[derive(Debug, Error)]
pub enum Failure {
    /// An expression of the grammar has no value.
    #[error("{}", .0.reason)]
    Expression(EvalError),
    /// The model cannot simulate a design.
    #[error("{}", .0.reason)]
    Unfit(Unfit),
    /// Results cannot be kept.
    #[error(transparent)]
    Output(#[from] Unkept),
    /// A random walk of so many values gave the same value again and again.
    #[error(
        "the random walk found {0} designs of the same value, so it cannot give a temperature: make \
         `walk` longer, or write a temperature as a number"
    )]
    NoDeviation(usize),
    /// The threads could not be started.
    #[error("cannot start {wanted} threads: {why}")]
    Threads {
        /// How many.
        wanted: usize,
        /// The system's reason.
        why: rayon::ThreadPoolBuildError,
    },
}

impl From<EvalError> for Failure {
    fn from(error: EvalError) -> Self {
        Self::Expression(error)
    }
}

impl From<Unfit> for Failure {
    fn from(unfit: Unfit) -> Self {
        Self::Unfit(unfit)
    }
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Its schedule is over.
    Schedule,
    /// Its stopping rule says so.
    Stopped,
    /// No rule could be applied any more.
    Stuck,
    /// All evaluations are spent.
    Budget,
    /// The time is over.
    Time,
    /// It was interrupted.
    Interrupted,
}

impl End {
    /// Whether the search could go on from where it was stopped.
    #[must_use]
    pub fn is_early(self) -> bool {
        matches!(self, Self::Interrupted | Self::Time)
    }

    /// In words, for people and files.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Schedule => "the schedule is complete",
            Self::Stopped => "the stopping rule applied",
            Self::Stuck => "no rule could be applied any more (evals.csv says what blocked each)",
            Self::Budget => "the evaluations are spent",
            Self::Time => "the time is over",
            Self::Interrupted => "interrupted",
        }
    }
}

/// What bounds a search from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds<'a> {
    max_evaluations: Option<u64>,
    lanes: Option<usize>,
    gives_up: bool,
    stop: Stop<'a>,
}

impl<'a> Bounds<'a> {
    fn new(limits: &Limits, flag: &'a AtomicBool) -> Self {
        Self {
            max_evaluations: limits.max_evaluations,
            lanes: limits.lanes,
            gives_up: limits.gives_up,
            stop: Stop::new(flag, limits.deadline),
        }
    }

    /// The same, as long as a flag is not set.
    fn by(self, flag: &AtomicBool) -> Bounds<'_> {
        Bounds { stop: self.stop.by(flag), ..self }
    }

    /// The same whatever is spent: for work that may be in vain.
    fn unbounded(self) -> Self {
        Self { max_evaluations: None, ..self }
    }

    /// Why nothing more may be spent after so many evaluations, if so.
    fn exhausted(&self, spent: u64) -> Option<End> {
        if self.max_evaluations.is_some_and(|max| spent >= max) {
            return Some(End::Budget);
        }
        self.stopped()
    }

    /// How many evaluations may still be spent.
    fn left(&self, spent: u64) -> usize {
        let left = self.max_evaluations.map(|max| max.saturating_sub(spent));
        left.and_then(|left| usize::try_from(left).ok()).unwrap_or(usize::MAX)
    }

    /// Which share that is of the evaluations that may be spent; zero where nothing bounds them.
    fn share(&self, spent: u64) -> f64 {
        self.max_evaluations.map_or(0.0, |max| (spent as f64 / max.max(1) as f64).min(1.0))
    }

    /// Why to stop at once, if so.
    fn stopped(&self) -> Option<End> {
        if self.stop.is_interrupted() {
            return Some(End::Interrupted);
        }
        self.stop.is_late().then_some(End::Time)
    }
}

/// Metropolis's rule, with the random number drawn beforehand.
pub(crate) fn accepts(current: f64, candidate: f64, temperature: f64, drawn: f64) -> bool {
    candidate >= current || (temperature > 0.0 && drawn < libm::exp((candidate - current) / temperature))
}

/// Values that differ by less, in the unit of the objective, are the same: the noise of a robot at rest.
pub const NOTHING: f64 = 1e-4;

/// Whether another value of an objective keeps this share of a value. `at_rest` is its value where nothing moves, which is no part of
/// what a motion is worth.
#[must_use]
pub fn keeps(direction: Direction, at_rest: f64, share: f64, value: f64, other: f64) -> bool {
    let worth = (value - at_rest).abs();
    direction.fitness(other) >= direction.fitness(value) - (1.0 - share) * worth
}

#[cfg(test)]
mod tests {
    use super::accepts;

    #[test]
    fn better_is_always_accepted_and_worse_by_its_probability() {
        assert!(accepts(1.0, 1.0, 0.0, 0.99));
        assert!(accepts(1.0, 2.0, 9.0, 0.99));
        // exp(-9/9) = 0.3679
        assert!(accepts(10.0, 1.0, 9.0, 0.36));
        assert!(!accepts(10.0, 1.0, 9.0, 0.37));
        assert!(!accepts(10.0, 1.0, 0.0, 0.0));
        assert!(!accepts(10.0, f64::NEG_INFINITY, 9.0, 0.0));
    }
}
