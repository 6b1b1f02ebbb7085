//! Servos and motors with the limits of their torque, springs, and the hard limits of joints.
//!
//! A servo is an implicit spring-damper inside the mass matrix: its impulse in
//! a step is `drive - yielding * speed` with the speed at the end of the step.
//! A servo at its torque limit gives just that, and is left out of the matrix.
//! Which servos are at their limit is guessed from the last step and corrected
//! with the speeds that come out, contacts included: an active set. (As rows of
//! the contact solver beside the implicit part, slipping servos diverge.) Hard
//! limits of the angle are such rows.

use super::factor::Factor;
use super::kinematics::State;
use super::pgs::Unrest;
use super::scalar::{Mask, Scalar};
use super::tree::{Tree, dof_of};

/// A servo over its limit by less than this share is let pass.
const TOLERANCE: f64 = 1e-3;
/// The speed at the beginning of a step, as shares of those in this step, the last, and that before: of second order,
/// and what is stiff decays by a third in a step, changing sign. (Half and half would be of second order, too, and ring.)
const DAMPER: [f64; 3] = [9.0 / 16.0, 6.0 / 16.0, 1.0 / 16.0];
/// The angle at the beginning of a step has these shares of turns in the three steps added to it, which comes to
/// nothing where the speed is steady; what is stiff decays by a half.
const SPRING: [f64; 3] = [8.0 / 27.0, -7.0 / 27.0, -1.0 / 27.0];
/// A limit that is no further away than this is looked at even when all is still, rad or cm.
const NEAR: f64 = 0.02;
/// A speed that no step reaches: the room of a limit that is far away.
const FAR: f64 = 1e30;

/// One joint that is near a hard limit.
#[derive(Clone, Copy, Debug)]
struct Stop<S> {
    body: usize,
    start: usize,
    count: usize,
    /// What a unit impulse does to the joint's speed.
    response: S,
    /// Speeds that would reach the low and the high limit in this step.
    room: (S, S),
    /// Impulses that hold the limits.
    hold: (S, S),
}

/// What a servo does in this step.
#[derive(Clone, Copy, Debug)]
struct Drive<S> {
    /// Impulse at zero speed.
    drive: S,
    /// Speed of the joint in the step before the last.
    before: S,
    /// Where the servo's target stands when the step begins: what it was aimed at last.
    target: S,
    /// Impulse lost per speed.
    yielding: S,
    /// Largest impulse.
    most: S,
    /// The sign of its impulse if it is at its limit, else zero.
    strained: S,
    /// The impulse that acted when the step was last solved.
    given: S,
    /// The work done so far, and what rounding has cut off it (Kahan's summation).
    work: (S, S),
    /// Impulses that held the hard limits in the last step.
    hold: (S, S),
}

impl<S: Scalar> Drive<S> {
    fn null(kit: S::Kit) -> Self {
        let zero = S::zero(kit);
        let none = (zero, zero);
        Self {
            drive: zero,
            before: zero,
            target: zero,
            yielding: zero,
            most: zero,
            strained: zero,
            given: zero,
            work: none,
            hold: none,
        }
    }

    /// Where the servo is not at its limit.
    #[inline(always)]
    fn is_free(&self) -> S::Mask {
        self.strained.abs().less(self.strained.like(0.5))
    }
}

/// All joints.
#[derive(Clone, Debug)]
pub(super) struct Joints<S> {
    stops: Vec<Stop<S>>,
    /// By body.
    drives: Vec<Drive<S>>,
    columns: Vec<S>,
    dofs: Vec<u32>,
}

impl<S: Scalar> Joints<S> {
    /// Room for all joints of a tree.
    pub(super) fn new(tree: &Tree<S>) -> Self {
        let bodies = tree.links.len();
        Self {
            stops: Vec::with_capacity(bodies),
            drives: vec![Drive::null(tree.kit); bodies],
            columns: Vec::with_capacity(tree.entries),
            dofs: Vec::with_capacity(tree.entries),
        }
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        let kit = self.drives[0].drive.kit();
        self.drives.fill(Drive::null(kit));
    }

