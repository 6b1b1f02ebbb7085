//! How far a step takes every body: in a step a joint turns by its speed times the step, and a limb goes round a
//! curve, so that its mean velocity is not that which the speeds mean at the beginning.
//!
//! With momenta as mass times the way in a step, forces and constraints where the step begins, the scheme is the
//! variational one of SHAKE (Ryckaert et al. 1977; Leimkuhler and Reich, Simulating Hamiltonian Dynamics, 2004,
//! section 7.2) in coordinates that obey the constraints; for rotations it is that of Moser and Veselov (1991). It
//! is of second order, and keeps momenta exactly and energy for ever, but for an error that does not grow.

use super::kinematics::{Frame, Velocity};
use super::scalar::Scalar;
use super::tree::{Tree, dof_of};
use super::vector::{M3, Sym, V3};
use crate::design::assembly::Travel;

/// What the means over a step have beyond that which the speeds mean where it begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stride<S> {
    /// Velocity of the centre of mass, cm/s.
    pub(super) shift: V3<S>,
    /// Angular velocity, rad/s.
    pub(super) turn: V3<S>,
    /// Angular momentum about the centre, g cm^2/s.
    pub(super) spin: V3<S>,
}

impl<S: Scalar> Stride<S> {
    /// Nothing.
    pub(super) fn null(kit: S::Kit) -> Self {
        let zero = V3::null(kit);
        Self { shift: zero, turn: zero, spin: zero }
    }

    /// What comes after this one if it came after another: the same again in lanes that are wild.
    #[inline(always)]
    pub(super) fn beyond(&self, before: &Self, wild: S::Mask) -> Self {
        Self {
            shift: onwards::<S>(wild, self.shift, before.shift),
            turn: onwards::<S>(wild, self.turn, before.turn),
            spin: onwards::<S>(wild, self.spin, before.spin),
        }
    }

    /// Takes over another one in some lanes.
    #[inline(always)]
    pub(super) fn take(&mut self, lanes: S::Mask, other: &Self) {
        self.shift = V3::pick(lanes, other.shift, self.shift);
        self.turn = V3::pick(lanes, other.turn, self.turn);
        self.spin = V3::pick(lanes, other.spin, self.spin);
    }
}

/// What comes after a vector if it came after another: the same again where it is wild.
#[inline(always)]
fn onwards<S: Scalar>(wild: S::Mask, now: V3<S>, before: V3<S>) -> V3<S> {
    now + V3::pick(wild, V3::null(now.kit()), now - before)
}

/// A body's way in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way<S> {
    /// Its rotation less one.
    turn: M3<S>,
    /// The way of its centre.
    shift: V3<S>,
    /// Mean velocity of the centre.
    pub(super) velocity: V3<S>,
    /// Mean angular velocity.
    pub(super) spin: V3<S>,
    /// Angular momentum about the centre.
    pub(super) momentum: V3<S>,
}

impl<S: Scalar> Way<S> {
    /// None.
    pub(super) fn null(kit: S::Kit) -> Self {
        let zero = V3::null(kit);
        Self { turn: M3([zero; 3]), shift: zero, velocity: zero, spin: zero, momentum: zero }
    }

    /// Kinetic energy over the step of a body of a mass, erg.
    #[inline(always)]
    pub(super) fn energy(&self, mass: S) -> S {
        (self.velocity.square() * mass + self.spin.dot(self.momentum)) * mass.like(0.5)
    }
}

/// All bodies where a step begins.
#[derive(Clone, Copy)]
pub(super) struct Pose<'a, S: Scalar> {
    pub(super) tree: &'a Tree<S>,
    /// Where each body is, and what it does.
    pub(super) frames: &'a [Frame<S>],
    /// The inertia of each about its centre, in the axes of the world.
    pub(super) inertias: &'a [Sym<S>],
}

