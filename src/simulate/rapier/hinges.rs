//! A rapier world with one robot and the ground.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::design::assembly::{Control, Dof, Shape, Travel};
use crate::simulate::articulated::colliding;
use crate::simulate::lowering::{Body, Lowered, Piece};
use crate::simulate::run::Stepper;
use crate::simulate::{Invalid, Settings};

/// A joint that is beyond its limits by more than this is not held, rad; of a slide, the share of its range.
const FAR: f64 = 0.2;
/// For longer than this, s, it is more than a blow.
const BEYOND: f64 = 0.1;
/// The work is the mean torque times the turn of stretches of so many seconds: light joints with stiff motors tremble from step
/// to step.
const STRETCH: f64 = 0.05;

/// What a joint did in some steps.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    /// The sum of its torques, N m, or its forces, N.
    effort: f64,
    /// How far it turned, rad, or slid, m.
    moved: f64,
    steps: u32,
}

impl Stretch {
    /// The positive work, J.
    fn work(self) -> f64 {
        (self.effort / f64::from(self.steps.max(1)) * self.moved).max(0.0)
    }
}

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

/// The elements that may touch each other, the later one first: the same as with the fast solver.
struct Colliding(BTreeSet<(usize, usize)>);

impl PhysicsHooks for Colliding {
    fn filter_contact_pair(&self, context: &PairFilterContext<'_>) -> Option<SolverFlags> {
        let element = |collider| context.colliders.get(collider).map(|collider| collider.user_data as usize);
        let is_ground = context.rigid_body1.is_none() || context.rigid_body2.is_none();
        let (a, b) = (element(context.collider1)?, element(context.collider2)?);
        (is_ground || self.0.contains(&(a.max(b), a.min(b)))).then_some(SolverFlags::COMPUTE_RIGID_IMPULSES)
    }
}

/// The world and how to make it anew.
pub(super) struct Hinges {
    lowered: Lowered,
    settings: Settings,
    colliding: Colliding,
    /// As the ground sees it, m/s^2.
    gravity: Vector3<f64>,
    /// How many substeps a step is cut into.
    substeps: usize,
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    joints: Vec<ImpulseJointHandle>,
    /// The ground, then each element.
    colliders: Vec<ColliderHandle>,
    /// Where each joint stands, rad or m, without jumps at half a turn.
    positions: Vec<f64>,
    /// Work done at each joint so far, J.
    work: Vec<f64>,
    /// What each joint did in the present stretch of time.
    open: Vec<Stretch>,
    /// For how long a joint has been beyond its limits, s.
    beyond: f64,
    failure: Option<Invalid>,
}

impl Hinges {
    /// At rest.
    pub(super) fn new(lowered: &Lowered, settings: &Settings, gravity: Vector3<f64>, substep: f64) -> Self {
        let mut own = Self {
            lowered: lowered.clone(),
            settings: settings.clone(),
            colliding: Colliding(colliding(lowered).into_iter().collect()),
            gravity,
            substeps: (settings.step / substep - 1e-6).ceil().max(1.0) as usize,
            world: PhysicsWorld::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            colliders: Vec::new(),
            positions: Vec::new(),
            work: Vec::new(),
            open: Vec::new(),
            beyond: 0.0,
            failure: None,
        };
        own.build();
        own
    }

    fn build(&mut self) {
        self.world = PhysicsWorld::new();
        self.world.gravity = vector(self.gravity * LENGTH);
        self.world.integration_parameters = parameters(&self.settings, self.substeps);
        self.colliders = vec![self.world.colliders.insert(ground(&self.settings))];
        let Hinges { world, lowered, .. } = self;
        let bodies = (0..lowered.bodies.len()).map(|body| rigid_body(&with_mass(lowered, body)));
        self.bodies = bodies.map(|body| world.bodies.insert(body)).collect();
        for (number, piece) in lowered.pieces.iter().enumerate() {
            let collider = collider(number, piece, self.settings.self_collision);
            let handle =
                world.colliders.insert_with_parent(collider, self.bodies[piece.body], &mut world.bodies);
            self.colliders.push(handle);
        }
        self.joints.clear();
        for (index, body) in lowered.bodies.iter().enumerate().skip(1) {
            let Some(dof) = &body.dof else { continue };
            let joint = joint(dof, &lowered.bodies[body.parent], body);
            let (parent, child) = (self.bodies[body.parent], self.bodies[index]);
            self.joints.push(world.impulse_joints.insert(parent, child, joint, true));
        }
        self.positions = vec![0.0; self.joints.len()];
        self.work = vec![0.0; self.joints.len()];
        self.open = vec![Stretch::default(); self.joints.len()];
        self.beyond = 0.0;
    }

