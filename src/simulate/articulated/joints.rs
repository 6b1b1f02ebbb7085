//! Servos and motors with the limits of their torque, springs, and the hard limits of joints.
//!
//! A servo is an implicit spring-damper inside the mass matrix: its impulse in
//! a step is `drive - yielding * speed` with the speed at the end of the step.
//! A servo at its torque limit gives just that, and is left out of the matrix.
//! Which servos are at their limit is guessed from the last step and corrected
//! with the speeds that come out, contacts included: an active set. (As rows of
//! the contact solver beside the implicit part, slipping servos diverge.) Where many
//! servos load each other, the guesses may go round and round, and a servo that is left with
//! the wrong one pushes a joint that it has to brake: rows of light joints then jump from one hard
//! limit to the other in every step. So a servo that leaves its limit after the first pass
//! is weakened instead: it gives the share of what it would like to that comes to its limit at
//! the speed that came out. Such a servo brakes what moves, whatever the guess.
//!
//! A hard limit is such a row in the step in which a joint comes to it. From then on
//! the joint is held inside the mass matrix, as stiff as numbers allow, until it would have
//! to be pulled: rows of many joints that load each other at their limits would need
//! thousands of sweeps, and what is missing of them adds up from step to step.

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

/// A joint at its limit is held by so many times its own inertia.
const FIRM: f64 = 1e4;
/// Less work than any that is done, erg.
const NO_WORK: f64 = 1e-30;

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
    /// The impulse that holds a limit: above zero at the low one, below at the high one.
    hold: S,
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
    /// Of a motor, the mean of its target over the last step, and over that before.
    sought: S,
    earlier: S,
    /// Impulse lost per speed.
    yielding: S,
    /// Largest impulse.
    most: S,
    /// The sign of its impulse if it is at its limit, else zero.
    strained: S,
    /// Else the share that it gives of its impulse: one, if it is not weakened.
    share: S,
    /// The impulse that acted when the step was last solved.
    given: S,
    /// The work done so far, and what rounding has cut off it (Kahan's summation).
    work: (S, S),
    /// The impulse that held a hard limit in the last step: above zero at the low one, below at the high one.
    hold: S,
    /// One where the hard limits are looked at in this step, else zero.
    watched: S,
    /// Minus one where the joint is held at its low limit, one where at its high limit, else zero.
    held: S,
    /// Impulse lost per speed where it is held, and the speed at which it is held: none, or that which mends.
    firm: S,
    rest: S,
}

impl<S: Scalar> Drive<S> {
    fn null(kit: S::Kit) -> Self {
        let zero = S::zero(kit);
        Self {
            drive: zero,
            before: zero,
            target: zero,
            sought: zero,
            earlier: zero,
            yielding: zero,
            most: zero,
            strained: zero,
            share: S::of(kit, 1.0),
            given: zero,
            work: (zero, zero),
            hold: zero,
            watched: zero,
            held: zero,
            firm: zero,
            rest: zero,
        }
    }

    /// Where the servo is not at its limit.
    #[inline(always)]
    fn is_free(&self) -> S::Mask {
        self.strained.abs().less(self.strained.like(0.5))
    }

