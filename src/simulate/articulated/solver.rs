//! One time step of a tree.

use super::bias::{Wrench, bias};
use super::collide::{Collisions, reaches};
use super::factor::Factor;
use super::ground::{Ground, top_speed};
use super::inertia::{Composite, mass_matrix, turn_inertias};
use super::joints::Joints;
use super::kinematics::{Frame, State, Velocity, move_on, place};
use super::pgs;
use super::rows::{Rows, Touch};
use super::scalar::Scalar;
use super::tree::{LENGTH, ROOT, Tree};
use super::vector::{Sym, V3, add, apply, cross, dot};
use crate::simulate::lowering::Lowered;
use crate::simulate::{Invalid, Settings};

/// Overlap in cm that is left alone, so that resting contacts stay contacts.
const SLOP: f64 = 0.002;
/// The share of an overlap that one step mends.
const MEND: f64 = 0.2;
/// Fastest mending in cm/s: a deep overlap must not become a jump.
const MEND_SPEED: f64 = 20.0;
/// Gap in cm below which a point is a contact even when all is still.
const MARGIN: f64 = 0.02;

/// Times a step is solved at most while servos come to or leave their limits.
const PASSES: usize = 4;
/// Number of the first step: none of the slots was used in the one before.
const FIRST: u32 = 2;

/// A tree, its surroundings and all room that a step needs.
#[derive(Clone, Debug)]
pub(super) struct Solver<S> {
    pub(super) tree: Tree<S>,
    pub(super) state: State<S>,
    pub(super) frames: Vec<Frame<S>>,
    /// cm/s^2.
    pub(super) gravity: V3<S>,
    /// Whether the root cannot move; only tests hold it.
    pub(super) anchored: bool,
    /// Servo targets by body, rad.
    pub(super) targets: Vec<S>,
    pub(super) ground: Option<Ground<S>>,
    collisions: Option<Collisions<S>>,
    start: State<S>,
    step: S,
    iterations: usize,
    speed_limit: S,
    /// Body and place in it of every element, to check speeds.
    centres: Vec<(usize, V3<S>)>,
    reach: Vec<S>,
    /// How the bodies would move on without contacts: servos accelerate light
    /// limbs so much within a step that the present speed says little.
    ahead: Vec<Velocity<S>>,
    /// The greater of present speed and that, for any point of each body.
    tops: Vec<S>,
    inertias: Vec<Sym<S>>,
    composites: Vec<Composite<S>>,
    wrenches: Vec<Wrench<S>>,
    /// The mass matrix.
    h: Vec<S>,
    factor: Factor<S>,
    pub(super) joints: Joints<S>,
    touches: Vec<Touch<S>>,
    rows: Rows<S>,
    /// Impulse of each slot and the step in which it was given.
    memory: Vec<(V3<S>, u32)>,
    now: u32,
    impulses: Vec<S>,
    y: Vec<S>,
    free: Vec<S>,
}

