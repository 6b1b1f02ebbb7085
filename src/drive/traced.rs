//! Motions of which it is kept what sensors read, what is remembered, and what actuators are asked for.

use std::sync::{Mutex, PoisonError};

use grammar_lang::eval::EvalError;

use super::Drive;
use super::conditions::Conditions;
use super::feedback::{Reaction, Running};
use super::signals::{Row, Trace};
use crate::simulate::{Case, ControlLoop, Controller, Invalid, Measured, Targets, World};

/// What drives a body whose signals are kept.
#[derive(Debug)]
pub struct Traced<'r> {
    targets: Targets,
    reaction: Reaction<'r>,
    rows: Mutex<Vec<Row>>,
}

impl<'r> Traced<'r> {
    /// A motion of a body with these values under these conditions.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn new(drive: &Drive<'r>, parameters: &[f64], conditions: &Conditions) -> Result<Self, EvalError> {
        Ok(Self {
            targets: drive.targets_under(parameters, conditions)?,
            reaction: Reaction::new(drive, parameters, conditions)?,
            rows: Mutex::new(Vec::new()),
        })
    }

    /// The motion that it makes in a world.
    #[must_use]
    pub fn case<'a>(&'a self, world: &'a World) -> Case<'a> {
        Case { controller: Some(self), ..Case::new(&self.targets, world) }
    }

    /// What was kept of its motion.
    #[must_use]
    pub fn trace(self) -> Trace {
        Trace {
            signals: self.reaction.signals(),
            interval: self.reaction.interval(),
            rows: self.rows.into_inner().unwrap_or_else(PoisonError::into_inner),
        }
    }
}

impl Controller for Traced<'_> {
    fn interval(&self) -> f64 {
        self.reaction.interval()
    }

    fn commands(&self, actuator: usize) -> bool {
        self.reaction.commands(actuator)
    }

    fn begin(&self) -> Box<dyn ControlLoop + '_> {
        Box::new(Tracing { of: self, running: self.reaction.run() })
    }
}

/// The same in its run.
struct Tracing<'a, 'r> {
    of: &'a Traced<'r>,
    running: Running<'a>,
}

impl ControlLoop for Tracing<'_, '_> {
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        let row = self.running.traced(measured).map_err(|_| Invalid::NoCommand)?;
        self.of.rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
        self.running.write(commands);
        Ok(())
    }
}
