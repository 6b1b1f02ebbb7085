//! Energy bookkeeping: what the servos have not put in must not be there.

use super::joints::Joints;
use super::kinematics::{Frame, State, Velocity};
use super::momentum::Momenta;
use super::scalar::Scalar;
use super::stride::Way;
use super::tree::{LENGTH, Tree};
use super::vector::V3;
use crate::simulate::Settings;

/// Energy that may come from nowhere, as a height in cm to which it lifts the
/// whole body: contacts that mend an overlap and the coarseness of steps give some.
const ALLOWED: f64 = 0.25;

/// Kinetic and potential energy less the work of the servos. In truth it only
/// falls, as hinges, friction and impacts take from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ledger<S> {
    /// The lowest balance so far, at most, erg.
    lowest: S,
    /// How much more there was when it was last looked at.
    pub(super) gained: S,
    /// How much more is too much.
    pub(super) allowed: S,
}

impl<S: Scalar> Ledger<S> {
    /// Before the first step.
    pub(super) fn new(tree: &Tree<S>, settings: &Settings) -> Self {
        let of = |value: f64| S::of(tree.kit, value);
        // Without weight a body may still spin: as much as on earth.
        let fall = settings.gravity.max(9.81) * LENGTH;
        Self { lowest: of(f64::MAX), gained: of(0.0), allowed: tree.mass() * of(fall * ALLOWED) }
    }

    /// Back to before the first step.
    pub(super) fn reset(&mut self) {
        self.lowest = self.lowest.like(f64::MAX);
        self.gained = self.gained.like(0.0);
    }

    /// How much energy has come from nowhere since the balance was lowest, erg.
    /// The energy is known to within a `doubt`.
    #[inline(always)]
    pub(super) fn gain(&mut self, (energy, doubt): (S, S), joints: &Joints<S>, bodies: usize) -> S {
        let mut balance = energy;
        for body in 1..bodies {
            balance -= joints.work(body);
        }
        self.lowest = self.lowest.min(balance + doubt);
        self.gained = balance - doubt - self.lowest;
        self.gained
    }
}

/// Kinetic energy of all bodies plus their potential energy in the middle of the last step, erg.
#[inline(always)]
pub(super) fn energy<S: Scalar>(
    tree: &Tree<S>,
    ways: &[Way<S>],
    momenta: &Momenta<S>,
    state: &State<S>,
    gravity: V3<S>,
    step: S,
) -> S {
    let mut sum = step.like(0.0);
    for (way, link) in ways.iter().zip(&tree.links) {
        sum += way.energy(link.mass);
    }
    // Weight times the height of the centre of mass, half a step ago.
    let weight = gravity * momenta.mass;
    sum - weight.dot(state.centre) + gravity.dot(momenta.linear) * (step * step.like(0.5))
}

/// How far the energy over the last step may be from that which the scheme keeps, erg. A body that turns by an angle a in
/// a step about a fixed axis has a share of a^2 / 12 to a^2 / 4 more or less, whatever is taken for its speed:
/// this is the energy of half of what velocities changed by while speeds were the same.
#[inline(always)]
pub(super) fn doubt<S: Scalar>(tree: &Tree<S>, before: &[Velocity<S>], after: &[Frame<S>]) -> S {
    let mut sum = S::zero(tree.kit);
    for ((link, before), after) in tree.links.iter().zip(before).zip(after) {
        let change = after.velocity - before.velocity;
        sum += change.square() * link.mass;
    }
    sum * sum.like(0.125)
}
