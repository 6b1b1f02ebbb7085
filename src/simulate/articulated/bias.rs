//! Forces that need no acceleration: gravity, Coriolis and centrifugal forces.
//!
//! Recursive Newton-Euler with all joint accelerations zero (Featherstone
//! 2008, section 5.3), in ordinary accelerations of the centres of mass.

use super::kinematics::Frame;
use super::scalar::Scalar;
use super::tree::{Tree, dof_of};
use super::vector::{Sym, V3, add, apply_sym, cross, dot, null, scale, sub};

/// What each body needs to keep its joints from accelerating.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrench<S> {
    /// Angular acceleration.
    turn: V3<S>,
    /// Acceleration of the centre of mass.
    shift: V3<S>,
    /// Force on the body and all that hangs on it.
    force: V3<S>,
    /// Torque on the same about its hinge.
    torque: V3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// Nothing.
    pub(super) fn null(kit: S::Kit) -> Self {
        let zero = null(kit);
        Self { turn: zero, shift: zero, force: zero, torque: zero }
    }
}

/// Fills `forces` with minus the bias force C of each degree of freedom.
#[inline(always)]
pub(super) fn bias<S: Scalar>(
    tree: &Tree<S>,
    speeds: &[S],
    gravity: V3<S>,
    frames: &[Frame<S>],
    inertias: &[Sym<S>],
    wrenches: &mut [Wrench<S>],
    forces: &mut [S],
) {
    let still = null(tree.kit);
    for (body, link) in tree.links.iter().enumerate() {
        let frame = &frames[body];
        let (turn, shift) = if body == 0 {
            // An upward acceleration of everything stands for gravity.
            (still, gravity.map(|g| -g))
        } else {
            accelerate(&wrenches[link.parent], &frames[link.parent], frame, speeds[dof_of(body)])
        };
        let inertia = &inertias[body];
        let spin_up = add(apply_sym(inertia, turn), cross(frame.spin, apply_sym(inertia, frame.spin)));
        let force = scale(shift, link.mass);
        let torque = add(spin_up, cross(sub(frame.centre, frame.hinge), force));
        wrenches[body] = Wrench { turn, shift, force, torque };
    }
    for body in (1..tree.links.len()).rev() {
        let parent = tree.links[body].parent;
        let own = wrenches[body];
        forces[dof_of(body)] = -dot(frames[body].axis, own.torque);
        let arm = sub(frames[body].hinge, frames[parent].hinge);
        let carrier = &mut wrenches[parent];
        carrier.force = add(carrier.force, own.force);
        carrier.torque = add(carrier.torque, add(own.torque, cross(arm, own.force)));
    }
    for axis in 0..3 {
        forces[axis] = -wrenches[0].torque[axis];
        forces[3 + axis] = -wrenches[0].force[axis];
    }
}

#[inline(always)]
fn accelerate<S: Scalar>(carrier: &Wrench<S>, parent: &Frame<S>, own: &Frame<S>, rate: S) -> (V3<S>, V3<S>) {
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
