//! Hinge limits and torque limits as rows of the contact solver.
//!
//! The servo is an implicit spring-damper inside the mass matrix, so without
//! a limit it costs nothing. Its impulse in a step is
//! `drive - yielding * speed` with the speed at the end of the step. Where that
//! exceeds the torque limit, a slip impulse takes back the excess: torque limit
//! and contacts are solved together, and the limit holds after impacts too.

use super::factor::Factor;
use super::kinematics::State;
use super::scalar::Scalar;
use super::tree::{Tree, dof_of};

/// One hinge that is near a limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stop<S> {
    body: usize,
    start: usize,
    count: usize,
    /// What a unit impulse does to the hinge's speed.
    response: S,
    /// Speeds that would reach the low and the high limit in this step.
    room: (S, S),
    /// Impulses that hold the limits.
    hold: (S, S),
    /// Impulse that takes back the servo's excess.
    slip: S,
}

/// What a servo does in this step.
#[derive(Clone, Copy, Debug, Default)]
struct Drive<S> {
    /// Impulse at zero speed.
    drive: S,
    /// Impulse lost per speed.
    yielding: S,
    /// Largest impulse.
    most: S,
    /// Slip impulse of the last step.
    slip: S,
    /// Impulses that held the limits in the last step.
    hold: (S, S),
    /// Whether the servo was near its limit after the last step.
    busy: bool,
}

/// All hinges near a limit.
#[derive(Clone, Debug)]
pub(super) struct Joints<S> {
    stops: Vec<Stop<S>>,
    /// By body.
    drives: Vec<Drive<S>>,
    columns: Vec<S>,
    dofs: Vec<u32>,
}

impl<S: Scalar> Joints<S> {
    /// Room for all hinges of a tree.
    pub(super) fn new(tree: &Tree<S>) -> Self {
        let bodies = tree.links.len();
        Self {
            stops: Vec::with_capacity(bodies),
            drives: vec![Drive::default(); bodies],
            columns: Vec::with_capacity(tree.entries),
            dofs: Vec::with_capacity(tree.entries),
        }
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        self.drives.fill(Drive::default());
    }

