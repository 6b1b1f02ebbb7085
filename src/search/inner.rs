//! The inner loop: annealing of the curves of one body.

use std::sync::Arc;

use grammar_lang::ir::{RuleSet, Schedule, Task};

use super::evaluator::{Evaluator, Valued};
use super::forecast::Forecast;
use super::schedule::{Course, Plan};
use super::state::{Chain, Tune, Tuning};
use super::tally::Missing;
use super::{Bounds, End, Failure, accepts, keeps};
use crate::derive::Derivation;
use crate::derive::random::Stream;
use crate::drive::Parameters;
use crate::simulate::Model;

/// How a loop stands after a batch of evaluations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pace {
    /// There is more to do.
    More,
    /// It is complete.
    Done,
    /// It is cut short.
    Cut(End),
}

/// The inner loop of one body for one task. What it knows is in a [`Tuning`]; here is only
/// what can be made again.
pub(super) struct Tuner<'a> {
    rules: &'a RuleSet,
    task: &'a Task,
    derivation: Arc<Derivation>,
    evaluator: Evaluator<'a>,
    forecast: Forecast,
    seed: u64,
    /// Names its streams of random numbers.
    name: String,
    bounds: Bounds<'a>,
}

impl<'a> Tuner<'a> {
    pub(super) fn new(
        (rules, task): (&'a RuleSet, &'a Task),
        model: &dyn Model,
        pool: &'a rayon::ThreadPool,
        derivation: &Arc<Derivation>,
        (seed, name): (u64, String),
        bounds: Bounds<'a>,
    ) -> Result<Self, Failure> {
        let evaluator = Evaluator::new(rules, task, model, Arc::clone(derivation), pool)?;
        let forecast = Forecast::new(&evaluator);
        Ok(Self { rules, task, derivation: Arc::clone(derivation), evaluator, forecast, seed, name, bounds })
    }

    fn stream(&self, what: &str) -> Stream {
        Stream::named(self.seed, &format!("{}/{what}", self.name))
    }

    /// The value on a scale where more is better.
    fn fitness(&self, value: f64) -> f64 {
        if self.task.objective.maximize { value } else { -value }
    }