    fn body(&self, body: usize) -> &RigidBody {
        &self.world.bodies[self.bodies[body]]
    }

    /// Where a joint stands, rad or m, from the poses of its bodies; an angle nearest to its last one.
    fn stands(&self, joint: usize) -> f64 {
        let own = &self.lowered.bodies[joint + 1];
        let Some(dof) = &own.dof else { return 0.0 };
        let (parent, child) = (self.pose(0, own.parent), self.pose(0, joint + 1));
        match dof.travel {
            Travel::Turn => {
                let relative = parent.rotation.inverse() * child.rotation;
                let angle = 2.0 * libm::atan2(relative.imag().dot(&dof.axis), relative.w);
                let turns = ((angle - self.positions[joint]) / std::f64::consts::TAU).round();
                angle - turns * std::f64::consts::TAU
            }
            Travel::Slide => {
                let rest = own.centre - self.lowered.bodies[own.parent].centre;
                let way = parent.rotation.inverse() * (child.translation.vector - parent.translation.vector);
                (way - rest).dot(&dof.axis)
            }
        }
    }

    /// How fast a joint moves, rad/s or m/s.
    fn speed(&self, joint: usize) -> f64 {
        let own = &self.lowered.bodies[joint + 1];
        let Some(dof) = &own.dof else { return 0.0 };
        let (parent, child) = (self.body(own.parent), self.body(joint + 1));
        let axis = parent.rotation() * vector(dof.axis.into_inner());
        f64::from(match dof.travel {
            Travel::Turn => (child.angvel() - parent.angvel()).dot(axis),
            Travel::Slide => {
                let between = child.translation() - parent.translation();
                let carried = parent.linvel() + parent.angvel().cross(between);
                (child.linvel() - carried).dot(axis) / LENGTH as f32
            }
        })
    }

    /// The mean torque (or force) of a joint's motor over the last step, in which the
    /// joint moved by so much, N m or N.
    ///
    /// rapier tells the impulse of the last substep only (that on the parent).
    /// A motor that is not at its limit had, on average, as much more or less as
    /// its position and speed differed from those of the end.
    fn effort(&self, joint: usize, moved: f64) -> f64 {
        let own = &self.lowered.bodies[joint + 1];
        let handle = self.world.impulse_joints.get(self.joints[joint]);
        let (Some(handle), Some(dof)) = (handle, &own.dof) else { return 0.0 };
        let step = self.settings.step;
        let impulse = f64::from(handle.data.motors[axis_of(dof.travel) as usize].impulse);
        let last = -impulse * self.substeps as f64 / step / effort_here(dof.travel);
        if last.abs() > 0.999 * dof.effort {
            return last;
        }
        let stiffness = if dof.is_spun() { 0.0 } else { dof.stiffness };
        let change = stiffness * moved / 2.0 + dof.damping * (self.speed(joint) - moved / step);
        (last + change).clamp(-dof.effort, dof.effort)
    }

    /// Refuses numbers that are not finite, elements beyond the speed limit, and joints that stay beyond theirs.
    fn check(&self) -> Result<(), Invalid> {
        if self.beyond > BEYOND {
            return Err(Invalid::BeyondLimits);
        }
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
        let joints = self.lowered.bodies.iter().skip(1).zip(&self.joints);
        for (body, &joint) in joints.filter(|(body, _)| body.servo == servo) {
            if let Some(joint) = self.world.impulse_joints.get_mut(joint, false)
                && let Some(dof) = &body.dof
            {
                drive(&mut joint.data, dof, target);
            }
        }
    }