impl<S: Scalar> Solver<S> {
    /// At rest.
    pub(super) fn new(lowered: &Lowered, settings: &Settings) -> Self {
        let tree = Tree::new(lowered);
        let centre = lowered.bodies[0].centre * LENGTH;
        let state = State::new(&tree, [S::of(centre.x), S::of(centre.y), S::of(centre.z)]);
        let mut frames = vec![Frame::default(); tree.links.len()];
        place(&tree, &state, &mut frames);
        let ground = Ground::new(lowered, settings.ground_friction);
        let collisions = settings.self_collision.then(|| Collisions::new(lowered, &frames));
        let slots = ground.slots + collisions.as_ref().map_or(0, Collisions::slots);
        // More than stand on the ground at once; it grows if it must.
        let contacts = 16 + 4 * lowered.pieces.len();
        let (bodies, dofs) = (tree.links.len(), vec![S::ZERO; tree.dofs()]);
        let centres = lowered.pieces.iter().map(|piece| {
            let centre = piece.local.translation.vector * LENGTH;
            (piece.body, [S::of(centre.x), S::of(centre.y), S::of(centre.z)])
        });
        Self {
            gravity: [S::ZERO, S::of(-settings.gravity * LENGTH), S::ZERO],
            anchored: false,
            targets: vec![S::ZERO; bodies],
            start: state.clone(),
            step: S::of(settings.step),
            iterations: settings.iterations,
            speed_limit: S::of(settings.speed_limit * LENGTH),
            centres: centres.collect(),
            reach: reaches(lowered),
            ahead: vec![Velocity::default(); bodies],
            tops: vec![S::ZERO; bodies],
            inertias: vec![Sym::default(); bodies],
            composites: vec![Composite::default(); bodies],
            wrenches: vec![Wrench::default(); bodies],
            h: vec![S::ZERO; tree.entries],
            factor: Factor::new(&tree),
            joints: Joints::new(&tree),
            touches: Vec::with_capacity(contacts),
            rows: Rows::new(&tree, contacts),
            memory: vec![([S::ZERO; 3], 0); slots],
            now: FIRST,
            impulses: dofs.clone(),
            y: dofs.clone(),
            free: dofs,
            ground: Some(ground),
            collisions,
            frames,
            state,
            tree,
        }
    }

    /// Back to the state at rest, bit for bit.
    pub(super) fn reset(&mut self) {
        self.state.copy_from(&self.start);
        self.joints.reset();
        self.memory.fill(([S::ZERO; 3], 0));
        self.now = FIRST;
        if let Some(collisions) = &mut self.collisions {
            collisions.reset();
        }
        place(&self.tree, &self.state, &mut self.frames);
    }

    /// Moves on by one step. The frames always belong to the state.
    pub(super) fn advance(&mut self) -> Result<(), Invalid> {
        self.assemble();
        for pass in 0..PASSES {
            self.release();
            if pass == 0 {
                self.touch();
            }
            self.constrain();
            if !self.joints.review(&self.free, pass == 0) {
                break;
            }
        }
        self.now += 1;
        self.state.speeds.copy_from_slice(&self.free);
        self.state.advance(self.step);
        place(&self.tree, &self.state, &mut self.frames);
        self.check()
    }

    /// Fills H and the impulses of all forces but the servos'.
    fn assemble(&mut self) {
        let Self { tree, state, frames, inertias, h, impulses, .. } = self;
        turn_inertias(tree, frames, inertias);
        mass_matrix(tree, frames, inertias, &mut self.composites, h);
        bias(tree, &state.speeds, self.gravity, frames, inertias, &mut self.wrenches, impulses);
        for impulse in impulses.iter_mut() {
            *impulse *= self.step;
        }
        if self.anchored {
            for dof in 0..ROOT {
                h[tree.rows[dof] + dof] += S::of(1e20);
            }
        }
        self.joints.prepare(tree, state, &self.targets, self.step);
    }

    /// Adds the servos, factorises, and finds y and the speeds as they would
    /// be without contacts.
    fn release(&mut self) {
        let Self { tree, state, factor, joints, y, free, .. } = self;
        factor.rows.copy_from_slice(&self.h);
        free.copy_from_slice(&self.impulses);
        joints.drive(tree, state, &mut factor.rows, free);
        factor.factorise(tree);
        factor.transform(tree, &state.speeds, free, y);
        factor.restore(tree, y, free);
        joints.collect(tree, state, factor, free, self.step);
    }