    /// Computes what the servos do at the state and targets of this step, for a time that is shorter than it in the first.
    #[inline(always)]
    pub(super) fn prepare(&mut self, tree: &Tree<S>, state: &State<S>, targets: &[S], step: S, time: S) {
        let k = |value: f64| step.like(value);
        // Springs pull to where they are slack from the beginning.
        for &body in &tree.passive {
            self.drives[body].target = targets[tree.links[body].servo];
        }
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let servo = &mut self.drives[body];
            let (now, before) = (state.speeds[dof_of(body)], servo.before);
            let damped = now * k(DAMPER[1]) + before * k(DAMPER[2]);
            servo.drive = if tree.spun[body] {
                time * (link.damping * (servo.target - damped))
            } else {
                let bent = state.positions[body] + step * (now * k(SPRING[1]) + before * k(SPRING[2]));
                time * (link.stiffness * (servo.target - bent) - link.damping * damped)
            };
            servo.yielding = step * (link.damping * k(DAMPER[0]) + step * link.stiffness * k(SPRING[0]));
            servo.most = step * link.effort;
            servo.before = now;
            servo.target = targets[link.servo];
        }
    }

    /// Adds the servos to the impulses of the step.
    #[inline(always)]
    pub(super) fn push(&self, state: &State<S>, impulses: &mut [S]) {
        for (body, servo) in self.drives.iter().enumerate().skip(1) {
            let dof = dof_of(body);
            let implicit = servo.drive - servo.yielding * state.speeds[dof];
            impulses[dof] += S::pick(servo.is_free(), implicit, servo.strained * servo.most);
        }
    }

    /// Adds the servos to the mass matrix.
    #[inline(always)]
    pub(super) fn stiffen(&self, tree: &Tree<S>, h: &mut [S]) {
        let zero = S::zero(tree.kit);
        for (body, servo) in self.drives.iter().enumerate().skip(1) {
            let dof = dof_of(body);
            h[tree.rows[dof] + tree.path_to(dof).len() - 1] += S::pick(servo.is_free(), servo.yielding, zero);
        }
    }

    /// Corrects which servos are at their limit, from the speeds at the end of
    /// the step, in the `live` lanes; returns where that changes the step. Unless
    /// `release`, servos only come to be at their limit, so that the search ends.
    #[inline(always)]
    pub(super) fn review(&mut self, speeds: &[S], release: bool, live: S::Mask) -> S::Mask {
        let kit = self.drives[0].drive.kit();
        let (zero, one) = (S::zero(kit), S::of(kit, 1.0));
        let release = S::mask(kit, release);
        let mut changed = S::mask(kit, false);
        for (body, servo) in self.drives.iter_mut().enumerate().skip(1) {
            let free = servo.is_free();
            let impulse = servo.drive - servo.yielding * speeds[dof_of(body)];
            // Before the flag changes: what it says now is what was solved with.
            let given = S::pick(free, impulse, servo.strained * servo.most);
            servo.given = S::pick(live, given, servo.given);
            let comes = live & free & (servo.most * S::of(kit, 1.0 + TOLERANCE)).less(impulse.abs());
            let leaves = live & release & !free & (impulse * servo.strained).less(servo.most);
            let sign = S::pick(zero.less(impulse), one, -one);
            servo.strained = S::pick(comes, sign, S::pick(leaves, zero, servo.strained));
            changed = changed | comes | leaves;
        }
        changed
    }

    /// Adds up the work of the step just solved, which ends with these speeds.
    #[inline(always)]
    pub(super) fn tally(&mut self, tree: &Tree<S>, speeds: &[S]) {
        for (body, servo) in self.drives.iter_mut().enumerate().skip(1) {
            // The joint turns by its speed times the step, so impulse times
            // speed is torque times turn; what slides, likewise.
            let work = (servo.given * speeds[dof_of(body)]).max(servo.given.like(0.0)) - servo.work.1;
            let sum = servo.work.0 + work;
            servo.work = (sum, (sum - servo.work.0) - work);
        }
        // What springs give back is no work of theirs: see `stored`.
        for &body in &tree.passive {
            self.drives[body].work = (S::zero(tree.kit), S::zero(tree.kit));
        }
    }

    /// The energy in the springs of passive joints in the middle of the step just made, erg. It is counted, so that a spring
    /// that gave more than it took would be found out.
    #[inline(always)]
    pub(super) fn stored(&self, tree: &Tree<S>, state: &State<S>, step: S) -> S {
        let half = step.like(0.5);
        let mut sum = step.like(0.0);
        for &body in &tree.passive {
            let middle = state.positions[body] - state.speeds[dof_of(body)] * (step * half);
            let stretch = middle - self.drives[body].target;
            sum += half * (tree.links[body].stiffness * (stretch * stretch));
        }
        sum
    }

    /// The work that has been done at a body's joint since the last reset, erg.
    #[inline(always)]
    pub(super) fn work(&self, body: usize) -> S {
        self.drives[body].work.0
    }

    /// Makes rows for the joints that come near a hard limit; `free` are the
    /// speeds that the step would end with if there were no contacts.
    #[inline(always)]
    pub(super) fn collect(
        &mut self,
        tree: &Tree<S>,
        state: &State<S>,
        factor: &Factor<S>,
        free: &[S],
        step: S,
    ) {
        self.stops.clear();
        self.columns.clear();
        self.dofs.clear();
        let (rate, far) = (step.like(1.0) / step, step.like(FAR));
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let near = step * free[dof_of(body)].abs() * step.like(2.0) + step.like(NEAR);
            let angle = state.positions[body];
            let (low, high) = (angle - link.limits.0, link.limits.1 - angle);
            let is_near = low.less(near) | high.less(near);
            if is_near.any() {
                let room = |gap: S| S::pick(is_near, soften(gap) * rate, far);
                self.push_stop(tree, factor, body, is_near, (room(low), room(high)));
            }
        }
    }

    #[inline(always)]
    fn push_stop(&mut self, tree: &Tree<S>, factor: &Factor<S>, body: usize, is_near: S::Mask, room: (S, S)) {
        let path = tree.path(body);
        let start = self.columns.len();
        let zero = S::zero(tree.kit);
        self.columns.resize(start + path.len(), zero);
        self.dofs.extend_from_slice(path);
        let columns = &mut self.columns[start..];
        columns[path.len() - 1] = zero.like(1.0);
        let mut response = zero;
        for depth in (0..path.len()).rev() {
            let dof = path[depth] as usize;
            let own = columns[depth];
            for (column, &entry) in columns[..depth].iter_mut().zip(factor.row(tree, dof, depth)) {
                *column -= own * entry;
            }
            columns[depth] = own * factor.inverse[dof];
            response += columns[depth] * columns[depth];
        }
        let (low, high) = self.drives[body].hold;
        let hold = (S::pick(is_near, low, zero), S::pick(is_near, high, zero));
        self.stops.push(Stop { body, start, count: path.len(), response, room, hold });
    }

    /// Applies the impulses that the rows start with.
    #[inline(always)]
    pub(super) fn warm_start(&self, y: &mut [S]) {
        for stop in &self.stops {
            self.apply(stop, y, stop.hold.0 - stop.hold.1);
        }
    }

    #[inline(always)]
    fn apply(&self, stop: &Stop<S>, y: &mut [S], impulse: S) {
        let span = stop.start..stop.start + stop.count;
        for (&column, &dof) in self.columns[span.clone()].iter().zip(&self.dofs[span]) {
            y[dof as usize] += column * impulse;
        }
    }

    /// One sweep over all rows, in the lanes that are not at rest yet.
    #[inline(always)]
    pub(super) fn sweep(&mut self, y: &mut [S], open: S::Mask, unrest: &mut Unrest<S>) {
        for place in 0..self.stops.len() {
            let mut stop = self.stops[place];
            let span = stop.start..stop.start + stop.count;
            let zero = stop.response.like(0.0);
            let mut speed = zero;
            for (&column, &dof) in self.columns[span.clone()].iter().zip(&self.dofs[span]) {
                speed += column * y[dof as usize];
            }
            let before = stop.hold;
            let low = (before.0 - (speed + stop.room.0) / stop.response).max(zero);
            stop.hold.0 = S::pick(open, low, before.0);
            let up = stop.hold.0 - before.0;
            speed += up * stop.response;
            let high = (before.1 + (speed - stop.room.1) / stop.response).max(zero);
            stop.hold.1 = S::pick(open, high, before.1);
            let change = up - (stop.hold.1 - before.1);
            let whole = stop.hold.0 - stop.hold.1;
            unrest.add(change * change * stop.response, whole * whole * stop.response);
            self.stops[place] = stop;
            self.apply(&stop, y, change);
        }
    }

    /// The lanes in which limits of several joints hold at once.
    #[inline(always)]
    pub(super) fn several_hold(&self, kit: S::Kit) -> S::Mask {
        let zero = S::zero(kit);
        let one = |stop: &Stop<S>| S::pick(zero.less(stop.hold.0 + stop.hold.1), zero.like(1.0), zero);
        let mut holding = zero;
        for stop in &self.stops {
            holding += one(stop);
        }
        zero.like(1.5).less(holding)
    }

    /// Remembers the impulses of the live lanes for the next solution.
    #[inline(always)]
    pub(super) fn remember(&mut self, live: S::Mask) {
        for servo in &mut self.drives {
            let zero = servo.drive.like(0.0);
            servo.hold = (S::pick(live, zero, servo.hold.0), S::pick(live, zero, servo.hold.1));
        }
        for stop in &self.stops {
            let hold = &mut self.drives[stop.body].hold;
            *hold = (S::pick(live, stop.hold.0, hold.0), S::pick(live, stop.hold.1, hold.1));
        }
    }
}

/// A limit that is overstepped is mended by a fifth per step.
#[inline(always)]
fn soften<S: Scalar>(gap: S) -> S {
    S::pick(gap.less(gap.like(0.0)), gap * gap.like(0.2), gap)
}
