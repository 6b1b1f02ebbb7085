//! A rapier world with one robot and the ground.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::design::assembly::{Hinge, Shape};
use crate::simulate::lowering::{Body, Lowered, Piece};
use crate::simulate::run::Stepper;
use crate::simulate::{Invalid, Settings};

/// cm per m.
pub(super) const LENGTH: f64 = 1e2;
/// g per kg.
pub(super) const MASS: f64 = 1e3;
/// g cm^2/s^2 per N m; also g cm^2 per kg m^2.
const TORQUE: f64 = MASS * LENGTH * LENGTH;
/// The ground is in the first group, the robot in the second.
pub(super) const GROUND: Group = Group::GROUP_1;
/// The robot's.
pub(super) const ROBOT: Group = Group::GROUP_2;

/// The world and how to make it anew.
pub(super) struct Hinges {
    lowered: Lowered,
    settings: Settings,
    /// As the ground sees it, m/s^2.
    gravity: Vector3<f64>,
    /// How many substeps a step is cut into.
    substeps: usize,
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    joints: Vec<ImpulseJointHandle>,
    /// Angle of each hinge without jumps at half a turn, rad.
    angles: Vec<f64>,
    /// Work done at each hinge so far, J.
    work: Vec<f64>,
    failure: Option<Invalid>,
}

impl Hinges {
    /// At rest.
    pub(super) fn new(lowered: &Lowered, settings: &Settings, gravity: Vector3<f64>, substep: f64) -> Self {
        let mut own = Self {
            lowered: lowered.clone(),
            settings: settings.clone(),
            gravity,
            substeps: (settings.step / substep - 1e-6).ceil().max(1.0) as usize,
            world: PhysicsWorld::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            angles: Vec::new(),
            work: Vec::new(),
            failure: None,
        };
        own.build();
        own
    }

    fn build(&mut self) {
        self.world = PhysicsWorld::new();
        self.world.gravity = vector(self.gravity * LENGTH);
        self.world.integration_parameters = parameters(&self.settings, self.substeps);
        self.world.colliders.insert(ground(&self.settings));
        let Hinges { world, lowered, .. } = self;
        self.bodies = lowered.bodies.iter().map(|body| world.bodies.insert(rigid_body(body))).collect();
        for piece in &lowered.pieces {
            let collider = collider(piece, self.settings.self_collision);
            world.colliders.insert_with_parent(collider, self.bodies[piece.body], &mut world.bodies);
        }
        self.joints.clear();
        for (index, body) in lowered.bodies.iter().enumerate().skip(1) {
            let Some(hinge) = &body.hinge else { continue };
            let joint = revolute(hinge, &lowered.bodies[body.parent], body);
            let (parent, child) = (self.bodies[body.parent], self.bodies[index]);
            self.joints.push(world.impulse_joints.insert(parent, child, joint, true));
        }
        self.angles = vec![0.0; self.joints.len()];
        self.work = vec![0.0; self.joints.len()];
    }

    fn body(&self, body: usize) -> &RigidBody {
        &self.world.bodies[self.bodies[body]]
    }

    /// The turn of a hinge from the rotations of its bodies, nearest to its
    /// last one.
    fn turn(&self, hinge: usize) -> f64 {
        let own = &self.lowered.bodies[hinge + 1];
        let Some(spec) = &own.hinge else { return 0.0 };
        let relative = self.pose(0, own.parent).rotation.inverse() * self.pose(0, hinge + 1).rotation;
        let angle = 2.0 * libm::atan2(relative.imag().dot(&spec.axis), relative.w);
        let turns = ((angle - self.angles[hinge]) / std::f64::consts::TAU).round();
        angle - turns * std::f64::consts::TAU
    }

    /// The mean torque of a hinge's motor over the last step, in which the
    /// hinge turned by an angle, N m.
    ///
    /// rapier tells the impulse of the last substep only (that on the parent).
    /// A motor that is not at its limit had, on average, as much more or less as
    /// its angle and speed differed from those of the end.
    fn torque(&self, hinge: usize, turned: f64) -> f64 {
        let own = &self.lowered.bodies[hinge + 1];
        let joint = self.world.impulse_joints.get(self.joints[hinge]);
        let (Some(joint), Some(spec)) = (joint, &own.hinge) else { return 0.0 };
        let step = self.settings.step;
        let impulse = f64::from(joint.data.motors[JointAxis::AngX as usize].impulse);
        let last = -impulse * self.substeps as f64 / step / TORQUE;
        if last.abs() > 0.999 * spec.torque {
            return last;
        }
        let (parent, child) = (self.body(own.parent), self.body(hinge + 1));
        let axis = parent.rotation() * vector(spec.axis.into_inner());
        let speed = f64::from((child.angvel() - parent.angvel()).dot(axis));
        let change = spec.stiffness * turned / 2.0 + spec.damping * (speed - turned / step);
        (last + change).clamp(-spec.torque, spec.torque)
    }

    /// Refuses numbers that are not finite, and elements beyond the limit.
    fn check(&self) -> Result<(), Invalid> {
        let limit = self.settings.speed_limit * LENGTH;
        for piece in &self.lowered.pieces {
            let body = self.body(piece.body);
            let arm = piece.local.translation.vector * LENGTH;
            let arm = body.rotation() * vector(arm);
            let speed = f64::from((body.linvel() + body.angvel().cross(arm)).length());
            if !speed.is_finite() {
                return Err(Invalid::NotFinite);
            }
            if speed > limit {
                return Err(Invalid::TooFast);
            }
        }
        Ok(())
    }
}

impl Stepper for Hinges {
    const LANES: usize = 1;

    fn reset(&mut self) {
        self.failure = None;
        self.build();
    }

