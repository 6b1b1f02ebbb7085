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
use crate::simulate::{Invalid, Model, Settings, Simulation};

/// The value of an evaluation, or why it has none.
pub(super) type Valued = Result<f64, Invalid>;

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

    /// Evaluates several parameters at once; each as if it were alone.
    pub fn evaluate(&mut self, batch: &[Parameters]) -> Vec<Result<Valued, EvalError>> {
        let Self { rules, task, derivation, body, drive, pool, workers, .. } = self;
        let one = Judging { rules, task, derivation, body, drive };
        if let ([worker, ..], [single]) = (workers.as_mut_slice(), batch) {
            return vec![one.value(worker.as_mut(), single)];
        }
        let mut out = Vec::with_capacity(batch.len());
        for chunk in batch.chunks(workers.len()) {
            let part: Vec<_> = pool.install(|| {
                workers
                    .par_iter_mut()
                    .zip(chunk.par_iter())
                    .map(|(worker, parameters)| one.value(worker.as_mut(), parameters))
                    .collect()
            });
            out.extend(part);
        }
        out
    }

    /// The value at half the step.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression has no value.
    pub fn at_half_step(&mut self, parameters: &Parameters) -> Result<Valued, EvalError> {
        let Self { rules, task, derivation, body, drive, fine, .. } = self;
        Judging { rules, task, derivation, body, drive }.value(fine.as_mut(), parameters)
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
    fn value(&self, simulation: &mut dyn Simulation, parameters: &[f64]) -> Result<Valued, EvalError> {
        let Self { rules, task, derivation, body, drive } = *self;
        let targets = drive.targets(parameters)?;
        match simulation.run(std::slice::from_ref(&targets)).into_iter().next() {
            Some(Ok(motion)) => {
                let recording = Recording { derivation, body, motion: &motion, drive, parameters };
                score::objective(rules, task, recording).map(Ok)
            }
            Some(Err(invalid)) => Ok(Err(invalid)),
            None => Ok(Err(Invalid::NotFinite)),
        }
    }
}
