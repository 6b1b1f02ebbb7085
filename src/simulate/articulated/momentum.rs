//! The momentum of each body and of the whole.
//!
//! What a body carries over a step is that of its motion in the middle of it. The momenta of
//! the whole are kept beside: only gravity and the impulses of the ground change them,
//! and the centre of mass moves with them, so that no error of the hinges can move a body.

use super::kinematics::{Frame, State, Velocity};
use super::scalar::Scalar;
use super::stride::{Pose, Stride};
use super::tree::{Tree, dof_of};
use super::vector::{Sym, V3};
use crate::design::assembly::Travel;

/// What a body carries over a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Momentum<S> {
    /// Velocity of the centre of mass, cm/s.
    pub(super) velocity: V3<S>,
    /// Angular momentum about it, g cm^2/s.
    pub(super) spin: V3<S>,
}

/// The momenta of all bodies and of the whole.
#[derive(Clone, Debug)]
pub(super) struct Momenta<S> {
    /// By body.
    pub(super) bodies: Vec<Momentum<S>>,
    /// Momentum of the whole, g cm/s.
    pub(super) linear: V3<S>,
    /// Its angular momentum about the centre of mass, g cm^2/s.
    pub(super) angular: V3<S>,
    /// The centre of mass relative to that of the root, cm.
    pub(super) centre: V3<S>,
    /// Mass of the whole, g.
    pub(super) mass: S,
    shares: Vec<S>,
}

impl<S: Scalar> Momenta<S> {
    /// At rest.
    pub(super) fn new(tree: &Tree<S>) -> Self {
        let zero = V3::null(tree.kit);
        let mass = tree.mass();
        Self {
            bodies: vec![Momentum { velocity: zero, spin: zero }; tree.links.len()],
            linear: zero,
            angular: zero,
            centre: zero,
            mass,
            shares: tree.links.iter().map(|link| link.mass / mass).collect(),
        }
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        let zero = V3::null(self.mass.kit());
        self.bodies.fill(Momentum { velocity: zero, spin: zero });
        (self.linear, self.angular, self.centre) = (zero, zero, zero);
    }

    /// The sums over the bodies: momentum, and angular momentum about the root's centre.
    #[inline(always)]
    fn sums(&self, tree: &Tree<S>, frames: &[Frame<S>]) -> (V3<S>, V3<S>) {
        let zero = V3::null(tree.kit);
        let (mut linear, mut angular) = (zero, zero);
        for ((body, link), frame) in self.bodies.iter().zip(&tree.links).zip(frames) {
            let own = body.velocity * link.mass;
            linear += own;
            angular += body.spin + frame.centre.cross(own);
        }
        (linear, angular)
    }

    /// What the whole has beyond the sums over the bodies where they are now: momentum, and
    /// angular momentum about the root's centre.
    #[inline(always)]
    pub(super) fn excess(&self, tree: &Tree<S>, frames: &[Frame<S>]) -> (V3<S>, V3<S>) {
        let (linear, angular) = self.sums(tree, frames);
        let whole = self.angular + self.centre.cross(self.linear);
        (self.linear - linear, whole - angular)
    }

    /// Makes the momenta of the whole those of its bodies.
    pub(super) fn settle(&mut self, tree: &Tree<S>, frames: &[Frame<S>]) {
        let (linear, angular) = self.sums(tree, frames);
        self.centre = self.locate(frames);
        self.linear = linear;
        self.angular = angular - self.centre.cross(linear);
    }

    /// The centre of mass relative to that of the root.
    #[inline(always)]
    pub(super) fn locate(&self, frames: &[Frame<S>]) -> V3<S> {
        let mut sum = V3::null(self.mass.kit());
        for (frame, &share) in frames.iter().zip(&self.shares) {
            sum += frame.centre * share;
        }
        sum
    }

    /// Gravity changes the velocity of everything.
    #[inline(always)]
    pub(super) fn fall(&mut self, change: V3<S>) {
        self.linear += change * self.mass;
    }

    /// An impulse acts on the whole at a point relative to the root's centre.
    #[inline(always)]
    pub(super) fn push(&mut self, point: V3<S>, impulse: V3<S>) {
        self.linear += impulse;
        self.angular += (point - self.centre).cross(impulse);
    }

    /// Moves the centre of mass for a time, and the root to where the frames at its end say that it is.
    #[inline(always)]
    pub(super) fn advance(&mut self, frames: &[Frame<S>], state: &mut State<S>, step: S) {
        let rate = step / self.mass;
        for axis in 0..3 {
            let small = self.linear[axis] * rate - state.lost[axis];
            let sum = state.centre[axis] + small;
            state.lost[axis] = (sum - state.centre[axis]) - small;
            state.centre[axis] = sum;
        }
        self.centre = self.locate(frames);
        state.position = state.centre - self.centre;
    }
}

/// Impulse on a body and all that hangs on it, and its moment about the joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrench<S> {
    linear: V3<S>,
    angular: V3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// Nothing.
    pub(super) fn null(kit: S::Kit) -> Self {
        Self { linear: V3::null(kit), angular: V3::null(kit) }
    }
}

/// Fills `impulses` with what each degree of freedom has to gain in a step, beside what servos and
/// contacts give: the momentum that the bodies have had over the last step, less that which the
/// present speeds would mean in this step, plus the `fall`, the change of velocity by gravity.
#[inline(always)]
pub(super) fn gather<S: Scalar>(
    Pose { tree, frames, inertias }: Pose<'_, S>,
    strides: &[Stride<S>],
    momenta: &Momenta<S>,
    fall: V3<S>,
    wrenches: &mut [Wrench<S>],
    impulses: &mut [S],
) {
    for (body, link) in tree.links.iter().enumerate() {
        let (frame, stride, carried) = (&frames[body], &strides[body], &momenta.bodies[body]);
        let change = carried.velocity - frame.velocity + fall - stride.shift;
        let linear = change * link.mass;
        let spin = carried.spin - inertias[body] * frame.spin;
        let angular = spin - stride.spin;
        let arm = frame.centre - frame.anchor;
        wrenches[body] = Wrench { linear, angular: angular + arm.cross(linear) };
    }
    for body in (1..tree.links.len()).rev() {
        let parent = tree.links[body].parent;
        let own = wrenches[body];
        impulses[dof_of(body)] = match tree.travels[body] {
            Travel::Turn => frames[body].axis.dot(own.angular),
            Travel::Slide => frames[body].axis.dot(own.linear),
        };
        let arm = frames[body].anchor - frames[parent].anchor;
        let carrier = &mut wrenches[parent];
        carrier.linear += own.linear;
        carrier.angular += own.angular + arm.cross(own.linear);
    }
    let excess = momenta.excess(tree, frames);
    for axis in 0..3 {
        impulses[axis] = wrenches[0].angular[axis] + excess.1[axis];
        impulses[3 + axis] = wrenches[0].linear[axis] + excess.0[axis];
    }
}

/// What every body carries over a step: what its velocities at the beginning mean, and its stride.
#[inline(always)]
pub(super) fn carry<S: Scalar>(
    inertias: &[Sym<S>],
    moves: &[Velocity<S>],
    strides: &[Stride<S>],
    momenta: &mut Momenta<S>,
) {
    for (body, carried) in momenta.bodies.iter_mut().enumerate() {
        let (own, stride) = (&moves[body], &strides[body]);
        carried.velocity = own.velocity + stride.shift;
        carried.spin = inertias[body] * own.spin + stride.spin;
    }
}
