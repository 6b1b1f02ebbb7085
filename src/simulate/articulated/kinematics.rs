//! Where every body is and how it moves, from the state of the tree.

use std::f64::consts::PI;

use super::scalar::Scalar;
use super::tree::{Link, ROOT, Tree, dof_of};
use super::vector::{M3, Quat, V3};
use crate::design::assembly::Travel;

/// The state of a tree.
#[derive(Clone, Debug)]
pub(super) struct State<S> {
    /// Centre of the root in the world, cm.
    pub(super) position: V3<S>,
    /// Centre of mass of the whole in the world, cm.
    pub(super) centre: V3<S>,
    /// What rounding has so far cut off that (Kahan's summation):
    /// a slow robot far from the origin moves by less than a rounding per step.
    pub(super) lost: V3<S>,
    /// Rotation of the root.
    pub(super) rotation: Quat<S>,
    /// Positions of the joints by body, rad or cm; that of the root is not used. What spins is within half a turn.
    pub(super) positions: Vec<S>,
    /// Velocities by degree of freedom, rad/s and cm/s.
    pub(super) speeds: Vec<S>,
}

impl<S: Scalar> State<S> {
    /// At rest, the root's centre at a place and turned.
    pub(super) fn new(tree: &Tree<S>, position: V3<S>, rotation: Quat<S>) -> Self {
        let kit = tree.kit;
        Self {
            position,
            centre: position,
            lost: V3::null(kit),
            rotation,
            positions: vec![S::zero(kit); tree.links.len()],
            speeds: vec![S::zero(kit); tree.dofs()],
        }
    }

    /// Becomes a copy of another state of the same tree, without allocating.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.position = other.position;
        self.centre = other.centre;
        self.lost = other.lost;
        self.rotation = other.rotation;
        self.positions.copy_from_slice(&other.positions);
        self.speeds.copy_from_slice(&other.speeds);
    }

    /// Turns the root and moves the joints for a time with the present velocities.
    #[inline(always)]
    pub(super) fn turn(&mut self, tree: &Tree<S>, step: S) {
        let v = &self.speeds;
        self.rotation = self.rotation.turned(V3([v[0], v[1], v[2]]) * step);
        for body in 1..self.positions.len() {
            self.positions[body] += v[dof_of(body)] * step;
        }
        for &body in &tree.endless {
            // A wheel keeps its precision however far it rolls.
            let position = self.positions[body];
            let [half, whole, none] = [PI, 2.0 * PI, 0.0].map(|angle| step.like(angle));
            let back = S::pick(half.less(position), whole, S::pick(position.less(-half), -whole, none));
            self.positions[body] = position - back;
        }
    }
}

/// Pose and velocity of one body. Places are relative to the root's centre,
/// axes are the world's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<S> {
    /// Rotation from rest.
    pub(super) rotation: M3<S>,
    /// Centre of mass.
    pub(super) centre: V3<S>,
    /// A point on the axis of the joint that carries it, which moves with the body; for the root its centre.
    pub(super) anchor: V3<S>,
    /// The axis.
    pub(super) axis: V3<S>,
    /// Angular velocity.
    pub(super) spin: V3<S>,
    /// Velocity of the centre of mass.
    pub(super) velocity: V3<S>,
}

impl<S: Scalar> Frame<S> {
    /// Nowhere in particular.
    pub(super) fn null(kit: S::Kit) -> Self {
        let zero = V3::null(kit);
        Self { rotation: M3([zero; 3]), centre: zero, anchor: zero, axis: zero, spin: zero, velocity: zero }
    }
}

impl<S: Scalar> Frame<S> {
    /// The velocity of a point of the body, or of what hangs on it, that unit speed of its joint gives.
    #[inline(always)]
    pub(super) fn moves(&self, travel: Travel, point: V3<S>) -> V3<S> {
        match travel {
            Travel::Turn => self.axis.cross(point - self.anchor),
            Travel::Slide => self.axis,
        }
    }
}

/// Computes the frames of all bodies.
#[inline(always)]
pub(super) fn place<S: Scalar>(tree: &Tree<S>, state: &State<S>, frames: &mut [Frame<S>]) {
    let v = &state.speeds;
    let zero = V3::null(tree.kit);
    frames[0] = Frame {
        rotation: state.rotation.matrix(),
        centre: zero,
        anchor: zero,
        axis: zero,
        spin: V3([v[0], v[1], v[2]]),
        velocity: V3([v[3], v[4], v[5]]),
    };
    for (body, link) in tree.links.iter().enumerate().skip(1) {
        let parent = frames[link.parent];
        let rate = v[body + ROOT - 1];
        if tree.travels[body] == Travel::Slide {
            frames[body] = slid(link, &parent, state.positions[body], rate);
            continue;
        }
        let rotation = parent.rotation * M3::rotation(link.axis, state.positions[body]);
        let axis = parent.rotation * link.axis;
        let to_joint = parent.rotation * link.to_joint;
        let to_centre = rotation * link.to_centre;
        let anchor = parent.centre + to_joint;
        let spin = parent.spin + axis * rate;
        let velocity = parent.velocity + parent.spin.cross(to_joint) + spin.cross(to_centre);
        frames[body] = Frame { rotation, centre: anchor + to_centre, anchor, axis, spin, velocity };
    }
}

/// The frame of a body that slides.
#[inline(always)]
fn slid<S: Scalar>(link: &Link<S>, parent: &Frame<S>, position: S, rate: S) -> Frame<S> {
    let (rotation, spin) = (parent.rotation, parent.spin);
    let axis = rotation * link.axis;
    let to_anchor = rotation * link.to_joint + axis * position;
    let to_centre = rotation * link.to_centre;
    let anchor = parent.centre + to_anchor;
    let velocity = parent.velocity + spin.cross(to_anchor + to_centre) + axis * rate;
    Frame { rotation, centre: anchor + to_centre, anchor, axis, spin, velocity }
}

/// Velocity of one body, world axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Velocity<S> {
    /// Angular velocity.
    pub(super) spin: V3<S>,
    /// Velocity of the centre of mass.
    pub(super) velocity: V3<S>,
}

impl<S: Scalar> Velocity<S> {
    /// At rest.
    #[inline(always)]
    pub(super) fn null(kit: S::Kit) -> Self {
        Self { spin: V3::null(kit), velocity: V3::null(kit) }
    }

    /// That of a frame.
    #[inline(always)]
    pub(super) fn of(frame: &Frame<S>) -> Self {
        Self { spin: frame.spin, velocity: frame.velocity }
    }
}

/// Computes the velocities that other speeds would give to the bodies where
/// they are.
#[inline(always)]
pub(super) fn move_on<S: Scalar>(
    tree: &Tree<S>,
    frames: &[Frame<S>],
    speeds: &[S],
    moves: &mut [Velocity<S>],
) {
    let v = speeds;
    moves[0] = Velocity { spin: V3([v[0], v[1], v[2]]), velocity: V3([v[3], v[4], v[5]]) };
    for (body, link) in tree.links.iter().enumerate().skip(1) {
        let (frame, parent) = (&frames[body], moves[link.parent]);
        let own = frame.axis * speeds[dof_of(body)];
        let to_anchor = frame.anchor - frames[link.parent].centre;
        let mut spin = parent.spin;
        let mut at_anchor = parent.velocity + parent.spin.cross(to_anchor);
        match tree.travels[body] {
            Travel::Turn => spin += own,
            Travel::Slide => at_anchor += own,
        }
        let velocity = at_anchor + spin.cross(frame.centre - frame.anchor);
        moves[body] = Velocity { spin, velocity };
    }
}
