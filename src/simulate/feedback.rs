//! Feedback: what actuators are asked for as the body moves, from what is measured of it.
//!
//! A [`Controller`] is asked at control moments, at equal intervals from time zero on. What it answers holds until the next
//! moment, as a digital controller's output does; the targets of actuators that it leaves alone are known ahead
//! ([`Targets`](super::Targets)). At half the step of a solver a controller is asked at the same times, as
//! long as control moments fall on steps; at a moment within a step it is asked where that step ends.

use std::fmt::Debug;

use nalgebra::Isometry3;

use super::Invalid;
use super::motion::Placement;

/// A feedback controller: the law, of which any number of runs may be under way.
pub trait Controller: Debug + Sync {
    /// Time between two control moments, s.
    fn interval(&self) -> f64;

    /// Whether it commands an actuator.
    fn commands(&self, actuator: usize) -> bool;

    /// A run from rest.
    fn begin(&self) -> Box<dyn ControlLoop + '_>;
}

/// A controller in one run, with what it remembers of it.
pub trait ControlLoop {
    /// Answers a measurement: writes what each actuator that it commands is asked for until the next moment, rad, m or rad/s by
    /// the kind of its joint.
    ///
    /// # Errors
    ///
    /// [`Invalid::NoCommand`] where an expression has no value. A command that is not finite ends the run, too.
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid>;
}

/// What can be measured of a body at one moment, without noise or delay.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// When, s.
    pub time: f64,
    pub(super) poses: &'a [Isometry3<f64>],
    pub(super) placements: &'a [Placement],
    pub(super) positions: &'a [f64],
}

impl Measured<'_> {
    /// The pose of an element in the world, m; none of one that does not exist.
    #[must_use]
    pub fn pose(&self, element: usize) -> Option<Isometry3<f64>> {
        let placement = self.placements.get(element)?;
        Some(self.poses.get(placement.body)? * placement.local)
    }

    /// The height of the lowest point of an element, m.
    #[must_use]
    pub fn lowest(&self, element: usize) -> Option<f64> {
        let shape = &self.placements.get(element)?.shape;
        Some(shape.lowest(&self.pose(element)?))
    }

    /// The position of an actuator from base to tip, rad or m; of a motor its speed, rad/s.
    #[must_use]
    pub fn position(&self, actuator: usize) -> Option<f64> {
        self.positions.get(actuator).copied()
    }
}
