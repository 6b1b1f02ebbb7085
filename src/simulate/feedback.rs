//! Feedback: what actuators are asked for as the body moves, from what is measured of it.
//!
//! A [`Controller`] is asked at control moments, at equal intervals from time zero on. What it answers holds until the next
//! moment, as a digital controller's output does; the targets of actuators that it leaves alone are known ahead
//! ([`Targets`](super::Targets)). At half the step of a solver a controller is asked at the same times, as
//! long as control moments fall on steps; at a moment within a step it is asked where that step ends.

use std::f64::consts::TAU;
use std::fmt::Debug;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::Invalid;
use super::motion::Placement;
use crate::design::assembly::{Assembly, Element};

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

/// What a solver knows of one run at one moment.
pub(super) trait Observable {
    /// The pose of a body in the world, m.
    fn pose(&self, body: usize) -> Isometry3<f64>;
    /// The velocity of a body's origin, m/s, and its angular velocity, rad/s, in the axes of the world.
    fn velocity(&self, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)>;
    /// The position of each actuator from base to tip, rad or m; of a motor its speed, rad/s.
    fn positions(&self) -> &[f64];
    /// How fast each position changes, rad/s or m/s; of a motor its speed.
    fn rates(&self) -> &[f64];
    /// The force with which the ground carries an element, N.
    fn load(&self, element: usize) -> Option<f64>;
}

/// Where a body was at the control moment before: rates are taken from there.
#[derive(Clone, Debug)]
pub(super) struct Earlier {
    /// When, s.
    pub(super) time: f64,
    /// The pose of each body in the world, m.
    pub(super) poses: Vec<Isometry3<f64>>,
    /// The position of each actuator, rad or m.
    pub(super) positions: Vec<f64>,
}

/// What was so of a body at one moment, kept. Each element is a body of its own here.
#[derive(Clone, Debug)]
pub struct Snapshot {
    time: f64,
    poses: Vec<Isometry3<f64>>,
    velocities: Vec<Option<(Vector3<f64>, Vector3<f64>)>>,
    placements: Vec<Placement>,
    positions: Vec<f64>,
    rates: Vec<f64>,
    loads: Vec<Option<f64>>,
    earlier: Option<Earlier>,
}

impl Snapshot {
    /// A body at rest as its assembly says, before anything moves.
    #[must_use]
    pub fn at_rest(assembly: &Assembly) -> Self {
        let placement =
            |(body, element): (usize, &Element)| Placement::new(body, Isometry3::identity(), element.shape);
        let elements = assembly.elements.len();
        Self {
            time: 0.0,
            poses: assembly.elements.iter().map(|element| element.pose).collect(),
            velocities: vec![Some((Vector3::zeros(), Vector3::zeros())); elements],
            placements: assembly.elements.iter().enumerate().map(placement).collect(),
            positions: vec![0.0; assembly.actuators],
            rates: vec![0.0; assembly.actuators],
            loads: vec![Some(0.0); elements],
            earlier: None,
        }
    }

    /// The same at another time, s.
    #[must_use]
    pub fn at(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// What is measured of it.
    #[must_use]
    pub fn measured(&self) -> Measured<'_> {
        let earlier = self.earlier.as_ref();
        Measured { time: self.time, known: self, placements: &self.placements, earlier }
    }
}

impl Observable for Snapshot {
    fn pose(&self, body: usize) -> Isometry3<f64> {
        self.poses.get(body).copied().unwrap_or_else(Isometry3::identity)
    }

    fn velocity(&self, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        self.velocities.get(body).copied().flatten()
    }

    fn positions(&self) -> &[f64] {
        &self.positions
    }

    fn rates(&self) -> &[f64] {
        &self.rates
    }

    fn load(&self, element: usize) -> Option<f64> {
        self.loads.get(element).copied().flatten()
    }
}

/// What can be measured of a body at one moment, without noise or delay.
#[derive(Clone, Copy)]
pub struct Measured<'a> {
    /// When, s.
    pub time: f64,
    pub(super) known: &'a dyn Observable,
    pub(super) placements: &'a [Placement],
    /// None at the first control moment.
    pub(super) earlier: Option<&'a Earlier>,
}