    /// Where the joint is held at a hard limit.
    #[inline(always)]
    fn is_held(&self) -> S::Mask {
        self.held.like(0.5).less(self.held.abs())
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

    /// Computes what the servos do at the state and targets of this step, for a time that is shorter than it in the first,
    /// and which joints are held at their limits. `h` is the mass matrix.
    #[inline(always)]
    pub(super) fn prepare(
        &mut self,
        tree: &Tree<S>,
        state: &State<S>,
        (targets, h): (&[S], &[S]),
        step: S,
        time: S,
    ) {
        let k = |value: f64| step.like(value);
        let rate = k(1.0) / step;
        // Springs pull to where they are slack from the beginning.
        for &body in &tree.passive {
            self.drives[body].target = targets[tree.links[body].servo];
        }
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let servo = &mut self.drives[body];
            let (now, before) = (state.speeds[dof_of(body)], servo.before);
            let damped = now * k(DAMPER[1]) + before * k(DAMPER[2]);
            servo.drive = if tree.spun[body] {
                // The same shares as of the speed: with the target as it is now, a stiff motor would overshoot whatever it is set to.
                let sought = (servo.target + targets[link.servo]) * k(0.5);
                let asked =
                    sought * k(DAMPER[0]) + servo.sought * k(DAMPER[1]) + servo.earlier * k(DAMPER[2]);
                (servo.earlier, servo.sought) = (servo.sought, sought);
                time * (link.damping * (asked - damped))
            } else {
                let bent = state.positions[body] + step * (now * k(SPRING[1]) + before * k(SPRING[2]));
                time * (link.stiffness * (servo.target - bent) - link.damping * damped)
            };
            // A motor that is as strong as its damper must not be held back for longer in the first step than it is driven.
            let held = if tree.spun[body] { time } else { step };
            servo.yielding = held * (link.damping * k(DAMPER[0]) + step * link.stiffness * k(SPRING[0]));
            servo.most = step * link.effort;
            servo.share = k(1.0);
            servo.before = now;
            servo.watched = k(0.0);
            // Where a limit has held, it goes on.
            let (low, high) = (k(0.0).less(servo.hold), servo.hold.less(k(0.0)));
            let angle = state.positions[body];
            servo.held = S::pick(low, k(-1.0), S::pick(high, k(1.0), k(0.0)));
            servo.rest = S::pick(low, -soften(angle - link.limits.0), soften(link.limits.1 - angle)) * rate;
            servo.firm = h[tree.rows[dof_of(body)] + tree.path_to(dof_of(body)).len() - 1] * k(FIRM);
            servo.target = targets[link.servo];
        }
    }

    /// Adds the servos to the impulses of the step.
    #[inline(always)]
    pub(super) fn push(&self, state: &State<S>, impulses: &mut [S]) {
        for (body, servo) in self.drives.iter().enumerate().skip(1) {
            let dof = dof_of(body);
            let implicit = servo.share * (servo.drive - servo.yielding * state.speeds[dof]);
            impulses[dof] += S::pick(servo.is_free(), implicit, servo.strained * servo.most);
            let hold = servo.firm * (servo.rest - state.speeds[dof]);
            impulses[dof] += S::pick(servo.is_held(), hold, hold.like(0.0));
        }
    }

    /// Adds the servos and the limits that hold to the mass matrix.
    #[inline(always)]
    pub(super) fn stiffen(&self, tree: &Tree<S>, h: &mut [S]) {
        let zero = S::zero(tree.kit);
        for (body, servo) in self.drives.iter().enumerate().skip(1) {
            let dof = dof_of(body);
            h[tree.rows[dof] + tree.path_to(dof).len() - 1] +=
                S::pick(servo.is_free(), servo.share * servo.yielding, zero)
                    + S::pick(servo.is_held(), servo.firm, zero);
        }
    }

    /// Corrects which servos are at their limit, and lets go of joints that would have to be pulled to stay at theirs, from
    /// the speeds at the end of the step, in the `live` lanes; returns where that changes the step. After the `first`
    /// pass, servos that leave their limit are weakened.
    #[inline(always)]
    pub(super) fn review(&mut self, speeds: &[S], first: bool, live: S::Mask) -> S::Mask {
        let kit = self.drives[0].drive.kit();
        let (zero, one) = (S::zero(kit), S::of(kit, 1.0));
        let (first, allowed) = (S::mask(kit, first), S::of(kit, 1.0 + TOLERANCE));
        let mut changed = S::mask(kit, false);
        for (body, servo) in self.drives.iter_mut().enumerate().skip(1) {
            let (free, whole) = (servo.is_free(), !servo.share.less(one));
            let asked = servo.drive - servo.yielding * speeds[dof_of(body)];
            // Before the flag changes: what it says now is what was solved with.
            let given = S::pick(free, servo.share * asked, servo.strained * servo.most);
            servo.given = S::pick(live, given, servo.given);
            let (over, sign) = (asked.abs(), S::pick(zero.less(asked), one, -one));
            let comes = live & free & whole & (servo.most * allowed).less(over);
            let leaves = live & !free & (asked * servo.strained).less(servo.most);
            // What a weakened servo gives is not what it should.
            let right = servo.most.min(over);
            let off = (right * allowed).less(given.abs()) | (given.abs() * allowed).less(right);
            let shared = live & free & !whole & off;
            let share = S::pick(servo.most.less(over), servo.most / over, one);
            servo.share = S::pick(shared | (leaves & !first), share, servo.share);
            servo.strained = S::pick(comes, sign, S::pick(leaves, zero, servo.strained));
            let (held, hold) = (live & servo.is_held(), servo.firm * (servo.rest - speeds[dof_of(body)]));
            let pulls = held & zero.less(hold * servo.held);
            servo.hold = S::pick(held, S::pick(pulls, zero, hold), servo.hold);
            servo.held = S::pick(pulls, zero, servo.held);
            changed = changed | comes | leaves | shared | pulls;
        }
        changed
    }