    fn aim(&mut self, _: usize, servo: usize, target: f64) {
        let hinges = self.lowered.bodies.iter().skip(1).zip(&self.joints);
        for (body, &joint) in hinges.filter(|(body, _)| body.servo == servo) {
            if let Some(joint) = self.world.impulse_joints.get_mut(joint, false)
                && let Some(spec) = &body.hinge
            {
                let (stiffness, damping) = (spec.stiffness * TORQUE, spec.damping * TORQUE);
                joint.data.set_motor_position(
                    JointAxis::AngX,
                    target as f32,
                    stiffness as f32,
                    damping as f32,
                );
            }
        }
    }

    fn step(&mut self) {
        self.world.step();
        self.failure = self.failure.or(self.check().err());
        for hinge in 0..self.joints.len() {
            let angle = self.turn(hinge);
            let turned = angle - self.angles[hinge];
            self.work[hinge] += (self.torque(hinge, turned) * turned).max(0.0);
            self.angles[hinge] = angle;
        }
    }

    fn failure(&self, _: usize) -> Option<Invalid> {
        self.failure
    }

    fn pose(&self, _: usize, body: usize) -> Isometry3<f64> {
        let pose: Isometry3<f32> = (*self.body(body).position()).into();
        let mut pose: Isometry3<f64> = pose.cast();
        pose.translation.vector /= LENGTH;
        pose.rotation.renormalize();
        pose
    }

    fn angle(&self, _: usize, hinge: usize) -> f64 {
        self.angles[hinge]
    }

    fn work(&self, _: usize, hinge: usize) -> f64 {
        self.work[hinge]
    }
}

/// In rapier's own words and 32 bits.
pub(super) fn vector(v: Vector3<f64>) -> Vector {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

/// The ground, as everything that a robot may stand on.
pub(super) fn ground(settings: &Settings) -> Collider {
    ColliderBuilder::new(SharedShape::halfspace(Vector::Y))
        .friction(settings.ground_friction as f32)
        .friction_combine_rule(CoefficientCombineRule::GeometricMean)
        .collision_groups(InteractionGroups::new(GROUND, ROBOT, InteractionTestMode::And))
        .build()
}

/// So many substeps in a step, and what else rapier wants to know.
pub(super) fn parameters(settings: &Settings, substeps: usize) -> IntegrationParameters {
    IntegrationParameters {
        dt: settings.step as f32,
        num_solver_iterations: substeps,
        num_internal_pgs_iterations: settings.iterations,
        friction_model: FrictionModel::Coulomb,
        contact_recycling: false,
        ..IntegrationParameters::default()
    }
}

fn rigid_body(body: &Body) -> RigidBody {
    let m = (body.inertia * TORQUE).cast::<f32>();
    let columns: [[f32; 3]; 3] = m.into();
    let inertia = rapier3d::math::Matrix::from_cols_array_2d(&columns);
    let mass = MassProperties::with_inertia_matrix(Vector::ZERO, (body.mass * MASS) as f32, inertia);
    let mut own = RigidBodyBuilder::dynamic()
        .translation(vector(body.centre * LENGTH))
        .additional_mass_properties(mass)
        .can_sleep(false)
        .build();
    own.enable_gyroscopic_forces(true);
    own
}

fn collider(piece: &Piece, self_collision: bool) -> Collider {
    let size = |length: f64| (length * LENGTH) as f32;
    let mut local = piece.local;
    local.translation.vector *= LENGTH;
    let shape = match piece.shape {
        Shape::Box { half } => SharedShape::cuboid(size(half.x), size(half.y), size(half.z)),
        Shape::Ball { radius } => SharedShape::ball(size(radius)),
        Shape::Cylinder { radius, half_length } => {
            // rapier's cylinders stand on y: a quarter turn about z lays them on x.
            let half = std::f64::consts::FRAC_1_SQRT_2;
            let lay = nalgebra::Quaternion::new(half, 0.0, 0.0, -half);
            local.rotation *= UnitQuaternion::new_unchecked(lay);
            SharedShape::cylinder(size(half_length), size(radius))
        }
        Shape::Capsule { radius, half_straight } => SharedShape::capsule_x(size(half_straight), size(radius)),
    };
    let others = if self_collision { GROUND | ROBOT } else { GROUND };
    ColliderBuilder::new(shape)
        .position(local.cast::<f32>().into())
        .density(0.0)
        .friction(piece.friction as f32)
        .friction_combine_rule(CoefficientCombineRule::GeometricMean)
        .collision_groups(InteractionGroups::new(ROBOT, others, InteractionTestMode::And))
        .build()
}

fn revolute(hinge: &Hinge, parent: &Body, child: &Body) -> GenericJoint {
    let axis = vector(hinge.axis.into_inner());
    let anchor = |body: &Body| vector((hinge.anchor.coords - body.centre) * LENGTH);
    let (stiffness, damping) = ((hinge.stiffness * TORQUE) as f32, (hinge.damping * TORQUE) as f32);
    let mut joint = RevoluteJointBuilder::new(axis)
        .local_anchor1(anchor(parent))
        .local_anchor2(anchor(child))
        .contacts_enabled(false);
    if stiffness > 0.0 || damping > 0.0 {
        joint = joint
            .motor_model(MotorModel::ForceBased)
            .motor_position(0.0, stiffness, damping)
            .motor_max_force((hinge.torque * TORQUE).min(f64::from(f32::MAX)) as f32);
    }
    // Angles are known within half a turn; limits beyond cannot be felt.
    let (low, high) = hinge.limits;
    let half_turn = std::f64::consts::PI;
    if low > -half_turn || high < half_turn {
        joint = joint.limits([low.max(-half_turn) as f32, high.min(half_turn) as f32]);
    }
    joint.build().into()
}
