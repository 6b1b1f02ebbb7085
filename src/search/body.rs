//! One body, tuned for each task in turn. What was found counts only if every task has a value.

use std::sync::Arc;

use grammar_lang::ir::RuleSet;

use super::inner::{Pace, Tuner};
use super::state::{Body, Tune};
use super::{Bounds, Failure};
use crate::derive::Derivation;
use crate::simulate::Model;

/// The inner loops of one body. What they know is in a [`Body`].
pub(super) struct Tasks<'a> {
    pub(super) rules: &'a RuleSet,
    pub(super) model: &'a dyn Model,
    pub(super) pool: &'a rayon::ThreadPool,
    pub(super) derivation: Arc<Derivation>,
    pub(super) seed: u64,
    /// Names their streams of random numbers, together with the name of the task.
    pub(super) name: String,
    pub(super) bounds: Bounds<'a>,
    /// The loop of the task at hand, once it is needed.
    pub(super) tuner: Option<Tuner<'a>>,
}

impl Tasks<'_> {
    /// Goes on by a batch of evaluations.
    pub(super) fn advance(&mut self, body: &mut Body, spent: &mut u64) -> Result<Pace, Failure> {
        let Some((name, task)) = self.rules.tasks.get_index(body.done) else { return Ok(Pace::Done) };
        let tuner = match &mut self.tuner {
            Some(tuner) => tuner,
            none => {
                let stream = if *name == RuleSet::ONLY_TASK {
                    self.name.clone()
                } else {
                    format!("{} {name}", self.name)
                };
                none.insert(Tuner::new(
                    (self.rules, task),
                    self.model,
                    self.pool,
                    &self.derivation,
                    (self.seed, stream),
                    self.bounds,
                )?)
            }
        };
        let pace = tuner.advance(&mut body.tuning, spent)?;
        if pace != Pace::Done {
            return Ok(pace);
        }
        self.tuner = None;
        body.close();
        Ok(if body.done < self.rules.tasks.len() { Pace::More } else { Pace::Done })
    }
}

impl Body {
    /// Ends the task at hand with what was found for it.
    pub(super) fn close(&mut self) {
        let tuning = std::mem::take(&mut self.tuning);
        self.done += 1;
        self.tally.add(&tuning.tally);
        self.tunes.extend(tuning.found);
    }

    /// The temperature of the curves, and the best value of the task at hand.
    pub(super) fn progress(&self) -> (f64, Option<f64>) {
        let iteration = self.tuning.chain.as_ref().and_then(|chain| chain.iteration);
        let value = self.tuning.found.as_ref().map(|found| found.value);
        (iteration.map_or(0.0, |iteration| iteration.temperature), value)
    }

    /// What was found, and the value of all tasks together.
    pub(super) fn found(
        self,
        rules: &RuleSet,
        derivation: &Derivation,
    ) -> Result<Option<(Vec<Tune>, f64)>, Failure> {
        if self.tunes.len() != rules.tasks.len() {
            return Ok(None);
        }
        let values: Vec<(&str, f64)> =
            rules.tasks.keys().map(String::as_str).zip(self.tunes.iter().map(|t| t.value)).collect();
        let value = crate::score::outcome(rules, derivation, &values)?;
        Ok(Some((self.tunes, value)))
    }
}
