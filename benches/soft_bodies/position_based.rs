//! Position-based dynamics (PBD) and its extended form with compliance (XPBD).
//!
//! Sources: Mueller, Heidelberger, Hennix and Ratcliff, "Position based dynamics" (2007);
//! Macklin, Mueller and Chentanez, "XPBD: position-based simulation of compliant constrained dynamics" (2016);
//! Macklin, Mueller, Chentanez and Kim, "Unified particle physics for real-time applications" (2014), for Coulomb friction.

use crate::scenes::{Solver, World};
use crate::voxels::Body;
use nalgebra::Vector3;

/// How a distance constraint is soft.
#[derive(Clone, Copy)]
pub(crate) enum Softness {
    /// PBD: every iteration corrects this share, in [0, 1], of the error.
    EachIteration(f64),
    /// PBD: all iterations of a step together correct this share of a lone constraint's error (2007, section 3.3).
    WholeStep(f64),
    /// XPBD: the compliance is the inverse of the spring's stiffness.
    Compliance,
}

/// How particles on the ground rub.
#[derive(Clone, Copy)]
pub(crate) enum Friction {
    /// The thesis's: once a step, a correction of `mu (p_before - p)` along the ground, whatever the normal force.
    Share,
    /// Coulomb's: every iteration, a correction back of at most `mu` times the correction out of the ground.
    Coulomb,
}

/// Position-based dynamics with a fixed step and a fixed number of Gauss-Seidel iterations.
pub(crate) struct PositionBased {
    step: f64,
    iterations: usize,
    softness: Softness,
    friction: Friction,
    before: Vec<Vector3<f64>>,
    multipliers: Vec<f64>,
    touched: Vec<bool>,
}

impl PositionBased {
    /// A solver with a fixed step in s.
    pub(crate) fn new(step: f64, iterations: usize, softness: Softness, friction: Friction) -> Self {
        let (before, multipliers, touched) = (Vec::new(), Vec::new(), Vec::new());
        Self { step, iterations, softness, friction, before, multipliers, touched }
    }

    fn predict(&mut self, body: &mut Body, world: &World) {
        self.before.clone_from(&body.positions);
        self.touched.clear();
        self.touched.resize(body.positions.len(), false);
        self.multipliers.clear();
        self.multipliers.resize(body.springs.len(), 0.0);
        let slowing = 1.0 / (1.0 + world.drag * self.step);
        for i in (0..body.positions.len()).filter(|&i| body.inverse_masses[i] > 0.0) {
            let velocity = body.velocities[i] * slowing + world.gravity * self.step;
            body.positions[i] += velocity * self.step;
        }
    }

    fn project_springs(&mut self, body: &mut Body) {
        let factor = match self.softness {
            Softness::EachIteration(k) => k,
            Softness::WholeStep(k) => 1.0 - libm::pow(1.0 - k, 1.0 / self.iterations as f64),
            Softness::Compliance => 1.0,
        };
        for (spring, multiplier) in body.springs.iter().zip(&mut self.multipliers) {
            let [a, b] = spring.ends;
            let [wa, wb] = spring.ends.map(|end| body.inverse_masses[end]);
            if wa + wb == 0.0 {
                continue;
            }
            let along = body.positions[b] - body.positions[a];
            let length = along.norm();
            let error = length - spring.rest;
            // The multiplier changes by a fraction. XPBD's is extended by the stiffness times the step squared.
            let (numerator, denominator) = match self.softness {
                Softness::EachIteration(_) | Softness::WholeStep(_) => (-factor * error, wa + wb),
                Softness::Compliance => {
                    let stiffness = spring.stiffness * self.step * self.step;
                    (-error * stiffness - *multiplier, (wa + wb) * stiffness + 1.0)
                }
            };
            let scale = numerator / (denominator * length);
            *multiplier += scale * length;
            let correction = along * scale;
            body.positions[a] -= correction * wa;
            body.positions[b] += correction * wb;
        }
    }

    fn project_contacts(&mut self, body: &mut Body, friction: f64) {
        for (i, position) in body.positions.iter_mut().enumerate().filter(|(_, p)| p.z < 0.0) {
            let depth = -position.z;
            position.z = 0.0;
            self.touched[i] = true;
            if matches!(self.friction, Friction::Coulomb) {
                let slip = along_ground(self.before[i] - *position);
                let distance = slip.norm();
                if distance > 0.0 {
                    *position += slip * (friction * depth / distance).min(1.0);
                }
            }
        }
    }

    fn rub(&self, body: &mut Body, friction: f64) {
        for (i, position) in body.positions.iter_mut().enumerate().filter(|(i, _)| self.touched[*i]) {
            *position += along_ground(self.before[i] - *position) * friction;
        }
    }
}

fn along_ground(v: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, 0.0)
}

impl Solver for PositionBased {
    fn step(&self) -> f64 {
        self.step
    }

    fn advance(&mut self, body: &mut Body, world: &World) {
        self.predict(body, world);
        for _ in 0..self.iterations {
            self.project_springs(body);
            if let Some(friction) = world.ground {
                self.project_contacts(body, friction);
            }
        }
        if let (Some(friction), Friction::Share) = (world.ground, self.friction) {
            self.rub(body, friction);
        }
        for (i, velocity) in body.velocities.iter_mut().enumerate() {
            *velocity = (body.positions[i] - self.before[i]) / self.step;
        }
    }
}
