//! What actuators are asked for over one period: what hardware plays over and over.

use grammar_lang::eval::{EvalError, Valves, evaluate, evaluate_number, evaluate_over};

use super::{Drive, Driven};
use crate::design::PartId;

/// What the actuators of one kind are asked for over a period that repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// How long it lasts, s.
    pub period: f64,
    /// The actuators in the order of the assembly.
    pub actuators: Vec<(PartId, Asked)>,
}

/// What one actuator is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// States of its valves.
    Valves(Valves),
    /// Bends in rad, distances in m or speeds in rad/s at equal distances over the period, the first at its beginning.
    Bends(Vec<f64>),
}

/// Two bends that differ by less, in rad, are the same.
const CLOSE: f64 = 1e-6;

impl Drive<'_> {
    /// What the actuators of a kind are asked for over a period, bends at so many points; as asked, before any
    /// hardware limits it. None if what they are asked for does not repeat.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn cycle(&self, kind: &str, parameters: &[f64], points: usize) -> Result<Option<Cycle>, EvalError> {
        let first = self.actuators.iter().find(|driven| self.kind_of(driven) == Some(kind));
        // A cycle of valves may have its period from anywhere.
        let own = first.map(|driven| self.valves(driven, parameters)).transpose()?.flatten();
        let period = match own {
            Some(valves) => valves.period,
            None => self.period_of(|other| other == kind, parameters)?,
        };
        let mut actuators = Vec::new();
        for driven in self.actuators.iter().filter(|driven| self.kind_of(driven) == Some(kind)) {
            if let Some(valves) = self.valves(driven, parameters)? {
                if (valves.period - period).abs() > CLOSE {
                    return Ok(None);
                }
                actuators.push((driven.id, Asked::Valves(valves)));
                continue;
            }
            let times = |from: f64| (0..points).map(move |i| from + period * i as f64 / points as f64);
            let bends = self.bends(driven, parameters, times(0.0))?;
            let again = self.bends(driven, parameters, times(period))?;
            if bends.iter().zip(&again).any(|(a, b)| (a - b).abs() > CLOSE) {
                return Ok(None);
            }
            actuators.push((driven.id, Asked::Bends(bends)));
        }
        Ok(Some(Cycle { period, actuators }))
    }

    /// What an actuator is asked for at some times in s, as far as it can do it: its bend in rad, its distance in m, or its
    /// speed in rad/s.
    pub(super) fn bends(
        &self,
        driven: &Driven,
        parameters: &[f64],
        times: impl Iterator<Item = f64>,
    ) -> Result<Vec<f64>, EvalError> {
        let Some((_, actuation)) = self.actuations.get(driven.actuation) else { return Ok(Vec::new()) };
        let mut scope = self.scope();
        let mut locals = self.lets(driven, parameters)?;
        let fixed = locals.len();
        let (low, high) = self.driven_range(driven);
        // An actuator cannot go further than it can.
        let within = |bend: f64| bend.max(low).min(high);
        let times: Vec<f64> = times.collect();
        if actuation.moving.is_empty()
            && let Some(mut bends) = evaluate_over(&actuation.drive, &scope, &locals, &times)
        {
            bends.iter_mut().for_each(|bend| *bend = within(*bend));
            return Ok(bends);
        }
        let mut bends = Vec::with_capacity(times.len());
        for time in times {
            scope.time = time;
            locals.truncate(fixed);
            for (_, value) in &actuation.moving {
                let value = evaluate(value, &scope, &mut locals)?;
                locals.push(value);
            }
            let bend = evaluate_number(&actuation.drive, &scope, &mut locals)?;
            bends.push(within(bend));
        }
        Ok(bends)
    }
}
