//! The force-based method: springs and contacts are forces, and the step is explicit (semi-implicit Euler).

use crate::scenes::{Solver, World};
use crate::voxels::Body;
use nalgebra::Vector3;

/// Damping of a spring over its stiffness, s.
const SPRING_DAMPING: f64 = 5e-5;
/// Friction is nearly Coulomb's above this sliding speed, m/s.
const FRICTION_SPEED: f64 = 0.01;

/// How the ground pushes a particle.
#[derive(Clone, Copy)]
pub(crate) struct Contact {
    /// The stiffness grows by this much per metre of penetration, N/m^2.
    pub(crate) stiffening: f64,
    /// Damping over the critical damping of the particle on the contact's spring.
    pub(crate) damping: f64,
}

impl Contact {
    /// Contacts that neither sink much nor shorten the step much, for the bodies here.
    pub(crate) const TUNED: Self = Self { stiffening: 2e6, damping: 0.2 };

    /// The force (N) on a particle at a depth (m). The depth sets the stiffness. The ground never pulls.
    ///
    /// Friction is Coulomb's, smoothed at low speed; it never does more than stop the particle in a step (s).
    fn force(
        &self,
        depth: f64,
        velocity: &Vector3<f64>,
        mass: f64,
        friction: f64,
        step: f64,
    ) -> Vector3<f64> {
        let stiffness = self.stiffening * depth;
        let damping = 2.0 * self.damping * (stiffness * mass).sqrt();
        let normal = (stiffness * depth - damping * velocity.z).max(0.0);
        let sliding = Vector3::new(velocity.x, velocity.y, 0.0);
        let smoothed = (sliding.norm_squared() + FRICTION_SPEED * FRICTION_SPEED).sqrt();
        Vector3::z() * normal - sliding * (friction * normal / smoothed).min(mass / step)
    }
}

/// Springs as forces with explicit steps.
pub(crate) struct ForceBased {
    step: f64,
    contact: Contact,
    forces: Vec<Vector3<f64>>,
}

impl ForceBased {
    /// A solver with a fixed step in s.
    pub(crate) fn new(step: f64, contact: Contact) -> Self {
        Self { step, contact, forces: Vec::new() }
    }

    fn add_springs(&mut self, body: &Body) {
        for spring in &body.springs {
            let [a, b] = spring.ends;
            let along = body.positions[b] - body.positions[a];
            let length = along.norm();
            let direction = along * (1.0 / length);
            let rate = direction.dot(&(body.velocities[b] - body.velocities[a]));
            let force = direction * (spring.stiffness * (length - spring.rest + SPRING_DAMPING * rate));
            self.forces[a] += force;
            self.forces[b] -= force;
        }
    }

    fn add_contacts(&mut self, body: &Body, friction: f64) {
        for (i, position) in body.positions.iter().enumerate().filter(|(_, p)| p.z < 0.0) {
            let (velocity, mass) = (&body.velocities[i], body.masses[i]);
            self.forces[i] += self.contact.force(-position.z, velocity, mass, friction, self.step);
        }
    }
}

impl Solver for ForceBased {
    fn step(&self) -> f64 {
        self.step
    }

    fn advance(&mut self, body: &mut Body, world: &World) {
        self.forces.clear();
        self.forces.resize(body.positions.len(), Vector3::zeros());
        self.add_springs(body);
        if let Some(friction) = world.ground {
            self.add_contacts(body, friction);
        }
        let slowing = 1.0 / (1.0 + world.drag * self.step);
        for (i, force) in self.forces.iter().enumerate() {
            if body.inverse_masses[i] > 0.0 {
                let acceleration = world.gravity + force * body.inverse_masses[i];
                body.velocities[i] = (body.velocities[i] + acceleration * self.step) * slowing;
                body.positions[i] += body.velocities[i] * self.step;
            }
        }
    }
}