    /// The schedule, where there is something to tune.
    fn schedule(&self) -> Option<&'a Schedule> {
        self.rules.search.inner.as_ref().filter(|_| !self.evaluator.drive.is_fixed())
    }

    /// Goes on by a batch of evaluations. Moves are made whole or not at all, so that the state is
    /// sound whenever this returns.
    pub(super) fn advance(&mut self, tuning: &mut Tuning, spent: &mut u64) -> Result<Pace, Failure> {
        let Some(mut chain) = tuning.chain.take() else { return self.begin(tuning, spent) };
        let pace = self.go_on(tuning, &mut chain, spent);
        tuning.chain = Some(chain);
        pace
    }

    /// Evaluates the curves that the chain starts from.
    fn begin(&mut self, tuning: &mut Tuning, spent: &mut u64) -> Result<Pace, Failure> {
        let first = self.evaluator.drive.draw(&mut self.stream("start"));
        let values = self.evaluator.evaluate(self.bounds.stop, std::slice::from_ref(&first));
        let Some(value) = values.and_then(|values| values.into_iter().next()) else { return self.stopped() };
        let known = value.as_ref().ok().map(|value| self.fitness(*value));
        let Some(sound) = self.count(tuning, &first, value, spent)? else { return self.stopped() };
        let fitness = known.filter(|_| sound);
        let course = Course::new(self.task.objective.maximize, best(tuning));
        tuning.chain = Some(Chain { current: first, fitness, course, iteration: None, number: 0 });
        Ok(if self.schedule().is_some() { Pace::More } else { Pace::Done })
    }

    fn go_on(&mut self, tuning: &mut Tuning, chain: &mut Chain, spent: &mut u64) -> Result<Pace, Failure> {
        let Some(schedule) = self.schedule() else { return Ok(Pace::Done) };
        let derivation = Arc::clone(&self.derivation);
        let plan = Plan { rules: self.rules, derivation: &derivation, schedule };
        let Some(iteration) = (match chain.iteration {
            Some(iteration) => Some(iteration),
            None => plan.begin(&chain.course)?,
        }) else {
            return Ok(Pace::Done);
        };
        chain.iteration = Some(iteration);
        if iteration.made < iteration.moves {
            if let Some(end) = self.bounds.exhausted(*spent) {
                return Ok(Pace::Cut(end));
            }
            if !self.moves(tuning, chain, spent)? {
                return self.stopped();
            }
        }
        if chain.iteration.is_some_and(|iteration| iteration.made >= iteration.moves) {
            chain.iteration = None;
            chain.course.complete(best(tuning));
            if plan.stops(&chain.course)? {
                return Ok(Pace::Done);
            }
        }
        Ok(Pace::More)
    }

    /// Makes moves as far as a batch of evaluations reaches; whether it was not stopped.
    fn moves(&mut self, tuning: &mut Tuning, chain: &mut Chain, spent: &mut u64) -> Result<bool, Failure> {
        let Some(iteration) = chain.iteration.as_mut() else { return Ok(true) };
        let guesses = self.forecast.ahead(iteration.moves - iteration.made);
        let mut draws = Vec::with_capacity(guesses.len());
        let mut candidates: Vec<Parameters> = Vec::with_capacity(guesses.len());
        for guess in &guesses {
            let mut random = self.stream(&format!("{}", chain.number + guess.depth as u64));
            draws.push(random.unit());
            let from = guess.from.map_or(&chain.current, |from| &candidates[from]);
            let number = chain.course.iteration;
            match self.evaluator.drive.mutate(from, iteration.temperature, number, &mut random) {
                Ok(candidate) => candidates.push(candidate),
                // Of a later move it is not known that it comes to pass.
                Err(_) if !candidates.is_empty() => break,
                Err(error) => return Err(error.into()),
            }
        }
        let Some(values) = self.evaluator.evaluate(self.bounds.stop, &candidates) else { return Ok(false) };
        let mut next = Some(0);
        while let Some(now) = next {
            if self.bounds.exhausted(*spent).is_some() {
                break;
            }
            let (candidate, value) = (&candidates[now], values[now].clone());
            let new = value.as_ref().map_or(f64::NEG_INFINITY, |v| self.fitness(*v));
            let Some(sound) = self.count(tuning, candidate, value, spent)? else { return Ok(false) };
            iteration.made += 1;
            chain.number += 1;
            let fitness = chain.fitness.unwrap_or(f64::NEG_INFINITY);
            let accepted = sound && accepts(fitness, new, iteration.temperature, draws[now]);
            self.forecast.learn(accepted);
            if accepted {
                (chain.current, chain.fitness) = (candidate.clone(), Some(new));
            }
            next = if accepted { guesses[now].accepted } else { guesses[now].refused };
            next = next.filter(|&next| next < candidates.len());
        }
        Ok(true)
    }

    fn stopped(&self) -> Result<Pace, Failure> {
        Ok(Pace::Cut(self.bounds.stopped().unwrap_or(End::Interrupted)))
    }

    /// Counts an evaluation and keeps it if it is the best. A best must hold its
    /// value at half the step; what does not is no candidate at all, or the
    /// search would go and live on an error of the simulation. None if that was stopped: then
    /// nothing is counted.
    fn count(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        value: Valued,
        spent: &mut u64,
    ) -> Result<Option<bool>, Failure> {
        let value = match value {
            Ok(value) => value,
            // What fails at the very first is a mistake in the grammar.
            Err(Missing::Expression(error)) if *spent == 0 => return Err(error.into()),
            Err(reason) => {
                *spent += 1;
                tuning.tally.count(reason);
                return Ok(Some(false));
            }
        };
        let fitness = self.fitness(value);
        if tuning.found.as_ref().is_some_and(|f| fitness <= self.fitness(f.value)) {
            *spent += 1;
            return Ok(Some(true));
        }
        let mut half_step = None;
        // Where more is better, a value that is not positive has nothing to lose.
        if self.is_actuated() && (fitness > 0.0 || !self.task.objective.maximize) {
            let Some(half) = self.evaluator.at_half_step(self.bounds.stop, candidate) else {
                return Ok(None);
            };
            *spent += 1;
            half_step = half.ok().filter(|&half| keeps(self.rules, self.task, value, half));
            if half_step.is_none() {
                *spent += 1;
                tuning.tally.unstable += 1;
                return Ok(Some(false));
            }
        }
        *spent += 1;
        tuning.found = Some(Tune { parameters: candidate.clone(), value, half_step });
        Ok(Some(true))
    }

    /// Whether anything in the body moves by itself.
    fn is_actuated(&self) -> bool {
        let rules = self.rules;
        self.derivation.design.parts.values().any(|p| rules.is_actuator(&p.kind))
    }
}

fn best(tuning: &Tuning) -> Option<f64> {
    tuning.found.as_ref().map(|f| f.value)
}