    fn step(&mut self) {
        self.world.step_with_events(&self.colliding, &());
        self.failure = self.failure.or(self.check().err());
        let mut is_beyond = false;
        for joint in 0..self.joints.len() {
            let position = self.stands(joint);
            let moved = position - self.positions[joint];
            // What a spring gives back is no work that is done for it.
            let dof = self.lowered.bodies[joint + 1].dof.as_ref();
            if dof.is_some_and(|dof| dof.actuator().is_some()) {
                let effort = self.effort(joint, moved);
                let open = &mut self.open[joint];
                *open = Stretch {
                    effort: open.effort + effort,
                    moved: open.moved + moved,
                    steps: open.steps + 1,
                };
                if f64::from(open.steps) * self.settings.step >= STRETCH {
                    self.work[joint] += std::mem::take(open).work();
                }
            }
            is_beyond |= dof.is_some_and(|dof| {
                let far = match dof.travel {
                    Travel::Turn => FAR,
                    Travel::Slide => FAR * (dof.limits.1 - dof.limits.0),
                };
                position < dof.limits.0 - far || position > dof.limits.1 + far
            });
            self.positions[joint] = position;
        }
        self.beyond = if is_beyond { self.beyond + self.settings.step } else { 0.0 };
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

    fn position(&self, _: usize, joint: usize) -> f64 {
        let dof = self.lowered.bodies[joint + 1].dof.as_ref();
        if dof.is_some_and(Dof::is_spun) { self.speed(joint) } else { self.positions[joint] }
    }

    fn work(&self, _: usize, joint: usize) -> f64 {
        self.work[joint] + self.open[joint].work()
    }

    fn rate(&self, _: usize, joint: usize) -> Option<f64> {
        Some(self.speed(joint))
    }

    fn velocity(&self, _: usize, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let body = self.body(body);
        let vector = |v: Vector| Vector3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z));
        Some((vector(body.linvel()) / LENGTH, vector(body.angvel())))
    }

    fn load(&self, _: usize, element: usize) -> Option<f64> {
        let ground = *self.colliders.first()?;
        let pair = self.world.contact_pair(ground, *self.colliders.get(element + 1)?);
        // Of contacts rapier tells the impulse of the whole step, other than of motors.
        let impulse = pair.map_or(0.0, |pair| f64::from(pair.total_impulse_magnitude()));
        Some(impulse / self.settings.step / (MASS * LENGTH))
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
        // By default rapier slows down what is faster than 400 of its units per second, here centimetres. Our own limit refuses it.
        normalized_max_linear_velocity: f32::MAX,
        ..IntegrationParameters::default()
    }
}

/// Principal moments of inertia that are equal are set apart by this share, either way.
///
/// rapier adds up the inertia of a body and of its colliders, and looks for the principal axes of the sum
/// (`symmetric_eigen` of glamx 0.3.1). Where the least two of its moments are equal, as those of a disc are, it takes x
/// for one of their axes, whatever it is.
const APART: f64 = 1e-3;

/// The mass of a body with its principal axes.
fn mass_of(body: &Body) -> MassProperties {
    let eigen = (body.inertia * TORQUE).symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let moments = Vector3::new(1.0 - APART, 1.0, 1.0 + APART).component_mul(&eigen.eigenvalues);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let turn = Rotation::from_xyzw(turn.i as f32, turn.j as f32, turn.k as f32, turn.w as f32).normalize();
    let mass = (body.mass * MASS) as f32;
    MassProperties::with_principal_inertia_frame(Vector::ZERO, mass, vector(moments), turn)
}

/// What lies between two degrees of freedom has no mass; here it needs some: this share of what hangs on it.
const RING: f64 = 0.02;

/// A body as it is here: with a mass.
fn with_mass(lowered: &Lowered, index: usize) -> Body {
    let mut body = lowered.bodies[index].clone();
    // Bodies are numbered depth first: what hangs on it comes next.
    let mut on_it = lowered.bodies.iter().skip(index).filter(|body| !body.is_massless());
    if body.is_massless()
        && let Some(next) = on_it.next()
    {
        (body.mass, body.inertia) = (next.mass * RING, next.inertia * RING);
    }
    body
}

fn rigid_body(body: &Body) -> RigidBody {
    let mut own = RigidBodyBuilder::dynamic()
        .translation(vector(body.centre * LENGTH))
        .additional_mass_properties(mass_of(body))
        .can_sleep(false)
        .build();
    own.enable_gyroscopic_forces(true);
    own
}

fn collider(number: usize, piece: &Piece, self_collision: bool) -> Collider {
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
        .user_data(number as u128)
        .active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS)
        .friction(piece.friction as f32)
        .friction_combine_rule(CoefficientCombineRule::GeometricMean)
        .collision_groups(InteractionGroups::new(ROBOT, others, InteractionTestMode::And))
        .build()
}

/// What rapier calls the axis of a joint.
fn axis_of(travel: Travel) -> JointAxis {
    match travel {
        Travel::Turn => JointAxis::AngX,
        Travel::Slide => JointAxis::LinX,
    }
}

/// g cm^2/s^2 per N m, or g cm/s^2 per N.
fn effort_here(travel: Travel) -> f64 {
    match travel {
        Travel::Turn => TORQUE,
        Travel::Slide => TORQUE / LENGTH,
    }
}

