//! Lowers an assembly to balls held together by springs.
//!
//! Both solvers that take springs start from this. Balls keep the order of the assembly's
//! elements; the lowest one touches the ground. SI units.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};

use super::check;
use super::motion::Placement;
use super::run::Driven;
use super::{Settings, Unfit, World};
use crate::design::assembly::{Assembly, Element, Shape};

/// How much a ball or a spring is strained for one unit of each target: actuators in ascending
/// order, each once.
pub(super) type Gains = Vec<(usize, f64)>;

/// A lump of material.
#[derive(Clone, Debug)]
pub(super) struct Ball {
    /// Its centre at rest, m.
    pub(super) centre: Vector3<f64>,
    /// Its radius at rest, m.
    pub(super) radius: f64,
    /// Its mass, kg. Without end it is held where it is, which only tests ask for.
    pub(super) mass: f64,
    /// Its Coulomb coefficient.
    pub(super) friction: f64,
    /// How it moves at first, m/s: not at all but in tests.
    pub(super) velocity: Vector3<f64>,
    /// What strains it.
    pub(super) gains: Gains,
}

/// A spring between two balls.
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// The balls.
    pub(super) ends: [usize; 2],
    /// Its length at rest, m.
    pub(super) length: f64,
    /// N/m.
    pub(super) stiffness: f64,
    /// N s/m.
    pub(super) damping: f64,
    /// What strains it: the mean of its ends.
    pub(super) gains: Gains,
}

/// A whole assembly as balls and springs, its lowest point on the ground.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    /// One for each element.
    pub(super) balls: Vec<Ball>,
    /// One for each spring of the assembly.
    pub(super) links: Vec<Link>,
    /// Acceleration by gravity, m/s^2; downwards but in tests.
    pub(super) gravity: Vector3<f64>,
    /// How many actuators there are.
    pub(super) actuators: usize,
}

impl Lattice {
    /// Checks and lowers an assembly.
    pub(super) fn new(assembly: &Assembly, settings: &Settings) -> Result<Self, Unfit> {
        check::settings(settings)?;
        check::lattice(assembly)?;
        check::recording(settings, assembly)?;
        let mut gains = vec![Gains::new(); assembly.elements.len()];
        for swelling in &assembly.swellings {
            add(&mut gains[swelling.element], swelling.actuator, swelling.gain);
        }
        let lowest = |element: &Element| element.pose.translation.vector.y - radius(element);
        let lift = -assembly.elements.iter().map(lowest).fold(f64::INFINITY, f64::min);
        let ball = |(element, gains): (&Element, Gains)| Ball {
            centre: element.pose.translation.vector + Vector3::y() * lift,
            radius: radius(element),
            mass: element.mass,
            friction: element.friction,
            velocity: Vector3::zeros(),
            gains,
        };
        let balls: Vec<Ball> = assembly.elements.iter().zip(gains).map(ball).collect();
        let links = assembly.springs.iter().map(|spring| {
            let ends = [spring.from, spring.to];
            let mut gains = Gains::new();
            for (actuator, gain) in ends.iter().flat_map(|&end| &balls[end].gains) {
                add(&mut gains, *actuator, gain / 2.0);
            }
            let length = (balls[spring.to].centre - balls[spring.from].centre).norm();
            Link { ends, length, stiffness: spring.stiffness, damping: spring.damping, gains }
        });
        let gravity = Vector3::y() * -settings.gravity;
        Ok(Self { links: links.collect(), balls, gravity, actuators: assembly.actuators })
    }

    /// On the slope of a world.
    pub(super) fn sloping(self, world: &World, settings: &Settings) -> Self {
        Self { gravity: world.gravity(settings), ..self }
    }

    /// What runs it: each actuator is a servo that is where it is asked to be.
    pub(super) fn driven(&self) -> Driven {
        let placement = |(body, ball): (usize, &Ball)| Placement {
            body,
            local: Isometry3::identity(),
            shape: Shape::Ball { radius: ball.radius },
            swells: ball.gains.clone(),
        };
        let placements: Arc<[Placement]> = self.balls.iter().enumerate().map(placement).collect();
        Driven::strains(self.actuators, placements)
    }
}

fn radius(element: &Element) -> f64 {
    if let Shape::Ball { radius } = element.shape { radius } else { 0.0 }
}

/// Adds the gain of an actuator to the others; what comes to nothing is left out.
fn add(gains: &mut Gains, actuator: usize, gain: f64) {
    match gains.binary_search_by_key(&actuator, |own| own.0) {
        Ok(place) => gains[place].1 += gain,
        Err(place) => gains.insert(place, (actuator, gain)),
    }
    gains.retain(|own| own.1 != 0.0);
}
