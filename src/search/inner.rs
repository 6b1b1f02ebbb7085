//! The inner loop: annealing of the curves of one body.

use std::sync::Arc;

use grammar_lang::ir::{RuleSet, Task};

use super::evaluator::{Evaluator, Valued};
use super::forecast::Forecast;
use super::schedule::{Course, Plan};
use super::tally::{Missing, Tally};
use super::{Budget, End, Failure, accepts, keeps};
use crate::derive::Derivation;
use crate::derive::random::Stream;
use crate::drive::Parameters;
use crate::simulate::Model;

/// The best drive of a body.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) parameters: Parameters,
    pub(super) value: f64,
    /// The value at half the step; none where the value needed no check.
    pub(super) half_step: Option<f64>,
}

/// What the inner loop did.
#[derive(Clone, Debug, Default)]
pub(super) struct Tuned {
    pub(super) found: Option<Found>,
    /// Evaluations that came to nothing.
    pub(super) tally: Tally,
    /// Why it was cut short, if it was.
    pub(super) cut: Option<End>,
}

/// The inner loop of one body.
pub(super) struct Tuning<'a, 'b> {
    rules: &'a RuleSet,
    task: &'a Task,
    derivation: &'a Derivation,
    evaluator: Evaluator<'a>,
    seed: u64,
    name: &'a str,
    budget: &'a mut Budget<'b>,
    tuned: Tuned,
    notify: &'a mut dyn FnMut(u64, Option<f64>, f64),
}

/// Finds the best curves of a body for a task; `name` names its streams of random numbers.
pub(super) fn tune(
    (rules, task): (&RuleSet, &Task),
    model: &dyn Model,
    pool: &rayon::ThreadPool,
    derivation: &Arc<Derivation>,
    name: &str,
    budget: &mut Budget<'_>,
    notify: &mut dyn FnMut(u64, Option<f64>, f64),
) -> Result<Tuned, Failure> {
    let seed = budget.limits.seed;
    let evaluator = Evaluator::new(rules, task, model, Arc::clone(derivation), pool)?;
    let tuning =
        Tuning { rules, task, derivation, evaluator, seed, name, budget, tuned: Tuned::default(), notify };
    tuning.run()
}

impl Tuning<'_, '_> {
    fn stream(&self, what: &str) -> Stream {
        Stream::named(self.seed, &format!("{}/{what}", self.name))
    }

    /// The value on a scale where more is better.
    fn fitness(&self, value: f64) -> f64 {
        if self.task.objective.maximize { value } else { -value }
    }

    fn run(mut self) -> Result<Tuned, Failure> {
        let first = self.evaluator.drive.draw(&mut self.stream("start"));
        let mut fitness = f64::NEG_INFINITY;
        for value in self.evaluator.evaluate(std::slice::from_ref(&first)) {
            let known = value.as_ref().ok().copied();
            if self.count(&first, value)?
                && let Some(value) = known
            {
                fitness = self.fitness(value);
            }
        }
        let schedule = match &self.rules.search.inner {
            Some(schedule) if !self.evaluator.drive.is_fixed() => schedule,
            _ => return Ok(self.tuned),
        };
        let plan = Plan { rules: self.rules, derivation: self.derivation, schedule };
        let mut course = Course::new(self.task.objective.maximize, self.best());
        let mut current = first;
        let mut number = 0u64;
        let mut forecast = Forecast::new(&self.evaluator);
        while course.iteration < plan.iterations(&course)? {
            let temperature = plan.temperature(&course)?;
            let moves = plan.moves(&course)?;
            let mut made = 0;
            while made < moves {
                if let Some(end) = self.budget.exhausted() {
                    self.tuned.cut = Some(end);
                    return Ok(self.tuned);
                }
                let guesses = forecast.ahead(moves - made);
                let mut draws = Vec::with_capacity(guesses.len());
                let mut candidates: Vec<Parameters> = Vec::with_capacity(guesses.len());
                for guess in &guesses {
                    let mut random = self.stream(&format!("{}", number + guess.depth as u64));
                    draws.push(random.unit());
                    let from = guess.from.map_or(&current, |from| &candidates[from]);
                    let iteration = course.iteration;
                    candidates.push(self.evaluator.drive.mutate(
                        from,
                        temperature,
                        iteration,
                        &mut random,
                    )?);
                }
                let values = self.evaluator.evaluate(&candidates);
                let mut next = Some(0);
                while let Some(now) = next {
                    if self.budget.exhausted().is_some() {
                        break;
                    }
                    made += 1;
                    number += 1;
                    let (candidate, value) = (&candidates[now], values[now].clone());
                    let new = value.as_ref().map_or(f64::NEG_INFINITY, |v| self.fitness(*v));
                    let sound = self.count(candidate, value)?;
                    let accepted = sound && accepts(fitness, new, temperature, draws[now]);
                    forecast.learn(accepted);
                    if accepted {
                        (current, fitness) = (candidate.clone(), new);
                    }
                    next = if accepted { guesses[now].accepted } else { guesses[now].refused };
                }
                let best = self.best();
                (self.notify)(self.budget.spent, best, temperature);
            }
            course.complete(self.best());
            if plan.stops(&course)? {
                break;
            }
        }
        Ok(self.tuned)
    }

    fn best(&self) -> Option<f64> {
        self.tuned.found.as_ref().map(|f| f.value)
    }

    /// Counts an evaluation and keeps it if it is the best. A best must hold its
    /// value at half the step; what does not is no candidate at all, or the
    /// search would go and live on an error of the simulation.
    fn count(&mut self, candidate: &Parameters, value: Valued) -> Result<bool, Failure> {
        self.budget.spent += 1;
        let value = match value {
            Ok(value) => value,
            // What fails at the very first is a mistake in the grammar.
            Err(Missing::Expression(error)) if self.budget.spent == 1 => return Err(error.into()),
            Err(reason) => {
                self.tuned.tally.count(reason);
                return Ok(false);
            }
        };
        let fitness = self.fitness(value);
        if self.tuned.found.as_ref().is_some_and(|f| fitness <= self.fitness(f.value)) {
            return Ok(true);
        }
        let mut half_step = None;
        // Where more is better, a value that is not positive has nothing to lose.
        if self.is_actuated() && (fitness > 0.0 || !self.task.objective.maximize) {
            self.budget.spent += 1;
            let half = self.evaluator.at_half_step(candidate).ok();
            if !half.is_some_and(|half| keeps(self.rules, self.task, value, half)) {
                self.tuned.tally.unstable += 1;
                return Ok(false);
            }
            half_step = half;
        }
        self.tuned.found = Some(Found { parameters: candidate.clone(), value, half_step });
        Ok(true)
    }

    /// Whether anything in the body moves by itself.
    fn is_actuated(&self) -> bool {
        let rules = self.rules;
        self.derivation.design.parts.values().any(|p| rules.is_actuator(&p.kind))
    }
}