/// cm per m of a position that is a distance.
fn position_here(travel: Travel) -> f64 {
    match travel {
        Travel::Turn => 1.0,
        Travel::Slide => LENGTH,
    }
}

/// Whether anything pushes a joint: to rapier, a motor without stiffness and damping is one that locks it.
fn has_motor(dof: &Dof) -> bool {
    dof.stiffness > 0.0 || dof.damping > 0.0
}

/// Sets what a joint is asked for: a position in rad or m, or a speed in rad/s.
fn drive(joint: &mut GenericJoint, dof: &Dof, target: f64) {
    if !has_motor(dof) {
        return;
    }
    let scale = effort_here(dof.travel) / position_here(dof.travel);
    let (stiffness, damping) = ((dof.stiffness * scale) as f32, (dof.damping * scale) as f32);
    let (axis, target) = (axis_of(dof.travel), (target * position_here(dof.travel)) as f32);
    match dof.control {
        Control::Speed { .. } => joint.set_motor_velocity(axis, target, damping),
        Control::Position { .. } | Control::Passive { .. } => {
            joint.set_motor_position(axis, target, stiffness, damping)
        }
    };
}

fn joint(dof: &Dof, parent: &Body, child: &Body) -> GenericJoint {
    let axis = vector(dof.axis.into_inner());
    let anchor = |body: &Body| vector((dof.anchor.coords - body.centre) * LENGTH);
    let free = match dof.travel {
        Travel::Turn => JointAxesMask::LOCKED_REVOLUTE_AXES,
        Travel::Slide => JointAxesMask::LOCKED_PRISMATIC_AXES,
    };
    let mut joint = GenericJointBuilder::new(free)
        .local_axis1(axis)
        .local_axis2(axis)
        .local_anchor1(anchor(parent))
        .local_anchor2(anchor(child));
    let which = axis_of(dof.travel);
    if has_motor(dof) {
        let most = (dof.effort * effort_here(dof.travel)).min(f64::from(f32::MAX)) as f32;
        joint = joint.motor_model(which, MotorModel::ForceBased).motor_max_force(which, most);
    }
    // Angles are known within half a turn; limits beyond cannot be felt.
    let (low, high) = dof.limits;
    let most = match dof.travel {
        Travel::Turn => std::f64::consts::PI,
        Travel::Slide => 1e3,
    };
    if low > -most || high < most {
        let here = |end: f64| (end.clamp(-most, most) * position_here(dof.travel)) as f32;
        joint = joint.limits(which, [here(low), here(high)]);
    }
    let mut joint = joint.build();
    drive(&mut joint, dof, 0.0);
    joint
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion, Vector3};

    use super::{Hinges, MASS, TORQUE};
    use crate::design::assembly::{Assembly, Element, Shape};
    use crate::simulate::lowering::Lowered;
    use crate::simulate::run::Stepper;
    use crate::simulate::tests::bodies::element;
    use crate::simulate::tests::settings;

    /// Whatever its principal moments and axes, a body has the inertia that its elements have.
    #[test]
    fn bodies_have_their_inertia() {
        let shapes = [
            Shape::Cylinder { radius: 0.03, half_length: 0.004 },
            Shape::Cylinder { radius: 0.01, half_length: 0.02 },
            Shape::Box { half: Vector3::new(0.01, 0.02, 0.03) },
            Shape::Ball { radius: 0.01 },
        ];
        for shape in shapes {
            for turn in [Vector3::zeros(), Vector3::z() * 1.3, Vector3::new(0.3, -1.0, 0.2)] {
                let pose = Isometry3::from_parts(Vector3::zeros().into(), UnitQuaternion::new(turn));
                let one: Element = element(shape, pose);
                let body = Assembly { elements: vec![one], ..Assembly::default() };
                let lowered = Lowered::new(&body, &settings()).unwrap();
                let mut world = Hinges::new(&lowered, &settings(), Vector3::zeros(), 1e-3);
                world.step();
                let kept = world.body(0).mass_properties().local_mprops;
                let due = lowered.bodies[0].inertia * TORQUE;
                let columns = kept.reconstruct_inertia_matrix().to_cols_array_2d();
                for (column, entries) in columns.iter().enumerate() {
                    for (row, &entry) in entries.iter().enumerate() {
                        let off = (f64::from(entry) - due[(row, column)]).abs();
                        assert!(off < 3e-3 * due.norm(), "{shape:?}, {turn}: {columns:?} for {due}");
                    }
                }
                let mass = lowered.bodies[0].mass * MASS;
                assert!((f64::from(kept.mass()) / mass - 1.0).abs() < 1e-5);
            }
        }
    }
}
