//! What a search tells of itself: its moves, its bests, and what it came to.

use super::learned::Learned;
use super::state::{Best, State};
use super::tally::Tally;
use super::{End, Unkept};
use crate::score::Observed;

/// One move of a body, for the record.
#[derive(Clone, Debug)]
pub struct Row {
    /// The number of the move, from 1; 0 is the initial design.
    pub number: usize,
    /// The iteration it belongs to.
    pub iteration: usize,
    /// The annealing chain whose current design it changed.
    pub chain: usize,
    /// The move that made the design that it changed; none for the initial design.
    pub parent: Option<usize>,
    /// The rule that was applied; none if nothing could be, or if curves were tuned further.
    pub rule: Option<String>,
    /// How often the curves of this body were tuned before.
    pub tuned: usize,
    /// Rules that were drawn but blocked, and by what.
    pub blocked: Vec<(String, String)>,
    /// How many parts and actuators the design has.
    pub size: (usize, usize),
    /// The value of the design; none if no evaluation was valid.
    pub value: Option<f64>,
    /// What the objective is of its motion in the nominal world alone, where the grammar has one task and that runs over
    /// others, too.
    pub nominal: Option<f64>,
    /// In how many worlds the value was simulated, where it need not be known in all: it is that of the worst of them, and in all
    /// together no better.
    pub at_most_in: Option<u64>,
    /// Whether it became the current design.
    pub accepted: bool,
    /// The best value so far.
    pub best: Option<f64>,
    /// The temperature.
    pub temperature: f64,
    /// What the design comes to in the objectives beside the first, where a front is searched for.
    pub beside: Vec<f64>,
    /// All evaluations spent so far.
    pub evaluations: u64,
    /// Failed evaluations of this move.
    pub tally: Tally,
    /// What was observed of the design with its best curves, in the order of the rule set; empty if it has no value.
    pub observed: Vec<Option<Observed>>,
}

/// Follows a search.
pub trait Observer {
    /// Called often: evaluations spent, the best value of the current body, the temperature of its curves.
    fn evaluated(&mut self, spent: u64, body: Option<f64>, temperature: f64);
    /// Called after each move of a body.
    ///
    /// # Errors
    ///
    /// Why it cannot be kept; the search ends with it.
    fn moved(&mut self, row: &Row) -> Result<(), Unkept>;
    /// Called for each new best design; and when the search is stopped, for one whose curves
    /// are not tuned to the end.
    ///
    /// # Errors
    ///
    /// Why it cannot be kept; the search ends with it.
    fn improved(&mut self, best: &Best) -> Result<(), Unkept>;
    /// Called for each new best of its kind, where a search keeps an archive: all that it keeps, by the cells
    /// of its descriptors, and the place of the new one.
    ///
    /// # Errors
    ///
    /// Why it cannot be kept; the search ends with it.
    fn kept(&mut self, archive: &[(Vec<usize>, Best)], new: usize) -> Result<(), Unkept> {
        let _ = (archive, new);
        Ok(())
    }
    /// Called for each new design on a front, where a search keeps one, with all designs that are on it now.
    ///
    /// # Errors
    ///
    /// Why it cannot be kept; the search ends with it.
    fn on_front(&mut self, front: &[Best]) -> Result<(), Unkept> {
        let _ = front;
        Ok(())
    }
    /// Called wherever the search could go on from: after each batch of evaluations and each outer
    /// move; `last` when it has been stopped and will not go on by itself.
    ///
    /// # Errors
    ///
    /// Why it cannot be kept; the search ends with it.
    fn checkpoint(&mut self, state: &State, last: bool) -> Result<(), Unkept> {
        let _ = (state, last);
        Ok(())
    }
}

/// What a search found.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best design; none if no evaluation was valid.
    pub best: Option<Best>,
    /// The best of each kind, by cell; none where the search keeps no archive.
    pub archive: Vec<(Vec<usize>, Best)>,
    /// The designs that no other is better than in every objective; none where no front is searched for.
    pub front: Vec<Best>,
    /// What the learners came to in each iteration, by the number of the task; empty where nothing learns.
    pub learned: Vec<(usize, Vec<Learned>)>,
    /// Evaluations spent.
    pub evaluations: u64,
    /// Outer moves made.
    pub moves: usize,
    /// Bodies whose curves were tuned.
    pub bodies: usize,
    /// Failed evaluations.
    pub tally: Tally,
    /// Why it ended.
    pub end: End,
}