    /// Finds the points that may touch within the step.
    fn touch(&mut self) {
        let Self { tree, frames, touches, .. } = self;
        let step = self.step;
        touches.clear();
        move_on(tree, frames, &self.free, &mut self.ahead);
        for (body, top) in self.tops.iter_mut().enumerate() {
            let (now, ahead) = (&frames[body], &self.ahead[body]);
            let reach = self.reach[body];
            *top = top_speed(now.spin, now.velocity, reach).max(top_speed(ahead.spin, ahead.velocity, reach));
        }
        let still = S::of(MARGIN) + dot(self.gravity, self.gravity).sqrt() * step * step;
        let mut slots = 0;
        if let Some(ground) = &self.ground {
            slots = ground.slots;
            let tops = &self.tops;
            ground.find(
                &self.state,
                frames,
                |body| still + tops[body] * step,
                |c| {
                    let allowance = allowance(c.gap, step);
                    touches.push(Touch {
                        allowance,
                        point: c.point,
                        friction: c.friction,
                        slot: c.slot,
                        body: c.body,
                        other: None,
                    });
                },
            );
        }
        if let Some(collisions) = &mut self.collisions {
            collisions.find(frames, &self.ahead, step, |m| {
                touches.push(Touch {
                    allowance: allowance(m.gap, step),
                    point: m.point,
                    friction: m.friction,
                    slot: slots + m.slot,
                    body: m.bodies.0,
                    other: Some((m.bodies.1, m.normal)),
                });
            });
        }
    }

    /// Makes the rows of the contacts, solves limits and contacts, and
    /// remembers their impulses; leaves the speeds in `free`.
    fn constrain(&mut self) {
        let Self { tree, frames, factor, joints, rows, y, memory, .. } = self;
        rows.clear();
        for touch in &self.touches {
            rows.push(tree, frames, factor, touch);
            let (impulse, when) = memory[touch.slot];
            if let Some(contact) = rows.contacts.last_mut()
                && when + 1 >= self.now
            {
                contact.impulse = impulse;
            }
        }
        joints.warm_start(y);
        pgs::warm_start(rows, y);
        for _ in 0..self.iterations {
            joints.sweep(y);
            pgs::sweep(rows, y);
        }
        for contact in &rows.contacts {
            memory[contact.slot] = (contact.impulse, self.now);
        }
        factor.restore(tree, y, &mut self.free);
        joints.remember();
    }

    /// Refuses numbers that are not finite, and elements beyond the limit.
    fn check(&self) -> Result<(), Invalid> {
        let root = self.state.position;
        if !(dot(root, root).to_f64().is_finite()) {
            return Err(Invalid::NotFinite);
        }
        for (frame, &reach) in self.frames.iter().zip(&self.reach) {
            // Only a body that might be too fast has its elements looked at.
            if top_speed(frame.spin, frame.velocity, reach) < self.speed_limit {
                continue;
            }
            if !dot(frame.velocity, frame.velocity).to_f64().is_finite() {
                return Err(Invalid::NotFinite);
            }
            return self.check_elements();
        }
        Ok(())
    }

    fn check_elements(&self) -> Result<(), Invalid> {
        for &(body, centre) in &self.centres {
            let frame = &self.frames[body];
            let arm = apply(&frame.rotation, centre);
            let velocity = add(frame.velocity, cross(frame.spin, arm));
            let speed = dot(velocity, velocity).sqrt();
            if !speed.to_f64().is_finite() {
                return Err(Invalid::NotFinite);
            }
            if speed > self.speed_limit {
                return Err(Invalid::TooFast);
            }
        }
        Ok(())
    }

    /// Kinetic energy of all bodies plus their potential energy, erg.
    #[cfg(test)]
    pub(super) fn energy(&self) -> f64 {
        use super::vector::{apply_sym, apply_transposed};
        let mut sum = 0.0;
        for (frame, link) in self.frames.iter().zip(&self.tree.links) {
            let spin = apply_transposed(&frame.rotation, frame.spin);
            let turning = dot(spin, apply_sym(&link.inertia, spin)).to_f64();
            let moving = dot(frame.velocity, frame.velocity).to_f64() * link.mass.to_f64();
            let place = add(self.state.position, frame.centre);
            sum += 0.5 * (turning + moving) - dot(self.gravity, place).to_f64() * link.mass.to_f64();
        }
        sum
    }
}

/// The velocity that closes a gap in one step, or minus that which mends an
/// overlap.
#[inline(always)]
fn allowance<S: Scalar>(gap: S, step: S) -> S {
    if gap >= S::ZERO {
        return gap / step;
    }
    let deep = (-gap - S::of(SLOP)).max(S::ZERO);
    -(deep * S::of(MEND) / step).min(S::of(MEND_SPEED))
}