/// Computes the strides of all bodies with these speeds, of which `moves` are the velocities.
#[inline(always)]
pub(super) fn stride<S: Scalar>(
    Pose { tree, frames, inertias }: Pose<'_, S>,
    speeds: &[S],
    moves: &[Velocity<S>],
    step: S,
    ways: &mut [Way<S>],
    strides: &mut [Stride<S>],
) {
    let rate = step.like(1.0) / step;
    let half = rate * rate.like(0.5);
    for (body, link) in tree.links.iter().enumerate() {
        let (frame, own) = (&frames[body], &moves[body]);
        let mut way = if body == 0 {
            let (turn, shift) = (turning(own.spin * step), own.velocity * step);
            Way { turn, shift, ..Way::null(tree.kit) }
        } else {
            let (carrier, parent) = (&ways[link.parent], &frames[link.parent]);
            let by = speeds[dof_of(body)] * step;
            match tree.travels[body] {
                Travel::Turn => turned(carrier, parent, frame, by),
                Travel::Slide => slid(carrier, parent, frame, by),
            }
        };
        way.velocity = way.shift * rate;
        way.spin = axial(&way.turn) * half;
        way.momentum = momentum(&inertias[body], &way.turn) * rate;
        strides[body] = Stride {
            shift: way.velocity - own.velocity,
            turn: way.spin - own.spin,
            spin: way.momentum - inertias[body] * own.spin,
        };
        ways[body] = way;
    }
}

/// The way of a body whose joint turns by an angle.
#[inline(always)]
fn turned<S: Scalar>(carrier: &Way<S>, parent: &Frame<S>, own: &Frame<S>, angle: S) -> Way<S> {
    let about = turning(own.axis * angle);
    let both = carrier.turn * about;
    let turn = M3([0, 1, 2].map(|row| carrier.turn[row] + about[row] + both[row]));
    let anchor = carrier.shift + carrier.turn * (own.anchor - parent.centre);
    let shift = anchor + turn * (own.centre - own.anchor);
    Way { turn, shift, ..Way::null(angle.kit()) }
}

/// The way of a body whose joint slides by a distance.
#[inline(always)]
fn slid<S: Scalar>(carrier: &Way<S>, parent: &Frame<S>, own: &Frame<S>, way: S) -> Way<S> {
    let moved = own.axis * way;
    let shift = carrier.shift + moved + carrier.turn * (moved + (own.centre - parent.centre));
    Way { turn: carrier.turn, shift, ..Way::null(way.kit()) }
}

/// Twice the vector of a matrix's antisymmetric part.
#[inline(always)]
fn axial<S: Scalar>(m: &M3<S>) -> V3<S> {
    V3([m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]])
}

/// The angular momentum, times the step, of a body that turns by a rotation less one.
#[inline(always)]
fn momentum<S: Scalar>(inertia: &Sym<S>, turn: &M3<S>) -> V3<S> {
    let Sym([xx, yy, zz, xy, xz, yz]) = *inertia;
    let half = (xx + yy + zz) * xx.like(0.5);
    let second_moments =
        M3([V3([half - xx, -xy, -xz]), V3([-xy, half - yy, -yz]), V3([-xz, -yz, half - zz])]);
    axial(&(*turn * second_moments))
}

/// The rotation by a vector, less one: by series that are exact to rounding for the angles of a step.
#[inline(always)]
fn turning<S: Scalar>(r: V3<S>) -> M3<S> {
    let k = |value: f64| r[0].like(value);
    let square = r.square();
    // sin(r) / r and (1 - cos(r)) / r^2.
    let sine = k(1.0) - square * (k(1.0 / 6.0) - square * (k(1.0 / 120.0) - square * k(1.0 / 5040.0)));
    let rest = k(0.5) - square * (k(1.0 / 24.0) - square * (k(1.0 / 720.0) - square * k(1.0 / 40320.0)));
    let [u, t] = [r * sine, r * rest];
    let none = square * rest;
    M3([
        V3([t[0] * r[0] - none, t[0] * r[1] - u[2], t[0] * r[2] + u[1]]),
        V3([t[1] * r[0] + u[2], t[1] * r[1] - none, t[1] * r[2] - u[0]]),
        V3([t[2] * r[0] - u[1], t[2] * r[1] + u[0], t[2] * r[2] - none]),
    ])
}
