//! Feedback: what actuators are asked for as the body moves, from what is measured of it.
//!
//! A [`Controller`] is asked at control moments, at equal intervals from time zero on. What it answers holds until the next
//! moment, as a digital controller's output does; the targets of actuators that it leaves alone are known ahead
//! ([`Targets`](super::Targets)). At half the step of a solver a controller is asked at the same times, as
//! long as control moments fall on steps; at a moment within a step it is asked where that step ends.

use std::fmt::Debug;

use nalgebra::{Isometry3, Vector3};

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
        Measured { time: self.time, known: self, placements: &self.placements }
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
            loads: elements.map(|element| self.load(element)).collect(),
        }
    }

    /// The pose of an element in the world, m; none of one that does not exist.
    #[must_use]
    pub fn pose(&self, element: usize) -> Option<Isometry3<f64>> {
        let placement = self.placements.get(element)?;
        Some(self.known.pose(placement.body) * placement.local)
    }

    /// The velocity of the centre of an element, m/s, and its angular velocity, rad/s, in the axes of the world. None where the
    /// solver does not know it.
    #[must_use]
    pub fn velocity(&self, element: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let placement = self.placements.get(element)?;
        let (velocity, spin) = self.known.velocity(placement.body)?;
        let arm = self.known.pose(placement.body).rotation * placement.local.translation.vector;
        Some((velocity + spin.cross(&arm), spin))
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

    /// How fast the position of an actuator changes, rad/s or m/s.
    #[must_use]
    pub fn rate(&self, actuator: usize) -> Option<f64> {
        self.known.rates().get(actuator).copied()
    }
}
