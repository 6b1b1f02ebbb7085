//! Evaluates parameters of one body: drive, simulation, score.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::RuleSet;
use rayon::prelude::*;

use crate::derive::Derivation;
use crate::design::Body;
use crate::drive::{Drive, Parameters};
use crate::score;
use crate::simulate::{Invalid, Model, Settings, Simulation, Unfit};

/// The value of an evaluation, or why it has none.
pub(super) type Valued = Result<f64, Invalid>;

/// Evaluates parameters of one body, several at a time.
pub struct Evaluator<'r> {
    rules: &'r RuleSet,
    derivation: Arc<Derivation>,
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
pub fn settings(rules: &RuleSet) -> Settings {
    let model = &rules.model;
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
    /// [`Unfit`] when the model cannot simulate it.
    pub fn new(
        rules: &'r RuleSet,
        model: &dyn Model,
        derivation: Arc<Derivation>,
        pool: &'r rayon::ThreadPool,
    ) -> Result<Self, Unfit> {
        let body = Body::new(&derivation.design, rules);
        let drive = Drive::new(rules, Arc::clone(&derivation), &body);
        let full = settings(rules);
        let workers = (0..pool.current_num_threads().max(1))
            .map(|_| model.prepare(&body.assembly, &full))
            .collect::<Result<Vec<_>, _>>()?;
        let fine = model.prepare(&body.assembly, &Settings { step: full.step / 2.0, ..full })?;
        Ok(Self { rules, derivation, drive, pool, workers, fine })
    }

    /// Evaluates several parameters at once; each as if it were alone.
    pub fn evaluate(&mut self, batch: &[Parameters]) -> Vec<Result<Valued, EvalError>> {
        let Self { rules, derivation, drive, pool, workers, .. } = self;
        if let ([worker, ..], [single]) = (workers.as_mut_slice(), batch) {
            return vec![one(rules, derivation, drive, worker.as_mut(), single)];
        }
        let mut out = Vec::with_capacity(batch.len());
        for chunk in batch.chunks(workers.len()) {
            let part: Vec<_> = pool.install(|| {
                workers
                    .par_iter_mut()
                    .zip(chunk.par_iter())
                    .map(|(worker, parameters)| one(rules, derivation, drive, worker.as_mut(), parameters))
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
        one(self.rules, &self.derivation, &self.drive, self.fine.as_mut(), parameters)
    }
}

fn one(
    rules: &RuleSet,
    derivation: &Derivation,
    drive: &Drive<'_>,
    simulation: &mut dyn Simulation,
    parameters: &Parameters,
) -> Result<Valued, EvalError> {
    let targets = drive.targets(parameters)?;
    match simulation.run(std::slice::from_ref(&targets)).into_iter().next() {
        Some(Ok(motion)) => score::objective(rules, derivation, &motion).map(Ok),
        Some(Err(invalid)) => Ok(Err(invalid)),
        None => Ok(Err(Invalid::NotFinite)),
    }
}
