//! What the expressions of a schedule can read, and their values.

use grammar_lang::eval::{EvalError, Scope, Value, evaluate};
use grammar_lang::ir::{Annealing, Direction, Expr, RuleSet, Schedule, SearchWord, Selection, Word};

use serde::{Deserialize, Serialize};

use crate::derive::{Derivation, DesignScope};

/// The course of a loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Course {
    /// Iterations that are complete.
    pub(super) iteration: usize,
    /// The best value after each iteration; the first is the value at the start.
    pub(super) bests: Vec<f64>,
    /// What is better.
    pub(super) direction: Direction,
    /// The standard deviation of the values of the random walk, once that is made.
    pub(super) deviation: Option<f64>,
}

/// Where one of the chains of a loop stands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Standing {
    /// The temperature of its iteration.
    pub(super) temperature: f64,
    /// Moves in a row that were not accepted.
    pub(super) refused: u64,
    /// Whether a move of this iteration was accepted.
    pub(super) moved: bool,
    /// Iterations in a row without an accepted move.
    pub(super) stagnant: u64,
}

impl Standing {
    /// Notes whether a move was accepted.
    pub(super) fn note(&mut self, accepted: bool) {
        self.refused = if accepted { 0 } else { self.refused + 1 };
        self.moved |= accepted;
    }

    /// Notes the end of an iteration.
    pub(super) fn complete(&mut self) {
        self.stagnant = if self.moved { 0 } else { self.stagnant + 1 };
        self.moved = false;
    }
}

impl Course {
    /// A course that begins with a value; `None` if there is no valid one yet.
    pub(super) fn new(direction: Direction, first: Option<f64>) -> Self {
        Self { iteration: 0, bests: vec![first.unwrap_or(0.0)], direction, deviation: None }
    }

    /// Notes the end of an iteration.
    pub(super) fn complete(&mut self, best: Option<f64>) {
        self.iteration += 1;
        let last = self.bests.last().copied().unwrap_or(0.0);
        self.bests.push(best.unwrap_or(last));
    }

    fn best(&self) -> f64 {
        self.bests.last().copied().unwrap_or(0.0)
    }

    /// What the best gained over the last `n` iterations.
    fn gain(&self, n: usize) -> f64 {
        let before = self.bests.get(self.bests.len().saturating_sub(n + 1)).copied().unwrap_or(0.0);
        self.direction.fitness(self.best() - before)
    }

    /// Iterations since the best improved.
    fn idle(&self) -> usize {
        let best = self.best();
        self.bests.iter().rev().take_while(|b| **b == best).count().saturating_sub(1)
    }
}

/// An iteration under way. What the schedule says is asked once, where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Iteration {
    /// How many moves each chain has in it, and how many of them all have made.
    pub(super) moves: usize,
    pub(super) made: usize,
}

impl Iteration {
    /// How many moves each chain has still to make.
    pub(super) fn left(&self) -> usize {
        self.moves.saturating_sub(self.made)
    }
}

struct ScheduleScope<'a> {
    design: DesignScope<'a>,
    course: &'a Course,
    stand: Stand<'a>,
    around: Around,
}

/// What a loop knows of what is around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    /// How often the curves of the body were tuned before.
    pub(super) tuned: usize,
    /// The value of the design that the body was made of, on the scale of the objective.
    pub(super) parent: f64,
    /// The share of its evaluations that the run has spent; zero where nothing bounds them.
    pub(super) spent: f64,
}

/// What a schedule knows of the one that asks.
#[derive(Clone, Copy)]
pub(super) enum Stand<'a> {
    /// A chain, by its number.
    Chain(usize, &'a Standing),
    /// A distribution, by its spread.
    Distribution(f64),
    /// Designs that are kept, of which nothing more is known.
    Bodies,
}