    /// Has the limits looked at that a step with these speeds would overstep, though no row was made for them: a blow
    /// has made the joint faster than it was foreseen. Returns where there are any.
    #[inline(always)]
    pub(super) fn watch(
        &mut self,
        tree: &Tree<S>,
        state: &State<S>,
        speeds: &[S],
        step: S,
        live: S::Mask,
    ) -> S::Mask {
        let (zero, one) = (S::zero(tree.kit), S::of(tree.kit, 1.0));
        let mut any = S::mask(tree.kit, false);
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let servo = &mut self.drives[body];
            let angle = state.positions[body] + step * speeds[dof_of(body)];
            let is_beyond = angle.less(link.limits.0) | link.limits.1.less(angle);
            let missed = live & is_beyond & !zero.less(servo.watched);
            servo.watched = S::pick(missed, one, servo.watched);
            any = any | missed;
        }
        any
    }

    /// Adds up the work of the step just solved, which begins and ends with these speeds.
    #[inline(always)]
    pub(super) fn tally(&mut self, tree: &Tree<S>, before: &[S], after: &[S]) {
        for (body, servo) in self.drives.iter_mut().enumerate().skip(1) {
            let (dof, zero) = (dof_of(body), servo.given.like(0.0));
            // Torque times turn, at a speed that changes evenly in the step; only pushing counts, not braking. Where the
            // joint turns round within the step, that is a part of it.
            let (first, last) = (servo.given * before[dof], servo.given * after[dof]);
            let pushed = first.max(zero) + last.max(zero);
            let share = pushed / (first.abs() + last.abs()).max(zero.like(NO_WORK));
            let work = pushed * zero.like(0.5) * share - servo.work.1;
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

    /// What a servo gave in the last step, and what it had to give at the speed that came out, as shares of its limit.
    #[cfg(test)]
    pub(super) fn given(&self, body: usize, speeds: &[S]) -> (f64, f64) {
        let servo = &self.drives[body];
        let [most, given, drive, yielding, speed] =
            [servo.most, servo.given, servo.drive, servo.yielding, speeds[dof_of(body)]].map(|v| v.lane(0));
        (given / most, ((drive - yielding * speed) / most).clamp(-1.0, 1.0))
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
            let servo = &mut self.drives[body];
            let (zero, one) = (step.like(0.0), step.like(1.0));
            let held = servo.is_held();
            let is_near = low.less(near) | high.less(near) | zero.less(servo.watched);
            servo.watched = S::pick(is_near | held, one, zero);
            let is_near = is_near & !held;
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
        let hold = S::pick(is_near, self.drives[body].hold, zero);
        self.stops.push(Stop { body, start, count: path.len(), response, room, hold });
    }

    /// Applies the impulses that the rows start with.
    #[inline(always)]
    pub(super) fn warm_start(&self, y: &mut [S]) {
        for stop in &self.stops {
            self.apply(stop, y, stop.hold);
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
            // The speed without this limit: it holds what is beyond the one or the other end.
            let speed = speed - before * stop.response;
            let low = ((-stop.room.0 - speed) / stop.response).max(zero);
            let high = ((stop.room.1 - speed) / stop.response).min(zero);
            stop.hold = S::pick(open, low + high, before);
            let change = stop.hold - before;
            unrest.add(change * change * stop.response, stop.hold * stop.hold * stop.response);
            self.stops[place] = stop;
            self.apply(&stop, y, change);
        }
    }

    /// Remembers the impulses of the rows in the live lanes for the next solution.
    #[inline(always)]
    pub(super) fn remember(&mut self, live: S::Mask) {
        for servo in &mut self.drives {
            let zero = servo.drive.like(0.0);
            servo.hold = S::pick(live, zero, servo.hold);
        }
        for stop in &self.stops {
            let hold = &mut self.drives[stop.body].hold;
            *hold = S::pick(live, stop.hold, *hold);
        }
    }
}

/// A limit that is overstepped is mended by a fifth per step.
#[inline(always)]
fn soften<S: Scalar>(gap: S) -> S {
    S::pick(gap.less(gap.like(0.0)), gap * gap.like(0.2), gap)
}
