//! Motions in which something else decides in the place of a policy's network, and learns what it gains.

use std::fmt::Debug;
use std::sync::{Mutex, PoisonError};

use grammar_lang::eval::{EvalError, Reference, Scope, Value, evaluate};
use grammar_lang::ir::{Attribute, Track, Word};

use super::Drive;
use super::conditions::Conditions;
use super::feedback::{FeltScope, Reaction, Running};
use crate::simulate::{Case, ControlLoop, Controller, Invalid, Measured, Snapshot, Targets, World};

/// What decides in the place of a policy's network.
pub trait Explorer: Debug + Send {
    /// What it gained since it decided last.
    fn gain(&mut self, reward: f64);

    /// What is taken as the outputs of the network for a side of the robot, by what the policy knows.
    fn decide(&mut self, side: usize, known: &[f64]) -> Vec<f64>;
}

/// What drives a body whose policy is explored.
#[derive(Debug)]
pub struct Exploration<'e, 'r> {
    targets: Targets,
    reaction: Reaction<'r>,
    /// How many control intervals lie between two decisions.
    pace: usize,
    /// One run at a time decides.
    deciding: Mutex<Deciding<'e>>,
}

#[derive(Debug)]
struct Deciding<'e> {
    explorer: &'e mut dyn Explorer,
    failed: Option<EvalError>,
}

impl<'e, 'r> Exploration<'e, 'r> {
    /// A motion of a body with one policy, with these weights where nothing is explored, under these conditions.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn new(
        drive: &Drive<'r>,
        parameters: &[f64],
        conditions: &Conditions,
        explorer: &'e mut dyn Explorer,
    ) -> Result<Self, EvalError> {
        Ok(Self {
            targets: drive.targets_under(parameters, conditions)?,
            reaction: Reaction::new(drive, parameters, conditions)?,
            pace: drive.decision().map_or(1, |decision| decision.pace),
            deciding: Mutex::new(Deciding { explorer, failed: None }),
        })
    }

    /// The motion that it makes in a world.
    #[must_use]
    pub fn case<'a>(&'a self, world: &'a World) -> Case<'a> {
        Case { controller: Some(self), ..Case::new(&self.targets, world) }
    }

    /// What had no value in its motion.
    #[must_use]
    pub fn failed(self) -> Option<EvalError> {
        self.deciding.into_inner().unwrap_or_else(PoisonError::into_inner).failed
    }
}

impl Controller for Exploration<'_, '_> {
    fn interval(&self) -> f64 {
        self.reaction.interval()
    }

    fn commands(&self, actuator: usize) -> bool {
        self.reaction.commands(actuator)
    }

    fn begin(&self) -> Box<dyn ControlLoop + '_> {
        Box::new(Exploring { of: self, running: self.reaction.run(), before: None, moment: 0 })
    }
}

/// The same in its run.
struct Exploring<'a, 'e, 'r> {
    of: &'a Exploration<'e, 'r>,
    running: Running<'a>,
    /// What was so at the last decision.
    before: Option<Snapshot>,
    moment: usize,
}

impl Exploring<'_, '_, '_> {
    fn moment(&mut self, measured: &Measured<'_>) -> Result<(), EvalError> {
        let mut deciding = self.of.deciding.lock().unwrap_or_else(PoisonError::into_inner);
        if self.moment.is_multiple_of(self.of.pace) {
            if let Some(before) = &self.before {
                let reward = self.of.reaction.drive.reward(measured, &before.measured())?;
                deciding.explorer.gain(reward);
            }
            self.before = Some(measured.kept());
        }
        self.moment += 1;
        self.running.moment_by(measured, &mut |query, known| deciding.explorer.decide(query.side, known))
    }
}

impl ControlLoop for Exploring<'_, '_, '_> {
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        if let Err(error) = self.moment(measured) {
            let mut deciding = self.of.deciding.lock().unwrap_or_else(PoisonError::into_inner);
            deciding.failed.get_or_insert(error);
            return Err(Invalid::NoCommand);
        }
        self.running.write(commands);
        Ok(())
    }
}

impl Drive<'_> {
    /// Why the reward of the one policy has no value while the body is at rest, if it has none.
    pub(super) fn reward_fails_at_rest(&self) -> Option<EvalError> {
        let rest = Snapshot::at_rest(&self.candidate.body.assembly);
        let pace = self.decision().map_or(1, |decision| decision.pace);
        let later = rest.clone().at(pace as f64 * self.task.model.control);
        self.reward(&later.measured(), &rest.measured()).err()
    }

    /// What the one policy gains between two moments; nothing if it has no reward.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when the reward has no finite value.
    pub(super) fn reward(&self, now: &Measured<'_>, before: &Measured<'_>) -> Result<f64, EvalError> {
        let decision = self.decision();
        let Some(reward) = decision.as_ref().and_then(|decision| decision.policy.reward.as_ref()) else {
            return Ok(0.0);
        };
        let scope = RewardScope {
            now: FeltScope::new(self, now),
            before: FeltScope::new(self, before),
            at: before.time,
        };
        let value = match evaluate(reward, &scope, &mut Vec::new())? {
            Value::Bool(yes) => Some(f64::from(u8::from(yes))),
            value => value.as_number(),
        };
        let none = || EvalError { span: reward.span, reason: "a reward must be a finite number".to_owned() };
        value.filter(|x| x.is_finite()).ok_or_else(none)
    }
}

/// What a reward reads: what is so now, and what was so at the last decision.
struct RewardScope<'a> {
    now: FeltScope<'a>,
    before: FeltScope<'a>,
    /// When that was, s.
    at: f64,
}

impl Scope for RewardScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        self.now.outer()
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Before => Some(Value::Number(self.at)),
            word => self.now.word(word),
        }
    }

    fn attribute(&self, of: Reference, attribute: &Attribute) -> Option<Value> {
        self.now.attribute(of, attribute)
    }

    fn track(&self, of: Reference, track: Track, time: f64) -> Option<Value> {
        // At the first moment both are the same.
        if time <= self.at { self.before.track(of, track, time) } else { self.now.track(of, track, time) }
    }
}