impl Measured<'_> {
    /// All of it, to be read later.
    #[must_use]
    pub fn kept(&self) -> Snapshot {
        let elements = 0..self.placements.len();
        let placement = |(body, placement): (usize, &Placement)| Placement {
            body,
            local: Isometry3::identity(),
            ..placement.clone()
        };
        Snapshot {
            time: self.time,
            poses: elements.clone().filter_map(|element| self.pose(element)).collect(),
            velocities: elements.clone().map(|element| self.velocity(element)).collect(),
            placements: self.placements.iter().enumerate().map(placement).collect(),
            positions: self.known.positions().to_vec(),
            rates: self.known.rates().to_vec(),
            loads: elements.clone().map(|element| self.load(element)).collect(),
            earlier: self.earlier.map(|earlier| Earlier {
                time: earlier.time,
                poses: elements.filter_map(|element| self.pose_before(element)).collect(),
                positions: earlier.positions.clone(),
            }),
        }
    }

    /// The time since the control moment before, s; none at the first one.
    #[must_use]
    pub fn passed(&self) -> Option<f64> {
        self.earlier.map(|earlier| self.time - earlier.time).filter(|passed| *passed > 0.0)
    }

    /// The pose of an element in the world at the control moment before, m; none at the first one.
    #[must_use]
    pub fn pose_before(&self, element: usize) -> Option<Isometry3<f64>> {
        let placement = self.placements.get(element)?;
        Some(self.earlier?.poses.get(placement.body)? * placement.local)
    }

    /// The pose of an element in the world, m; none of one that does not exist.
    #[must_use]
    pub fn pose(&self, element: usize) -> Option<Isometry3<f64>> {
        let placement = self.placements.get(element)?;
        Some(self.known.pose(placement.body) * placement.local)
    }

    /// The velocity of the centre of an element, m/s, and its angular velocity, rad/s, in the axes of the world: the means since the control
    /// moment before. What is asked for changes at control moments only, so that the last step before one is slower than the others. None where
    /// the solver does not know it.
    #[must_use]
    pub fn velocity(&self, element: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let placement = self.placements.get(element)?;
        let (velocity, spin) = self.known.velocity(placement.body)?;
        match self.passed().zip(self.pose_before(element)) {
            Some((passed, before)) => {
                let now = self.pose(element)?;
                let gone = now.translation.vector - before.translation.vector;
                Some((gone / passed, mean_spin(&before.rotation, &now.rotation, &spin, passed)))
            }
            None => {
                let arm = self.known.pose(placement.body).rotation * placement.local.translation.vector;
                Some((velocity + spin.cross(&arm), spin))
            }
        }
    }

    /// The height of the lowest point of an element, m.
    #[must_use]
    pub fn lowest(&self, element: usize) -> Option<f64> {
        let shape = self.placements.get(element)?.swollen(|actuator| self.position(actuator).unwrap_or(0.0));
        Some(shape.lowest(&self.pose(element)?))
    }

    /// The greatest extent of an element, m.
    #[must_use]
    pub fn size(&self, element: usize) -> Option<f64> {
        Some(self.placements.get(element)?.shape.longest())
    }

    /// The force with which the ground carries an element, N: the normal force in the mean over the last step. Of elements that
    /// are joined rigidly, those have it whose corners are corners of the whole. None where the solver does not know it.
    #[must_use]
    pub fn load(&self, element: usize) -> Option<f64> {
        self.placements.get(element)?;
        self.known.load(element)
    }

    /// The position of an actuator from base to tip, rad or m; of a motor its speed, rad/s.
    #[must_use]
    pub fn position(&self, actuator: usize) -> Option<f64> {
        self.known.positions().get(actuator).copied()
    }

    /// How fast the position of an actuator changes, rad/s or m/s: the mean since the control moment before.
    #[must_use]
    pub fn rate(&self, actuator: usize) -> Option<f64> {
        match self.passed().zip(self.earlier) {
            Some((passed, earlier)) => {
                Some((self.position(actuator)? - earlier.positions.get(actuator)?) / passed)
            }
            None => self.known.rates().get(actuator).copied(),
        }
    }
}

/// The mean angular velocity of what turned from one rotation to another, rad/s. How often it turned quite round, its angular velocity at the end
/// tells.
fn mean_spin(
    before: &UnitQuaternion<f64>,
    now: &UnitQuaternion<f64>,
    spin: &Vector3<f64>,
    passed: f64,
) -> Vector3<f64> {
    let turn = now * before.inverse();
    let sine = turn.imag().norm();
    let way = if sine > 1e-9 { turn.imag() / sine } else { spin.try_normalize(1e-9).unwrap_or_default() };
    let angle = 2.0 * libm::atan2(sine, turn.w);
    let whole = libm::round((spin.dot(&way) * passed - angle) / TAU);
    way * ((angle + whole * TAU) / passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_angular_velocity_counts_whole_turns() {
        for speed in [-70.0, -3.0, -0.1, 0.0, 2.0, 40.0, 130.0] {
            let axis = Vector3::new(1.0, 2.0, -2.0) / 3.0;
            let before = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.0, 0.2));
            let now = UnitQuaternion::from_scaled_axis(axis * (speed / 20.0)) * before;
            let mean = mean_spin(&before, &now, &(axis * speed * 0.95), 1.0 / 20.0);
            assert!((mean - axis * speed).norm() < 1e-9 * f64::max(1.0, speed.abs()), "{speed}: {mean}");
        }
    }
}
