//! What the bodies carry from one step into the next, and what makes them turn and shift
//! without any change of speeds: gravity, Coriolis and centrifugal forces.
//!
//! Recursive Newton-Euler with all joint accelerations zero (Featherstone
//! 2008, section 5.3), in ordinary accelerations of the centres of mass.

use super::kinematics::{Frame, Velocity};
use super::momentum::Momenta;
use super::scalar::Scalar;
use super::tree::{Tree, dof_of};
use super::vector::{Sym, V3, add, apply_sym, cross, dot, null, scale, sub};

/// What each body needs to keep its joints from accelerating.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift<S> {
    /// Angular acceleration at constant speeds of all degrees of freedom.
    pub(super) turn: V3<S>,
    /// Acceleration of the centre of mass at the same.
    pub(super) shift: V3<S>,
    /// Change of the angular momentum about the centre at the same.
    pub(super) torque: V3<S>,
}

impl<S: Scalar> Drift<S> {
    /// Nothing.
    pub(super) fn null(kit: S::Kit) -> Self {
        let zero = null(kit);
        Self { turn: zero, shift: zero, torque: zero }
    }
}

/// Impulse on a body and all that hangs on it, and its moment about the hinge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrench<S> {
    linear: V3<S>,
    angular: V3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// Nothing.
    pub(super) fn null(kit: S::Kit) -> Self {
        Self { linear: null(kit), angular: null(kit) }
    }
}

/// Computes how all bodies accelerate at constant speeds.
#[inline(always)]
pub(super) fn drift<S: Scalar>(
    tree: &Tree<S>,
    speeds: &[S],
    frames: &[Frame<S>],
    inertias: &[Sym<S>],
    drifts: &mut [Drift<S>],
) {
    let still = null(tree.kit);
    for (body, link) in tree.links.iter().enumerate() {
        let frame = &frames[body];
        let (turn, shift) = if body == 0 {
            (still, still)
        } else {
            accelerate(&drifts[link.parent], &frames[link.parent], frame, speeds[dof_of(body)])
        };
        let inertia = &inertias[body];
        let torque = add(apply_sym(inertia, turn), cross(frame.spin, apply_sym(inertia, frame.spin)));
        drifts[body] = Drift { turn, shift, torque };
    }
}

/// Fills `impulses` with what each degree of freedom has to gain in a step, beside what servos and
/// contacts give: the momentum that the bodies have had over the last step, less that which the
/// present speeds would mean, less half a step of drift, plus the `fall`, the change of velocity by gravity.
#[inline(always)]
pub(super) fn gather<S: Scalar>(
    tree: &Tree<S>,
    frames: &[Frame<S>],
    inertias: &[Sym<S>],
    (drifts, half): (&[Drift<S>], S),
    (momenta, fall): (&Momenta<S>, V3<S>),
    wrenches: &mut [Wrench<S>],
    impulses: &mut [S],
) {
    for (body, link) in tree.links.iter().enumerate() {
        let (frame, drift, carried) = (&frames[body], &drifts[body], &momenta.bodies[body]);
        let change = sub(add(sub(carried.velocity, frame.velocity), fall), scale(drift.shift, half));
        let linear = scale(change, link.mass);
        let spin = sub(carried.spin, apply_sym(&inertias[body], frame.spin));
        let angular = sub(spin, scale(drift.torque, half));
        let arm = sub(frame.centre, frame.hinge);
        wrenches[body] = Wrench { linear, angular: add(angular, cross(arm, linear)) };
    }
    for body in (1..tree.links.len()).rev() {
        let parent = tree.links[body].parent;
        let own = wrenches[body];
        impulses[dof_of(body)] = dot(frames[body].axis, own.angular);
        let arm = sub(frames[body].hinge, frames[parent].hinge);
        let carrier = &mut wrenches[parent];
        carrier.linear = add(carrier.linear, own.linear);
        carrier.angular = add(carrier.angular, add(own.angular, cross(arm, own.linear)));
    }
    let excess = momenta.excess(tree, frames);
    for axis in 0..3 {
        impulses[axis] = wrenches[0].angular[axis] + excess.1[axis];
        impulses[3 + axis] = wrenches[0].linear[axis] + excess.0[axis];
    }
}

#[inline(always)]
fn accelerate<S: Scalar>(carrier: &Drift<S>, parent: &Frame<S>, own: &Frame<S>, rate: S) -> (V3<S>, V3<S>) {
    let to_hinge = sub(own.hinge, parent.centre);
    let to_centre = sub(own.centre, own.hinge);
    let turn = add(carrier.turn, cross(parent.spin, scale(own.axis, rate)));
    let at_hinge = add(
        add(carrier.shift, cross(carrier.turn, to_hinge)),
        cross(parent.spin, cross(parent.spin, to_hinge)),
    );
    let shift = add(add(at_hinge, cross(turn, to_centre)), cross(own.spin, cross(own.spin, to_centre)));
    (turn, shift)
}

/// The acceleration, at constant speeds, of a contact point of a body, `arm` from its centre, which moves against
/// the centre with the velocity `moving`.
#[inline(always)]
pub(super) fn drift_at<S: Scalar>(drift: &Drift<S>, frame: &Frame<S>, arm: V3<S>, moving: V3<S>) -> V3<S> {
    add(drift.shift, add(cross(drift.turn, arm), cross(frame.spin, moving)))
}

/// What every body has carried over a step: its velocity and its momentum of turning, from the
/// velocities at the beginning and half a step of drift.
#[inline(always)]
pub(super) fn carry<S: Scalar>(
    inertias: &[Sym<S>],
    moves: &[Velocity<S>],
    (drifts, half): (&[Drift<S>], S),
    momenta: &mut Momenta<S>,
) {
    for (body, carried) in momenta.bodies.iter_mut().enumerate() {
        let (own, drift) = (&moves[body], &drifts[body]);
        carried.velocity = add(own.velocity, scale(drift.shift, half));
        carried.spin = add(apply_sym(&inertias[body], own.spin), scale(drift.torque, half));
    }
}