impl Scope for ScheduleScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn word(&self, word: Word) -> Option<Value> {
        let course = self.course;
        let Word::Search(word) = word else { return self.design.word(word) };
        let standing = match self.stand {
            Stand::Chain(_, standing) => Some(standing),
            Stand::Distribution(_) | Stand::Bodies => None,
        };
        Some(Value::Number(match word {
            SearchWord::Iteration => course.iteration as f64,
            SearchWord::Best => course.best(),
            SearchWord::Idle => course.idle() as f64,
            SearchWord::Deviation => course.deviation?,
            SearchWord::Tuned => self.around.tuned as f64,
            SearchWord::Parent => self.around.parent,
            SearchWord::Spent => self.around.spent,
            // What always accepts something, or has no moves of its own, refuses nothing.
            SearchWord::Refused => standing.map_or(0.0, |standing| standing.refused as f64),
            SearchWord::Stagnant => standing.map_or(0.0, |standing| standing.stagnant as f64),
            SearchWord::Temperature => match standing {
                Some(standing) => standing.temperature,
                None => return self.design.word(Word::Search(word)),
            },
            SearchWord::Chain => match self.stand {
                Stand::Chain(number, _) => number as f64,
                Stand::Distribution(_) | Stand::Bodies => return None,
            },
            SearchWord::Spread => match self.stand {
                Stand::Distribution(spread) => spread,
                Stand::Chain(..) | Stand::Bodies => return None,
            },
        }))
    }

    fn gain(&self, iterations: usize) -> Option<f64> {
        Some(self.course.gain(iterations))
    }
}

/// A schedule with the design that it may read.
#[derive(Clone, Copy)]
pub(super) struct Plan<'a> {
    pub(super) rules: &'a RuleSet,
    pub(super) derivation: &'a Derivation,
    pub(super) schedule: &'a Schedule,
    pub(super) course: &'a Course,
    pub(super) stand: Stand<'a>,
    pub(super) around: Around,
}

impl Plan<'_> {
    fn value(&self, expr: &Expr) -> Result<Value, EvalError> {
        let Self { rules, derivation, course, stand, around, .. } = *self;
        let scope = ScheduleScope { design: DesignScope::new(rules, derivation), course, stand, around };
        evaluate(expr, &scope, &mut Vec::new())
    }

    fn number(&self, expr: &Expr) -> Result<f64, EvalError> {
        Ok(self.value(expr)?.as_number().unwrap_or(0.0).max(0.0))
    }

    fn is_true(&self, expr: &Expr) -> Result<bool, EvalError> {
        Ok(self.value(expr)? == Value::Bool(true))
    }

    /// The next iteration, with at least one move; none if the schedule has no more.
    pub(super) fn begin(&self) -> Result<Option<Iteration>, EvalError> {
        if self.course.iteration >= self.number(&self.schedule.iterations)? as usize {
            return Ok(None);
        }
        // Iterations without a move would go on without an end: they cost no evaluation.
        let moves = (self.number(&self.schedule.moves)? as usize).max(1);
        Ok(Some(Iteration { moves, made: 0 }))
    }

    /// How many designs are kept, within the limits of the field: what a schedule comes to may lie beyond them.
    pub(super) fn size(&self, selection: &Selection, is_front: bool) -> Result<usize, EvalError> {
        let [size, ..] = Selection::limits(is_front);
        Ok(self.number(&selection.size)?.clamp(size.low, size.high) as usize)
    }

    /// How many designs a move chooses among, and the share of moves that tune curves further, within their limits.
    pub(super) fn choice(&self, selection: &Selection) -> Result<(usize, f64), EvalError> {
        let [_, tournament, further] = Selection::limits(false);
        Ok((
            self.number(&selection.tournament)?.clamp(tournament.low, tournament.high) as usize,
            self.number(&selection.further)?.clamp(further.low, further.high),
        ))
    }

    /// The temperature of the iteration that begins.
    pub(super) fn temperature(&self, annealing: &Annealing) -> Result<f64, EvalError> {
        self.number(&annealing.temperature)
    }

    /// Whether the stopping rule applies, after an iteration.
    pub(super) fn stops(&self) -> Result<bool, EvalError> {
        self.is_true(&self.schedule.stop)
    }

    /// How likely a learner draws an action evenly.
    pub(super) fn exploration(&self, exploration: &Expr) -> Result<f64, EvalError> {
        Ok(self.number(exploration)?.min(1.0))
    }

    /// Whether chains may change places now.
    pub(super) fn exchanges(&self, annealing: &Annealing) -> Result<bool, EvalError> {
        annealing.exchange.as_ref().map_or(Ok(false), |exchange| self.is_true(exchange))
    }

    /// Whether to begin anew, by what the method says of it.
    pub(super) fn restarts(&self, restart: Option<&Expr>) -> Result<bool, EvalError> {
        restart.map_or(Ok(false), |restart| self.is_true(restart))
    }
}

