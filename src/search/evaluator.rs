//! Evaluates parameters of one body: drive, simulation, score.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{self, Expr, RuleSet, Task};
use rayon::prelude::*;

use super::Failure;
use super::cache::{self, Cache, Key, Subject};
use super::tally::Missing;
use crate::derive::Derivation;
use crate::design::Body;
use crate::drive::{Drive, Parameters};
use crate::score::{self, Recording};
use crate::simulate::{Invalid, Model, Motion, Settings, Simulation, Stop};

/// The value of an evaluation, or why it has none.
pub(super) type Valued = Result<f64, Missing>;

/// Evaluates parameters of one body, several at a time.
pub(super) struct Evaluator<'r> {
    rules: &'r RuleSet,
    task: &'r Task,
    derivation: Arc<Derivation>,
    body: Body,
    cache: &'r Cache,
    /// Names evaluations of this body, and of it at half the step.
    subjects: (Subject, Subject),
    /// The actuation of the body.
    pub(super) drive: Drive<'r>,
    pool: &'r rayon::ThreadPool,
    /// One simulation for each thread.
    workers: Vec<Box<dyn Simulation>>,
    /// The simulation at half the step.
    fine: Box<dyn Simulation>,
}

/// A model's numbers as a solver takes them.
#[must_use]
pub fn settings(model: &ir::Model) -> Settings {
    Settings {
        step: model.step,
        duration: model.duration,
        record: model.record,
        gravity: model.gravity,
        ground_friction: model.ground_friction,
        iterations: model.iterations,
        tolerance: model.tolerance,
        self_collision: model.self_collision,
        speed_limit: model.speed_limit,
    }
}

