//! Evaluates parameters of one body: drive, simulation, score.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{self, RuleSet, Task};
use rayon::prelude::*;

use super::Failure;
use super::tally::Missing;
use crate::derive::Derivation;
use crate::design::Body;
use crate::drive::{Drive, Parameters};
use crate::score::{self, Recording};
use crate::simulate::{Invalid, Model, Motion, Settings, Simulation, Stop};

/// The value of an evaluation, or why it has none.
pub(super) type Valued = Result<f64, Missing>;

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
        let fine = model.prepare(&body.assembly, &full.finer())?;
        Ok(Self { rules, task, derivation, body, drive, pool, workers, fine })
    }

    /// How many evaluations go on at once at most: threads, and lanes of each.
    pub(super) fn room(&self) -> (usize, usize) {
        (self.workers.len(), self.workers.iter().map(|worker| worker.lanes()).min().unwrap_or(1))
    }

    /// Evaluates several parameters at once; each as if it were alone. None if it was
    /// asked to stop before all were done.
    pub(super) fn evaluate(&mut self, stop: Stop<'_>, batch: &[Parameters]) -> Option<Vec<Valued>> {
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
        let Self { rules, task, derivation, body, drive, fine, .. } = self;
        let judging = Judging { rules, task, derivation, body, drive };
        judging.values(stop, fine.as_mut(), std::slice::from_ref(parameters))?.into_iter().next()
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
