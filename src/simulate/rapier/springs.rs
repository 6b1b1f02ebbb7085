//! A rapier world of balls that do not rotate, held together by its spring joints.

use nalgebra::{Isometry3, Vector3};
use rapier3d::prelude::*;

use super::hinges::{GROUND, LENGTH, MASS, ROBOT, ground, parameters, vector};
use crate::simulate::lattice::{Ball, Gains, Lattice, Link};
use crate::simulate::run::Stepper;
use crate::simulate::{Invalid, Settings};

/// The world and how to make it anew.
pub(super) struct Springs {
    lattice: Lattice,
    settings: Settings,
    /// How many substeps a step is cut into.
    substeps: usize,
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    colliders: Vec<ColliderHandle>,
    joints: Vec<ImpulseJointHandle>,
    targets: Vec<f64>,
    before: Vec<f64>,
    /// Positive work of each actuator so far, J.
    work: Vec<f64>,
    failure: Option<Invalid>,
}

impl Springs {
    /// At rest.
    pub(super) fn new(lattice: &Lattice, settings: &Settings, substep: f64) -> Self {
        let mut own = Self {
            lattice: lattice.clone(),
            settings: settings.clone(),
            substeps: (settings.step / substep - 1e-6).ceil().max(1.0) as usize,
            world: PhysicsWorld::new(),
            bodies: Vec::new(),
            colliders: Vec::new(),
            joints: Vec::new(),
            targets: Vec::new(),
            before: Vec::new(),
            work: Vec::new(),
            failure: None,
        };
        own.build();
        own
    }

    fn build(&mut self) {
        self.world = PhysicsWorld::new();
        self.world.gravity = vector(self.lattice.gravity * LENGTH);
        self.world.integration_parameters = parameters(&self.settings, self.substeps);
        self.world.colliders.insert(ground(&self.settings));
        let Self { world, lattice, settings, .. } = self;
        self.bodies = lattice.balls.iter().map(|ball| world.bodies.insert(lump(ball))).collect();
        let insert = |(ball, &body): (&Ball, &RigidBodyHandle)| {
            let collider = collider(ball, settings.self_collision);
            world.colliders.insert_with_parent(collider, body, &mut world.bodies)
        };
        self.colliders = lattice.balls.iter().zip(&self.bodies).map(insert).collect();
        let joint = |link: &Link| {
            let spring = SpringJointBuilder::new(
                (link.length * LENGTH) as f32,
                (link.stiffness * MASS) as f32,
                (link.damping * MASS) as f32,
            );
            let [from, to] = link.ends.map(|end| self.bodies[end]);
            world.impulse_joints.insert(from, to, spring.contacts_enabled(false).build(), true)
        };
        self.joints = lattice.links.iter().map(joint).collect();
        let none = vec![0.0; lattice.actuators];
        (self.targets, self.before, self.work) = (none.clone(), none.clone(), none);
    }

    fn place(&self, ball: usize) -> Vector3<f64> {
        let place: Isometry3<f32> = (*self.world.bodies[self.bodies[ball]].position()).into();
        place.cast::<f64>().translation.vector / LENGTH
    }

    /// Gives springs and balls the strains that are asked for, and counts what that takes.
    fn strain(&mut self) {
        if self.targets == self.before {
            return;
        }
        for index in 0..self.joints.len() {
            let link = &self.lattice.links[index];
            if link.gains.is_empty() {
                continue;
            }
            let [before, rest] = [&self.before, &self.targets].map(|t| 1.0 + strain(&link.gains, t));
            let [from, to] = link.ends;
            let length = (self.place(to) - self.place(from)).norm();
            let push = link.stiffness * (link.length * before - length) * link.length;
            for &(actuator, gain) in &link.gains {
                let change = gain * (self.targets[actuator] - self.before[actuator]);
                self.work[actuator] += (push * change).max(0.0);
            }
            if let Some(joint) = self.world.impulse_joints.get_mut(self.joints[index], false) {
                let (length, stiffness) = (link.length * rest * LENGTH, link.stiffness * MASS);
                let damping = (link.damping * MASS) as f32;
                joint.data.set_motor_position(JointAxis::LinX, length as f32, stiffness as f32, damping);
            }
        }
        for (ball, &handle) in self.lattice.balls.iter().zip(&self.colliders) {
            if !ball.gains.is_empty()
                && let Some(collider) = self.world.colliders.get_mut(handle)
            {
                let radius = ball.radius * (1.0 + strain(&ball.gains, &self.targets)) * LENGTH;
                collider.set_shape(SharedShape::ball(radius as f32));
            }
        }
        self.before.copy_from_slice(&self.targets);
    }

    /// Refuses numbers that are not finite, and balls beyond the limit or below the ground.
    fn check(&self) -> Option<Invalid> {
        let speeds = self.bodies.iter().map(|&body| f64::from(self.world.bodies[body].linvel().length()));
        if !speeds.clone().all(f64::is_finite) {
            return Some(Invalid::NotFinite);
        }
        let limit = self.settings.speed_limit * LENGTH;
        if speeds.clone().any(|speed| speed > limit) {
            return Some(Invalid::TooFast);
        }
        let held = |ball: usize| self.lattice.balls[ball].mass.is_infinite();
        let sunk = (0..self.bodies.len()).any(|ball| !held(ball) && self.place(ball).y < 0.0);
        sunk.then_some(Invalid::Sunk)
    }
}

impl Stepper for Springs {
    const LANES: usize = 1;

    fn reset(&mut self) {
        self.failure = None;
        self.build();
    }

    fn aim(&mut self, _: usize, actuator: usize, target: f64) {
        self.targets[actuator] = target;
    }

    fn step(&mut self) {
        self.strain();
        self.world.step();
        self.failure = self.failure.or(self.check());
    }

    fn failure(&self, _: usize) -> Option<Invalid> {
        self.failure
    }

    fn pose(&self, _: usize, ball: usize) -> Isometry3<f64> {
        Isometry3::from(self.place(ball))
    }

    fn position(&self, _: usize, actuator: usize) -> f64 {
        self.targets[actuator]
    }

    fn work(&self, _: usize, actuator: usize) -> f64 {
        self.work[actuator]
    }
}

fn strain(gains: &Gains, targets: &[f64]) -> f64 {
    gains.iter().map(|&(actuator, gain)| gain * targets[actuator]).sum()
}

fn lump(ball: &Ball) -> RigidBody {
    let builder =
        if ball.mass.is_infinite() { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
    let mass = MassProperties::new(Vector::ZERO, (ball.mass.min(1e9) * MASS) as f32, Vector::ONE);
    builder
        .translation(vector(ball.centre * LENGTH))
        .linvel(vector(ball.velocity * LENGTH))
        .additional_mass_properties(mass)
        .lock_rotations()
        .can_sleep(false)
        .build()
}

fn collider(ball: &Ball, self_collision: bool) -> Collider {
    let others = if self_collision { GROUND | ROBOT } else { GROUND };
    let (own, others) = if ball.mass.is_infinite() { (ROBOT, others & ROBOT) } else { (ROBOT, others) };
    ColliderBuilder::new(SharedShape::ball((ball.radius * LENGTH) as f32))
        .density(0.0)
        .friction(ball.friction as f32)
        .friction_combine_rule(CoefficientCombineRule::GeometricMean)
        .collision_groups(InteractionGroups::new(own, others, InteractionTestMode::And))
        .build()
}