    /// Adds the servos to the mass matrix and to the impulses of the step.
    pub(super) fn drive(
        &mut self,
        tree: &Tree<S>,
        state: &State<S>,
        targets: &[S],
        step: S,
        h: &mut [S],
        impulses: &mut [S],
    ) {
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let dof = dof_of(body);
            let servo = &mut self.drives[body];
            servo.drive = step * link.stiffness * (targets[body] - state.angles[body]);
            servo.yielding = step * (link.damping + step * link.stiffness);
            servo.most = step * link.torque;
            h[tree.rows[dof] + tree.path_to(dof).len() - 1] += servo.yielding;
            impulses[dof] += servo.drive - servo.yielding * state.speeds[dof];
        }
    }

    /// Makes rows for the hinges that come near a limit; `free` are the
    /// speeds that the step would end with if there were no contacts.
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
        let (half, rate) = (S::of(0.5), S::ONE / step);
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let servo = self.drives[body];
            let speed = free[dof_of(body)];
            let near = step * speed.abs() * (S::ONE + S::ONE) + S::of(0.02);
            let angle = state.angles[body];
            let (low, high) = (angle - link.limits.0, link.limits.1 - angle);
            let strained = (servo.drive - servo.yielding * speed).abs() > half * servo.most;
            let driven = servo.yielding > S::ZERO;
            if (driven && (strained || servo.busy)) || low < near || high < near {
                let room = (soften(low) * rate, soften(high) * rate);
                self.push(tree, factor, body, room);
            }
        }
    }

    fn push(&mut self, tree: &Tree<S>, factor: &Factor<S>, body: usize, room: (S, S)) {
        let path = tree.path(body);
        let start = self.columns.len();
        self.columns.resize(start + path.len(), S::ZERO);
        self.dofs.extend_from_slice(path);
        let columns = &mut self.columns[start..];
        columns[path.len() - 1] = S::ONE;
        let mut response = S::ZERO;
        for depth in (0..path.len()).rev() {
            let dof = path[depth] as usize;
            let own = columns[depth];
            for (column, &entry) in columns[..depth].iter_mut().zip(factor.row(tree, dof, depth)) {
                *column -= own * entry;
            }
            columns[depth] = own * factor.inverse[dof];
            response += columns[depth] * columns[depth];
        }
        let Drive { slip, hold, .. } = self.drives[body];
        self.stops.push(Stop { body, start, count: path.len(), response, room, hold, slip });
    }

    /// Applies the impulses that the rows start with.
    pub(super) fn warm_start(&self, y: &mut [S]) {
        for stop in &self.stops {
            self.apply(stop, y, stop.slip + stop.hold.0 - stop.hold.1);
        }
    }

    #[inline(always)]
    fn apply(&self, stop: &Stop<S>, y: &mut [S], impulse: S) {
        let span = stop.start..stop.start + stop.count;
        for (&column, &dof) in self.columns[span.clone()].iter().zip(&self.dofs[span]) {
            y[dof as usize] += column * impulse;
        }
    }

    /// One sweep over all rows.
    pub(super) fn sweep(&mut self, y: &mut [S]) {
        for place in 0..self.stops.len() {
            let mut stop = self.stops[place];
            let servo = &self.drives[stop.body];
            let span = stop.start..stop.start + stop.count;
            let mut speed = S::ZERO;
            for (&column, &dof) in self.columns[span.clone()].iter().zip(&self.dofs[span]) {
                speed += column * y[dof as usize];
            }
            let begin = speed;
            let slip = stop.slipping(servo, speed);
            speed += (slip - stop.slip) * stop.response;
            let low = (stop.hold.0 - (speed + stop.room.0) / stop.response).max(S::ZERO);
            speed += (low - stop.hold.0) * stop.response;
            let high = (stop.hold.1 + (speed - stop.room.1) / stop.response).max(S::ZERO);
            speed -= (high - stop.hold.1) * stop.response;
            (stop.slip, stop.hold) = (slip, (low, high));
            self.stops[place] = stop;
            self.apply(&stop, y, (speed - begin) / stop.response);
        }
    }

    /// Remembers the impulses and which servos are near their limits.
    pub(super) fn remember(&mut self, speeds: &[S]) {
        let half = S::of(0.5);
        for (body, servo) in self.drives.iter_mut().enumerate().skip(1) {
            let impulse = servo.drive - servo.yielding * speeds[dof_of(body)];
            servo.busy = impulse.abs() > half * servo.most;
            (servo.slip, servo.hold) = (S::ZERO, (S::ZERO, S::ZERO));
        }
        for stop in &self.stops {
            let servo = &mut self.drives[stop.body];
            (servo.slip, servo.hold) = (stop.slip, stop.hold);
        }
    }
}

impl<S: Scalar> Stop<S> {
    /// The slip impulse at which the servo's torque keeps to its limit: the
    /// smallest, so that it is zero inside.
    #[inline(always)]
    fn slipping(&self, servo: &Drive<S>, speed: S) -> S {
        // A unit of slip lowers the servo's own impulse by `given`; very stiff
        // servos on light links leave little, and rounding must not make it zero.
        let given = servo.yielding * self.response;
        let kept = (S::ONE - given).max(S::of(1e-3));
        let total = servo.drive - servo.yielding * speed + given * self.slip;
        if total > servo.most {
            (servo.most - total) / kept
        } else if total < -servo.most {
            (-servo.most - total) / kept
        } else {
            S::ZERO
        }
    }
}

/// A limit that is overstepped is mended by a fifth per step.
#[inline(always)]
fn soften<S: Scalar>(gap: S) -> S {
    if gap < S::ZERO { gap * S::of(0.2) } else { gap }
}