/// The sample standard deviation of values; zero of fewer than two.
pub(super) fn deviation(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    libm::sqrt(squares / (values.len() - 1) as f64)
}

/// The chains that may change places after an iteration, each with the next: in turns those from the first on and
/// those from the second on.
pub(super) fn neighbours(chains: usize, iteration: usize) -> impl Iterator<Item = usize> {
    (iteration % 2..chains.saturating_sub(1)).step_by(2)
}

/// Whether a chain and the next, which is warmer or colder, change places (replica exchange, Geyer 1991):
/// by the temperatures and the fitness of both, and a random number drawn beforehand.
pub(super) fn exchange((t, fitness): (f64, f64), (other_t, other_fitness): (f64, f64), drawn: f64) -> bool {
    let gain = other_fitness - fitness;
    if gain.is_nan() || t == other_t {
        return false;
    }
    // What the colder one gains is always taken.
    let colder_gains = if t < other_t { gain > 0.0 } else { gain < 0.0 };
    if colder_gains || t <= 0.0 || other_t <= 0.0 {
        return colder_gains;
    }
    drawn < libm::exp((1.0 / t - 1.0 / other_t) * gain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_and_idle_follow_the_best() {
        let mut course = Course::new(Direction::Maximize, Some(-2.0));
        for best in [1.0, 1.0, 4.0, 4.0, 4.0] {
            course.complete(Some(best));
        }
        assert_eq!(course.iteration, 5);
        assert_eq!(course.gain(2), 0.0);
        assert_eq!(course.gain(3), 3.0);
        assert_eq!(course.gain(99), 6.0);
        assert_eq!(course.idle(), 2);
    }

    #[test]
    fn a_chain_counts_what_it_refuses_and_how_long_it_stands_still() {
        let mut standing = Standing::default();
        for accepted in [true, false, false] {
            standing.note(accepted);
        }
        standing.complete();
        assert_eq!((standing.refused, standing.stagnant), (2, 0));
        standing.note(false);
        standing.complete();
        standing.complete();
        assert_eq!((standing.refused, standing.stagnant), (3, 2));
        standing.note(true);
        standing.complete();
        assert_eq!((standing.refused, standing.stagnant), (0, 0));
    }

    #[test]
    fn the_deviation_is_that_of_a_sample() {
        assert!(
            (deviation(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]) - libm::sqrt(32.0 / 7.0)).abs() < 1e-12
        );
        assert_eq!(deviation(&[3.0]), 0.0);
    }

    #[test]
    fn chains_change_places_where_the_colder_gains_and_else_by_chance() {
        assert!(exchange((1.0, 0.0), (2.0, 5.0), 0.999));
        assert!(exchange((2.0, 5.0), (1.0, 0.0), 0.999));
        // exp((1 - 1/2) * -2) = 0.3679
        assert!(exchange((1.0, 2.0), (2.0, 0.0), 0.36));
        assert!(!exchange((1.0, 2.0), (2.0, 0.0), 0.37));
        assert!(exchange((2.0, 0.0), (1.0, 2.0), 0.36));
        assert!(!exchange((2.0, 0.0), (1.0, 2.0), 0.37));
        assert!(!exchange((0.0, 2.0), (2.0, 0.0), 0.0));
        assert!(!exchange((1.0, f64::NEG_INFINITY), (2.0, f64::NEG_INFINITY), 0.0));
    }

    #[test]
    fn without_any_valid_value_nothing_is_gained() {
        let mut course = Course::new(Direction::Maximize, None);
        for _ in 0..150 {
            course.complete(None);
        }
        assert_eq!(course.gain(150), 0.0);
        assert_eq!(course.idle(), 150);
    }
}
