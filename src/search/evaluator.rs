//! Evaluates parameters of one body: drive, simulation, score.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{self, RuleSet, Task};
use rayon::prelude::*;

use super::Failure;
use crate::derive::Derivation;
use crate::design::Body;
use crate::drive::{Drive, Parameters};
use crate::score::{self, Recording};
use crate::simulate::{Invalid, Model, Motion, Settings, Simulation, Stop};

/// The value of an evaluation, or why it has none.
pub(super) type Valued = Result<f64, Invalid>;

/// The values of several; none if they were stopped.
pub(super) type Values = Option<Vec<Result<Valued, EvalError>>>;

/// Evaluates parameters of one body, several at a time.
pub struct Evaluator<'r> {
    rules: &'r RuleSet,
    task: &'r Task,
    derivation: Arc<Derivation>,
    body: Body,
    /// The actuation of the body.
    pub drive: Drive<'r>,
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
    pub fn new(
        rules: &'r RuleSet,
        task: &'r Task,
        model: &dyn Model,
        derivation: Arc<Derivation>,
        pool: &'r rayon::ThreadPool,
    ) -> Result<Self, Failure> {
        let body = Body::new(&derivation.design, rules);
        let drive = Drive::new(rules, task, Arc::clone(&derivation), &body)?;
        let full = settings(&task.model);
        let workers = (0..pool.current_num_threads().max(1))
            .map(|_| model.prepare(&body.assembly, &full))
            .collect::<Result<Vec<_>, _>>()?;
        let fine = model.prepare(&body.assembly, &Settings { step: full.step / 2.0, ..full })?;
        Ok(Self { rules, task, derivation, body, drive, pool, workers, fine })
    }

    /// How many evaluations go on at once at most: threads, and lanes of each.
    pub(super) fn room(&self) -> (usize, usize) {
        (self.workers.len(), self.workers.iter().map(|worker| worker.lanes()).min().unwrap_or(1))
    }

    /// Evaluates several parameters at once; each as if it were alone. None if it was
    /// asked to stop before all were done.
    pub(super) fn evaluate(&mut self, stop: Stop<'_>, batch: &[Parameters]) -> Values {
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
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression has no value.
    pub(super) fn at_half_step(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
    ) -> Result<Option<Valued>, EvalError> {
        let Self { rules, task, derivation, body, drive, fine, .. } = self;
        let judging = Judging { rules, task, derivation, body, drive };
        let values = judging.values(stop, fine.as_mut(), std::slice::from_ref(parameters));
        values.and_then(|values| values.into_iter().next()).transpose()
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
    /// The values of parameters, simulated side by side.
    fn values(&self, stop: Stop<'_>, simulation: &mut dyn Simulation, batch: &[Parameters]) -> Values {
        let targets: Vec<_> = batch.iter().map(|parameters| self.drive.targets(parameters)).collect();
        let drives: Vec<_> = targets.iter().flatten().cloned().collect();
        let mut motions = simulation.run_until(stop, &drives)?.into_iter();
        let mut value = |(targets, parameters): (Result<_, EvalError>, &Parameters)| {
            targets?;
            match motions.next().unwrap_or(Err(Invalid::NotFinite)) {
                Ok(motion) => self.score(&motion, parameters).map(Ok),
                Err(invalid) => Ok(Err(invalid)),
            }
        };
        Some(targets.into_iter().zip(batch).map(&mut value).collect())
    }

    fn score(&self, motion: &Motion, parameters: &[f64]) -> Result<f64, EvalError> {
        let Self { rules, task, derivation, body, drive } = *self;
        score::objective(rules, task, Recording { derivation, body, motion, drive, parameters })
    }
}
