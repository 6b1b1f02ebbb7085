//! The outer loop: annealing of bodies by rule applications.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::RuleSet;

use super::inner::{Tuned, tune};
use super::schedule::{Course, Plan};
use super::tally::{Missing, Tally};
use super::{Budget, End, Failure, Limits, MOST_IDLE_MOVES, accepts};
use crate::derive::random::Stream;
use crate::derive::{Blocked, Derivation};
use crate::drive::Parameters;
use crate::simulate::Model;

/// The best design so far.
#[derive(Clone, Debug)]
pub struct Best {
    /// The design and how it came to be.
    pub derivation: Arc<Derivation>,
    /// What was found for each task, in their order.
    pub tasks: Vec<Tune>,
    /// Its value, as the grammar states the objective.
    pub value: f64,
    /// The outer move that found it; 0 is the initial design.
    pub found_at: usize,
}

/// The best drive of a body for one task.
#[derive(Clone, Debug)]
pub struct Tune {
    /// The values of its varied quantities.
    pub parameters: Parameters,
    /// Its value, as the task states its objective.
    pub value: f64,
    /// Its value at half the step, where that was checked.
    pub half_step: Option<f64>,
}

/// The outcome of tuning a body for all tasks.
#[derive(Default)]
struct Body {
    found: Option<(Vec<Tune>, f64)>,
    tally: Tally,
    cut: Option<End>,
}

impl Body {
    fn value(&self) -> Option<f64> {
        self.found.as_ref().map(|(_, value)| *value)
    }
}

/// One outer move, for the record.
#[derive(Clone, Debug)]
pub struct Row {
    /// The number of the move, from 1; 0 is the initial design.
    pub number: usize,
    /// The iteration it belongs to.
    pub iteration: usize,
    /// The rule that was applied; none if nothing could be.
    pub rule: Option<String>,
    /// Rules that were drawn but blocked, and by what.
    pub blocked: Vec<(String, String)>,
    /// How many parts and actuators the design has.
    pub size: (usize, usize),
    /// The value of the design; none if no evaluation was valid.
    pub value: Option<f64>,
    /// Whether it became the current design.
    pub accepted: bool,
    /// The best value so far.
    pub best: Option<f64>,
    /// The temperature.
    pub temperature: f64,
    /// All evaluations spent so far.
    pub evaluations: u64,
    /// Evaluations of this move that came to nothing.
    pub tally: Tally,
}

/// Follows a search.
pub trait Observer {
    /// Called often: evaluations spent, the best value of the current body, the temperature of its curves.
    fn evaluated(&mut self, spent: u64, body: Option<f64>, temperature: f64);
    /// Called after each outer move.
    ///
    /// # Errors
    ///
    /// A sentence; the search ends with it.
    fn moved(&mut self, row: &Row) -> Result<(), String>;
    /// Called for each new best design.
    ///
    /// # Errors
    ///
    /// A sentence; the search ends with it.
    fn improved(&mut self, best: &Best) -> Result<(), String>;
}

/// What a search found.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best design; none if no evaluation was valid.
    pub best: Option<Best>,
    /// Evaluations spent.
    pub evaluations: u64,
    /// Outer moves made.
    pub moves: usize,
    /// Bodies evaluated.
    pub bodies: usize,
    /// Evaluations that came to nothing.
    pub tally: Tally,
    /// Why it ended.
    pub end: End,
}

/// The state of the outer loop.
struct Annealing<'a> {
    rules: &'a RuleSet,
    model: &'a dyn Model,
    pool: &'a rayon::ThreadPool,
    seed: u64,
    budget: Budget<'a>,
    observer: &'a mut dyn Observer,
    best: Option<Best>,
    moves: usize,
    bodies: usize,
    tally: Tally,
    /// Moves in a row that could do nothing.
    idle_moves: usize,
}