impl<'r> Evaluator<'r> {
    /// Prepares a body for all threads of a pool.
    ///
    /// # Errors
    ///
    /// [`Failure`] when the model cannot simulate it, or an expression has no value.
    pub(super) fn new(
        rules: &'r RuleSet,
        task: &'r Task,
        (model, cache): (&dyn Model, &'r Cache),
        derivation: Arc<Derivation>,
        pool: &'r rayon::ThreadPool,
    ) -> Result<Self, Failure> {
        let body = Body::new(&derivation.design, rules);
        let drive = Drive::new(rules, task, Arc::clone(&derivation), &body)?;
        let full = settings(&task.model);
        let workers = (0..pool.current_num_threads().max(1))
            .map(|_| model.prepare(&body.assembly, &full))
            .collect::<Result<Vec<_>, _>>()?;
        let fine = model.prepare(&body.assembly, &full.finer())?;
        let name = rules.tasks.iter().find(|(_, t)| std::ptr::eq(*t, task)).map_or("", |(name, _)| name);
        let subjects = (cache::subject(&derivation, name, false), cache::subject(&derivation, name, true));
        Ok(Self { rules, task, derivation, body, cache, subjects, drive, pool, workers, fine })
    }

    /// How many evaluations go on at once at most: threads, and lanes of each.
    pub(super) fn room(&self) -> (usize, usize) {
        (self.workers.len(), self.workers.iter().map(|worker| worker.lanes()).min().unwrap_or(1))
    }

    /// Evaluates several parameters at once; each as if it were alone. None if it was
    /// asked to stop before all were done.
    pub(super) fn evaluate(&mut self, stop: Stop<'_>, batch: &[Parameters]) -> Option<Vec<Valued>> {
        let keys: Vec<Key> = batch.iter().map(|one| Cache::key(&self.subjects.0, one)).collect();
        let mut values: Vec<Option<Valued>> = keys.iter().map(|key| self.cache.get(key)).collect();
        let open: Vec<usize> = (0..batch.len()).filter(|&i| values[i].is_none()).collect();
        if !open.is_empty() {
            let unknown: Vec<Parameters> = open.iter().map(|&i| batch[i].clone()).collect();
            for (i, value) in open.into_iter().zip(self.simulate(stop, &unknown)?) {
                self.cache.keep(keys[i], &value);
                values[i] = Some(value);
            }
        }
        values.into_iter().collect()
    }

    fn simulate(&mut self, stop: Stop<'_>, batch: &[Parameters]) -> Option<Vec<Valued>> {
        let Self { rules, task, derivation, body, drive, pool, workers, .. } = self;
        let one = Judging { rules, task, derivation, body, drive };
        let share = batch.len().div_ceil(workers.len()).max(1);
        if let ([worker, ..], true) = (workers.as_mut_slice(), batch.len() <= share) {
            return one.values(stop, worker.as_mut(), batch);
        }
        let parts: Option<Vec<_>> = pool.install(|| {
            workers
                .par_iter_mut()
                .zip(batch.par_chunks(share))
                .map(|(worker, part)| one.values(stop, worker.as_mut(), part))
                .collect()
        });
        Some(parts?.into_iter().flatten().collect())
    }

    /// The value at half the step; none if it was asked to stop before that was known.
    pub(super) fn at_half_step(&mut self, stop: Stop<'_>, parameters: &Parameters) -> Option<Valued> {
        let key = Cache::key(&self.subjects.1, parameters);
        if let Some(known) = self.cache.get(&key) {
            return Some(known);
        }
        let Self { rules, task, derivation, body, drive, fine, .. } = self;
        let judging = Judging { rules, task, derivation, body, drive };
        let values = judging.values(stop, fine.as_mut(), std::slice::from_ref(parameters))?;
        let value = values.into_iter().next()?;
        self.cache.keep(key, &value);
        Some(value)
    }

    /// What an archive's descriptors say of a motion, in their order; none if it was asked to stop.
    pub(super) fn describe(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        described: &[&Expr],
    ) -> Option<Result<Vec<f64>, Missing>> {
        let Self { rules, derivation, body, drive, workers, .. } = self;
        let worker = workers.first_mut()?;
        let targets = match drive.targets(parameters) {
            Ok(targets) => targets,
            Err(error) => return Some(Err(Missing::Expression(error))),
        };
        let motion = worker.run_until(stop, std::slice::from_ref(&targets))?.into_iter().next()?;
        Some(motion.map_err(Missing::Motion).and_then(|motion| {
            let recording = Recording { derivation, body, motion: &motion, drive, parameters };
            score::quantities(rules, recording, described).map_err(Missing::Expression)
        }))
    }
}

/// What turns parameters into a value, apart from the simulation.
struct Judging<'a> {
    rules: &'a RuleSet,
    task: &'a Task,
    derivation: &'a Derivation,
    body: &'a Body,
    drive: &'a Drive<'a>,
}

impl Judging<'_> {
    /// The values of parameters, simulated side by side; none if that was stopped.
    fn values(
        &self,
        stop: Stop<'_>,
        simulation: &mut dyn Simulation,
        batch: &[Parameters],
    ) -> Option<Vec<Valued>> {
        let targets: Vec<_> = batch.iter().map(|parameters| self.drive.targets(parameters)).collect();
        let drives: Vec<_> = targets.iter().flatten().cloned().collect();
        let mut motions = simulation.run_until(stop, &drives)?.into_iter();
        let mut value = |(targets, parameters): (Result<_, EvalError>, &Parameters)| {
            targets.map_err(Missing::Expression)?;
            let motion = motions.next().unwrap_or(Err(Invalid::NotFinite)).map_err(Missing::Motion)?;
            self.score(&motion, parameters).map_err(Missing::Expression)
        };
        Some(targets.into_iter().zip(batch).map(&mut value).collect())
    }

    fn score(&self, motion: &Motion, parameters: &[f64]) -> Result<f64, EvalError> {
        let Self { rules, task, derivation, body, drive } = *self;
        score::objective(rules, task, Recording { derivation, body, motion, drive, parameters })
    }
}
