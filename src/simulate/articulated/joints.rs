//! Servos with their torque limits, and the hard limits of hinges.
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
use super::scalar::Scalar;
use super::tree::{Tree, dof_of};

/// A servo over its limit by less than this share is let pass.
const TOLERANCE: f64 = 1e-3;

/// One hinge that is near a hard limit.
#[derive(Clone, Copy, Debug)]
struct Stop<S> {
    body: usize,
    start: usize,
    count: usize,
    /// What a unit impulse does to the hinge's speed.
    response: S,
    /// Speeds that would reach the low and the high limit in this step.
    room: (S, S),
    /// Impulses that hold the limits.
    hold: (S, S),
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
    /// The sign of its impulse if it is at its limit, else zero.
    strained: S,
    /// The impulse that acted when the step was last solved.
    given: S,
    /// Impulses that held the hard limits in the last step.
    hold: (S, S),
}

/// All hinges.
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

    /// Computes what the servos do at the state and targets of this step.
    pub(super) fn prepare(&mut self, tree: &Tree<S>, state: &State<S>, targets: &[S], step: S) {
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let servo = &mut self.drives[body];
            servo.drive = step * link.stiffness * (targets[body] - state.angles[body]);
            servo.yielding = step * (link.damping + step * link.stiffness);
            servo.most = step * link.torque;
        }
    }

    /// Adds the servos to the mass matrix and to the impulses of the step.
    pub(super) fn drive(&self, tree: &Tree<S>, state: &State<S>, h: &mut [S], impulses: &mut [S]) {
        for (body, servo) in self.drives.iter().enumerate().skip(1) {
            let dof = dof_of(body);
            if servo.strained == S::ZERO {
                h[tree.rows[dof] + tree.path_to(dof).len() - 1] += servo.yielding;
                impulses[dof] += servo.drive - servo.yielding * state.speeds[dof];
            } else {
                impulses[dof] += servo.strained * servo.most;
            }
        }
    }

    /// Corrects which servos are at their limit, from the speeds at the end of
    /// the step; true if that changes the step. Unless `release`, servos only
    /// come to be at their limit, so that the search ends.
    pub(super) fn review(&mut self, speeds: &[S], release: bool) -> bool {
        let mut changed = false;
        for (body, servo) in self.drives.iter_mut().enumerate().skip(1) {
            let impulse = servo.drive - servo.yielding * speeds[dof_of(body)];
            // Before the flag changes: what it says now is what was solved with.
            servo.given = if servo.strained == S::ZERO { impulse } else { servo.strained * servo.most };
            if servo.strained == S::ZERO {
                if impulse.abs() > servo.most * S::of(1.0 + TOLERANCE) {
                    servo.strained = if impulse > S::ZERO { S::ONE } else { -S::ONE };
                    changed = true;
                }
            } else if release && impulse * servo.strained < servo.most {
                servo.strained = S::ZERO;
                changed = true;
            }
        }
        changed
    }

    /// The impulse of a body's servo in the step that was solved last.
    #[inline(always)]
    pub(super) fn impulse(&self, body: usize) -> S {
        self.drives[body].given
    }

    /// Makes rows for the hinges that come near a hard limit; `free` are the
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
        let rate = S::ONE / step;
        for (body, link) in tree.links.iter().enumerate().skip(1) {
            let near = step * free[dof_of(body)].abs() * S::of(2.0) + S::of(0.02);
            let angle = state.angles[body];
            let (low, high) = (angle - link.limits.0, link.limits.1 - angle);
            if low < near || high < near {
                self.push(tree, factor, body, (soften(low) * rate, soften(high) * rate));
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
        let hold = self.drives[body].hold;
        self.stops.push(Stop { body, start, count: path.len(), response, room, hold });
    }

    /// Applies the impulses that the rows start with.
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

    /// One sweep over all rows.
    pub(super) fn sweep(&mut self, y: &mut [S]) {
        for place in 0..self.stops.len() {
            let mut stop = self.stops[place];
            let span = stop.start..stop.start + stop.count;
            let mut speed = S::ZERO;
            for (&column, &dof) in self.columns[span.clone()].iter().zip(&self.dofs[span]) {
                speed += column * y[dof as usize];
            }
            let before = stop.hold;
            stop.hold.0 = (before.0 - (speed + stop.room.0) / stop.response).max(S::ZERO);
            let up = stop.hold.0 - before.0;
            speed += up * stop.response;
            stop.hold.1 = (before.1 + (speed - stop.room.1) / stop.response).max(S::ZERO);
            let down = stop.hold.1 - before.1;
            self.stops[place] = stop;
            self.apply(&stop, y, up - down);
        }
    }

    /// Remembers the impulses for the next solution.
    pub(super) fn remember(&mut self) {
        for servo in &mut self.drives {
            servo.hold = (S::ZERO, S::ZERO);
        }
        for stop in &self.stops {
            self.drives[stop.body].hold = stop.hold;
        }
    }
}

/// A limit that is overstepped is mended by a fifth per step.
#[inline(always)]
fn soften<S: Scalar>(gap: S) -> S {
    if gap < S::ZERO { gap * S::of(0.2) } else { gap }
}