/// Runs the search that a rule set asks for, from a first design. `stop` may be set from
/// outside to end it soon.
///
/// # Errors
///
/// A [`Failure`]; what the observer was told before stays true.
pub fn run(
    rules: &RuleSet,
    first: Derivation,
    model: &dyn Model,
    limits: &Limits,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, Failure> {
    let pool = threads(limits)?;
    let budget = Budget { limits, stop, spent: 0 };
    let mut annealing = Annealing {
        rules,
        model,
        pool: &pool,
        seed: limits.seed,
        budget,
        observer,
        best: None,
        moves: 0,
        bodies: 0,
        tally: Tally::default(),
        idle_moves: 0,
    };
    let end = annealing.anneal(Arc::new(first))?;
    Ok(Outcome {
        best: annealing.best,
        evaluations: annealing.budget.spent,
        moves: annealing.moves,
        bodies: annealing.bodies,
        tally: annealing.tally,
        end,
    })
}

/// Tunes the curves of one body, as the search does for each body.
///
/// # Errors
///
/// A [`Failure`].
pub fn tune_body(
    rules: &RuleSet,
    model: &dyn Model,
    derivation: &Arc<Derivation>,
    limits: &Limits,
    stop: &AtomicBool,
) -> Result<Outcome, Failure> {
    let pool = threads(limits)?;
    let mut budget = Budget { limits, stop, spent: 0 };
    let body = tune_all(rules, model, &pool, derivation, "body", &mut budget, &mut |_, _, _| {})?;
    let best = body.found.map(|(tasks, value)| Best {
        derivation: Arc::clone(derivation),
        tasks,
        value,
        found_at: 0,
    });
    Ok(Outcome {
        best,
        evaluations: budget.spent,
        moves: 0,
        bodies: 1,
        tally: body.tally,
        end: body.cut.unwrap_or(End::Stopped),
    })
}

/// Tunes a body for each task in turn. What was found counts only if every task has a value.
fn tune_all(
    rules: &RuleSet,
    model: &dyn Model,
    pool: &rayon::ThreadPool,
    derivation: &Arc<Derivation>,
    name: &str,
    budget: &mut Budget<'_>,
    notify: &mut dyn FnMut(u64, Option<f64>, f64),
) -> Result<Body, Failure> {
    let mut body = Body::default();
    let mut tunes = Vec::new();
    for (task_name, task) in &rules.tasks {
        let stream =
            if *task_name == RuleSet::ONLY_TASK { name.to_owned() } else { format!("{name} {task_name}") };
        let tuned = tune((rules, task), model, pool, derivation, &stream, budget, notify);
        let Tuned { found, tally, cut } = match tuned {
            // What the actuation cannot say of this body it may say of others.
            Err(Failure::Expression(error)) if budget.spent > 1 => without_value(error, budget),
            tuned => tuned?,
        };
        body.tally.add(&tally);
        body.cut = cut;
        tunes.extend(found.map(|f| Tune {
            parameters: f.parameters,
            value: f.value,
            half_step: f.half_step,
        }));
        if body.cut.is_some() {
            break;
        }
    }
    if tunes.len() == rules.tasks.len() {
        let values: Vec<(&str, f64)> =
            rules.tasks.keys().map(String::as_str).zip(tunes.iter().map(|t| t.value)).collect();
        match crate::score::outcome(rules, derivation, &values) {
            Ok(value) => body.found = Some((tunes, value)),
            Err(error) => body.tally.count(Missing::Expression(error)),
        }
    }
    Ok(body)
}

/// What tuning a body gives that an expression has no value for. It counts as an evaluation, or a
/// search among such bodies would not end.
fn without_value(error: EvalError, budget: &mut Budget<'_>) -> Tuned {
    budget.spent += 1;
    let mut tuned = Tuned::default();
    tuned.tally.count(Missing::Expression(error));
    tuned
}

fn threads(limits: &Limits) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(limits.jobs.max(1))
        .build()
        .map_err(|e| Failure::Threads(format!("cannot start {} threads: {e}", limits.jobs)))
}

impl Annealing<'_> {
    /// The value on a scale where more is better; worst where there is none.
    fn fitness(&self, value: Option<f64>) -> f64 {
        match value {
            Some(value) if self.rules.objective.maximize => value,
            Some(value) => -value,
            None => f64::NEG_INFINITY,
        }
    }

    fn anneal(&mut self, first: Arc<Derivation>) -> Result<End, Failure> {
        let mut current = first;
        let tuned = self.tune(&current)?;
        let mut value = tuned.value();
        self.record(&current, &tuned, None, Vec::new(), 0, 0.0, true)?;
        // What has no value for the very first design is a mistake in the grammar.
        if let (None, Some((error, _))) = (value, tuned.tally.no_value.first_key_value()) {
            return Err(error.clone().into());
        }
        if let Some(end) = tuned.cut {
            return Ok(end);
        }
        let rules = self.rules;
        let mut course = Course::new(rules.objective.maximize, value);
        loop {
            let plan_for = Arc::clone(&current);
            let plan = Plan { rules, derivation: &plan_for, schedule: &rules.search.outer };
            if course.iteration >= plan.iterations(&course)? {
                return Ok(End::Schedule);
            }
            let temperature = plan.temperature(&course)?;
            for _ in 0..plan.moves(&course)? {
                if let Some(end) = self.budget.exhausted() {
                    return Ok(end);
                }
                self.moves += 1;
                let mut random = Stream::named(self.seed, &format!("body {}", self.moves));
                let drawn = random.unit();
                let step = current.advance(rules, &mut random, temperature);
                for (_, why) in &step.blocked {
                    if let Blocked::NoValue(error) = why {
                        *self.tally.refused.entry(error.clone()).or_default() += 1;
                    }
                }
                let blocked = step
                    .blocked
                    .iter()
                    .map(|(rule, why)| {
                        (rules.rules.get(*rule).map_or(String::new(), |r| r.name.clone()), why.text(rules))
                    })
                    .collect();
                let Some(next) = step.result else {
                    // A move that can do nothing is counted and told.
                    self.record(
                        &current,
                        &Body::default(),
                        None,
                        blocked,
                        course.iteration,
                        temperature,
                        false,
                    )?;
                    self.idle_moves += 1;
                    if self.idle_moves >= MOST_IDLE_MOVES {
                        return Ok(End::Stuck);
                    }
                    continue;
                };
                self.idle_moves = 0;
                let rule = step.rule.and_then(|i| rules.rules.get(i)).map(|r| r.name.clone());
                let next = Arc::new(next);
                let tuned = self.tune(&next)?;
                let new = tuned.value();
                // A body whose curves were not tuned to the end is judged by nothing but its best.
                let accepted = tuned.cut.is_none()
                    && accepts(self.fitness(value), self.fitness(new), temperature, drawn);
                self.record(&next, &tuned, rule, blocked, course.iteration, temperature, accepted)?;
                if let Some(end) = tuned.cut {
                    return Ok(end);
                }
                if accepted {
                    (current, value) = (next, new);
                }
            }
            course.complete(self.best.as_ref().map(|b| b.value));
            let plan = Plan { rules, derivation: &current, schedule: &rules.search.outer };
            if plan.stops(&course)? {
                return Ok(End::Stopped);
            }
        }
    }

    fn tune(&mut self, derivation: &Arc<Derivation>) -> Result<Body, Failure> {
        let observer = &mut *self.observer;
        self.bodies += 1;
        let name = format!("curves {}", self.moves);
        tune_all(
            self.rules,
            self.model,
            self.pool,
            derivation,
            &name,
            &mut self.budget,
            &mut |spent, best, temperature| {
                observer.evaluated(spent, best, temperature);
            },
        )
    }

    /// Keeps the best and tells the observer.
    #[allow(clippy::too_many_arguments)]
    fn record(
        &mut self,
        derivation: &Arc<Derivation>,
        tuned: &Body,
        rule: Option<String>,
        blocked: Vec<(String, String)>,
        iteration: usize,
        temperature: f64,
        accepted: bool,
    ) -> Result<(), Failure> {
        self.tally.add(&tuned.tally);
        if let Some((tasks, value)) = &tuned.found {
            let better =
                self.best.as_ref().is_none_or(|b| self.fitness(Some(*value)) > self.fitness(Some(b.value)));
            if better {
                let best = Best {
                    derivation: Arc::clone(derivation),
                    tasks: tasks.clone(),
                    value: *value,
                    found_at: self.moves,
                };
                self.observer.improved(&best).map_err(Failure::Output)?;
                self.best = Some(best);
            }
        }
        let rules = self.rules;
        let parts = derivation.design.parts.len();
        let actuators = derivation.design.parts.values().filter(|p| rules.is_actuator(&p.kind)).count();
        let row = Row {
            number: self.moves,
            iteration,
            rule,
            blocked,
            size: (parts, actuators),
            value: tuned.value(),
            accepted,
            best: self.best.as_ref().map(|b| b.value),
            temperature,
            evaluations: self.budget.spent,
            tally: tuned.tally.clone(),
        };
        self.observer.moved(&row).map_err(Failure::Output)
    }
}
