//! Links between bodies: six springs and dampers where two bodies meet, implicit in the step.
//!
//! A piece of a beam is a geometrically exact beam element that bends in its middle: it stretches, shears, bends about two axes and
//! twists (Simo, A Finite Strain Beam Formulation, 1985; with one point per element, as in Wittbrodt, Adamiec-Wojcik and Wojciech,
//! Dynamics of Flexible Multibody Systems, 2006). A joint of the assembly has stiff springs in place of what it holds.

use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3, Vector6};

use super::section::{POISSON, Section};
use super::turns;
use crate::design::assembly::{Control, Dof, Travel};

/// Where a body is, and how it moves. Rotations are from rest; axes are the world's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The centre of mass, m.
    pub(super) centre: Vector3<f64>,
    pub(super) turn: UnitQuaternion<f64>,
    /// m/s.
    pub(super) velocity: Vector3<f64>,
    /// rad/s.
    pub(super) spin: Vector3<f64>,
}

/// How stiff what holds must be, in N/m for each kg of the body: it gives way by a micrometre under the weight.
const HOLD: f64 = 1e7;
/// Squared lever, m^2, that makes a stiffness against turning of one against shifting.
const LEVER: f64 = 1e-3;

/// What overlaps, or lies beyond the end of a range, is mended by this share of it in a step.
pub(super) const MEND: f64 = 0.2;

/// An end that is passed by less than this share of the speed towards it is not passed.
const BEYOND: f64 = 1e-9;

/// What drives a beam may differ from what it asks for at the end of the step by this share of its limit: the step is solved once.
const UNFORESEEN: f64 = 0.1;

/// How an end of a link's range takes part in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum EndState {
    /// Not at all: the link must not reach it.
    #[default]
    Free,
    /// The link is at it: a part of the step's matrix.
    Held,
    /// It is solved with the contacts: it pushes and does not pull, and which of the two follows from what else happens.
    Swept,
}

/// An end of a link's range, as a condition on the speed at the end of a step: it goes no faster towards it than the room that is left, and
/// is only pushed away from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    /// 1 at the low end, -1 at the high one: which way is away from it.
    pub(super) away: f64,
    /// The least speed away, rad/s or m/s.
    pub(super) least: f64,
}

impl End {
    /// An end with so much room, rad or m; negative beyond it.
    fn new(away: f64, room: f64, step: f64) -> Self {
        let least = if room > 0.0 { -room / step } else { -room * MEND / step };
        Self { away, least }
    }
}

/// Which of a link's limits are active in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ActiveSet {
    /// Whether the motor gives all it has.
    pub(super) is_spent: bool,
    /// The low end of the range, and the high one.
    pub(super) stops: [EndState; 2],
}

/// What moves a link along what is driven or free of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drive {
    /// A spring about a target.
    Position,
    /// A damper about a speed.
    Speed,
    /// Its own spring: about the target, which does not move.
    Own,
}

/// What a drive does in a step, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Work {
    /// Where it pushes, at a speed that changes evenly within the step.
    pub(super) positive: f64,
    /// Impulse times the speed after the step. An implicit step gains less kinetic energy than this.
    pub(super) allowed: f64,
}

/// A link between a body and its parent.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) body: usize,
    pub(super) parent: usize,
    /// From the centre of each body to where they meet, at rest: the parent's first.
    arms: [Vector3<f64>; 2],
    /// The axes of the link, at rest: the driven one is the first.
    frame: Matrix3<f64>,
    /// Against turning about each axis, N m/rad, then against shifting along each, N/m.
    stiffness: [f64; 6],
    damping: [f64; 6],
    /// Which of the six the drive moves.
    driven: usize,
    drive: Drive,
    /// The greatest torque or force of the drive.
    effort: f64,
    limits: (f64, f64),
    /// How an end of its range is held, N m s/rad for each s of a step, or N s/m.
    hold: f64,
    /// Whether it is a piece of a beam: then it turns by little, about any axis.
    is_beam: bool,
    /// Which target it follows, and how many times that.
    pub(super) servo: usize,
    pub(super) share: f64,
}

/// What a link does in a step.
#[derive(Clone, Debug)]
pub(super) struct Action {
    /// Where it acts, m.
    at: Vector3<f64>,
    /// Its axes now.
    axes: Matrix3<f64>,
    /// How fast what is driven moves where the step begins, rad/s or m/s.
    began: f64,
    /// Its deformation: turns in rad, then shifts in m.
    pub(super) deformation: [f64; 6],
    /// Of the springs where the step begins, on the child.
    effort: [f64; 6],
    stiffness: [f64; 6],
    damping: [f64; 6],
    /// What drives it, if anything does.
    pub(super) motor: Option<Motor>,
    /// Whether that is solved with the contacts.
    pub(super) is_swept: bool,
    /// The ends of its range, low and high.
    pub(super) ends: [Option<End>; 2],
}

/// A drive with a limit, as a condition on the speed at the end of a step: impulse = -(offset + speed) x slope, within the limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motor {
    /// rad/s or m/s.
    pub(super) offset: f64,
    /// N m s per rad/s, or N s per m/s.
    pub(super) slope: f64,
    /// The greatest impulse, N m s or N s.
    pub(super) most: f64,
}

impl Motor {
    /// None where nothing pushes.
    fn new(effort: f64, (stiffness, damping): (f64, f64), most: f64, step: f64) -> Option<Self> {
        let slope = stiffness * step + damping;
        (slope > 0.0).then(|| Self { offset: effort / slope, slope: slope * step, most: most * step })
    }

    /// What it gives at a speed at the end of the step, if it has so much, N m s or N s.
    pub(super) fn impulse(self, speed: f64) -> f64 {
        -(self.offset + speed) * self.slope
    }
}

impl Link {
    /// A piece of a beam, so long in m, whose row has so many hinges and is cut into so many links.
    pub(super) fn elastic(
        (parent, body): (usize, usize),
        arms: [Vector3<f64>; 2],
        (dof, way): (&Dof, &Vector3<f64>),
        section: &Section,
        (hinges, links, length): (usize, usize, f64),
    ) -> Self {
        // Springs in a row: the row as a whole is as stiff as its hinges are together.
        let times = links as f64 / hinges as f64;
        let bending = dof.stiffness * times;
        let young = bending * length / section.driven;
        let shear = young / (2.0 * (1.0 + POISSON));
        let across = shear * section.shear * section.area / length;
        let stiffness = [
            bending,
            dof.torsion.map_or(shear * section.torsion / length, |torsion| torsion * times),
            dof.sideways.map_or(young * section.sideways / length, |sideways| sideways * times),
            across,
            young * section.area / length,
            across,
        ];
        let axis = dof.axis.into_inner();
        Self {
            body,
            parent,
            arms,
            frame: Matrix3::from_columns(&[axis, *way, axis.cross(way)]),
            stiffness,
            damping: stiffness.map(|stiffness| stiffness * dof.damping / dof.stiffness),
            driven: 0,
            drive: Drive::Position,
            effort: dof.effort,
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            hold: 0.0,
            is_beam: true,
            servo: 0,
            share: hinges as f64 / links as f64,
        }
    }

    /// The same, so many times as stiff but for what is driven.
    pub(super) fn stiffened(mut self, times: f64) -> Self {
        for axis in (0..6).filter(|axis| *axis != self.driven) {
            self.stiffness[axis] *= times;
            self.damping[axis] *= times;
        }
        self
    }

    /// A joint of the assembly, of a body of a mass in kg.
    pub(super) fn joint(
        (parent, body): (usize, usize),
        arms: [Vector3<f64>; 2],
        dof: &Dof,
        mass: f64,
    ) -> Self {
        let hold = HOLD * mass;
        let mut stiffness = [hold * LEVER, hold * LEVER, hold * LEVER, hold, hold, hold];
        let mut damping = [0.0; 6];
        let driven = match dof.travel {
            Travel::Turn => 0,
            Travel::Slide => 3,
        };
        let hold = stiffness[driven];
        stiffness[driven] = if dof.is_spun() { 0.0 } else { dof.stiffness };
        damping[driven] = dof.damping;
        let axis = dof.axis.into_inner();
        let across = axis.cross(&Vector3::ith(axis.abs().imin(), 1.0)).normalize();
        let drive = match dof.control {
            Control::Position { .. } => Drive::Position,
            Control::Speed { .. } => Drive::Speed,
            Control::Passive { .. } => Drive::Own,
        };
        Self {
            body,
            parent,
            arms,
            frame: Matrix3::from_columns(&[axis, across, axis.cross(&across)]),
            stiffness,
            damping,
            driven,
            drive,
            effort: dof.effort,
            limits: dof.limits,
            hold,
            is_beam: false,
            servo: 0,
            share: 1.0,
        }
    }

    /// Which of its deformations is driven or free.
    pub(super) fn driven(&self) -> usize {
        self.driven
    }

    /// The ends of its range, low then high, from where it stands, rad or m; none where it has no end.
    fn ends(&self, at: f64, step: f64) -> [Option<End>; 2] {
        let rooms = [(1.0, at - self.limits.0), (-1.0, self.limits.1 - at)];
        rooms.map(|(away, room)| room.is_finite().then(|| End::new(away, room, step)))
    }

    /// Whether an actuator moves it.
    pub(super) fn is_driven(&self) -> bool {
        self.drive != Drive::Own
    }

    /// Whether an actuator gives it a speed.
    pub(super) fn is_spun(&self) -> bool {
        self.drive == Drive::Speed
    }

    /// How it is deformed where a step begins, where it acts, and its axes there. An angle is as near as can be to that before.
    #[inline(always)]
    fn deformed(&self, parent: &Place, body: &Place, before: f64) -> ([f64; 6], Vector3<f64>, Matrix3<f64>) {
        let ends = [parent.centre + parent.turn * self.arms[0], body.centre + body.turn * self.arms[1]];
        let between = parent.turn.inverse() * body.turn;
        let (turned, axes) = if self.is_beam {
            let vector = turns::vector(&between);
            let half = parent.turn * turns::by(&(vector * 0.5));
            (self.frame.tr_mul(&vector), half.to_rotation_matrix() * self.frame)
        } else {
            let axes = parent.turn.to_rotation_matrix() * self.frame;
            let axis = self.frame.column(0).into_owned();
            let (angle, rest) = turns::about(&between, &axis, before);
            let mut turned = self.frame.tr_mul(&rest);
            turned.x += angle;
            (turned, axes)
        };
        let shifted = axes.tr_mul(&(ends[1] - ends[0]));
        let deformation = [turned.x, turned.y, turned.z, shifted.x, shifted.y, shifted.z];
        (deformation, (ends[0] + ends[1]) * 0.5, axes)
    }

    /// Whether it is a piece of a beam.
    pub(super) fn is_elastic(&self) -> bool {
        self.is_beam
    }

    /// Where it stands along what is driven or free, rad or m; an angle is as near as can be to that before.
    pub(super) fn position(&self, parent: &Place, body: &Place, before: f64) -> f64 {
        self.deformed(parent, body, before).0[self.driven]
    }

    /// What it does in a step that begins here, towards a target.
    #[inline(always)]
    pub(super) fn act(
        &self,
        (parent, body): (&Place, &Place),
        (target, before): (f64, f64),
        known: ActiveSet,
        step: f64,
    ) -> Action {
        let (deformation, at, axes) = self.deformed(parent, body, before);
        let (mut stiffness, mut damping) = (self.stiffness, self.damping);
        let mut effort: [f64; 6] = std::array::from_fn(|axis| stiffness[axis] * deformation[axis]);
        let own = self.driven;
        let mut action = Action {
            at,
            axes,
            began: 0.0,
            deformation,
            effort,
            stiffness,
            damping,
            motor: None,
            is_swept: false,
            ends: [None; 2],
        };
        let rate = action.rates(parent, body)[own];
        action.began = rate;
        effort[own] = match self.drive {
            Drive::Position | Drive::Own => stiffness[own] * (deformation[own] - target),
            Drive::Speed => -damping[own] * target,
        };
        if self.is_beam {
            // At its limit, what drives does not depend on how the body moves. The damping of a beam is that of its material, which has none.
            action.motor = Motor::new(effort[own], (stiffness[own], 0.0), self.effort, step);
            let foreseen = effort[own] + stiffness[own] * step * rate;
            if known.is_spent {
                action.is_swept = action.motor.is_some();
                (effort[own], stiffness[own]) = (0.0, 0.0);
            } else if foreseen.abs() > self.effort {
                effort[own] = self.effort.copysign(foreseen);
                stiffness[own] = 0.0;
            }
        } else {
            if self.is_driven() {
                action.motor = Motor::new(effort[own], (stiffness[own], damping[own]), self.effort, step);
                // At its limit, a motor turns so little mass that it would shoot beyond what it is asked for within a step: it is solved with
                // the contacts. Only then: sweeps hardly converge for several strong motors in a row.
                if known.is_spent {
                    action.is_swept = action.motor.is_some();
                    (effort[own], stiffness[own], damping[own]) = (0.0, 0.0, 0.0);
                }
            }
            action.ends = self.ends(deformation[own], step);
            for (end, stop) in action.ends.iter().zip(known.stops) {
                if let (Some(end), EndState::Held) = (end, stop) {
                    let hold = self.hold * step;
                    effort[own] -= hold * end.least * end.away;
                    damping[own] += hold;
                }
            }
        }
        (action.effort, action.stiffness, action.damping) = (effort, stiffness, damping);
        action
    }

    /// The energy of its springs, J, but for what a drive moves.
    #[inline(always)]
    pub(super) fn energy(&self, action: &Action, target: f64) -> f64 {
        let mut sum = 0.0;
        for axis in 0..6 {
            let by = action.deformation[axis];
            sum += match (axis == self.driven, self.drive) {
                (true, Drive::Position | Drive::Speed) => 0.0,
                (true, Drive::Own) => 0.5 * self.stiffness[axis] * (by - target) * (by - target),
                (false, _) => 0.5 * self.stiffness[axis] * by * by,
            };
        }
        sum
    }

    /// How fast what is driven or free of it moves in a step after which the bodies move so, rad/s or m/s.
    #[inline(always)]
    pub(super) fn rate(&self, action: &Action, parent: &Place, body: &Place) -> f64 {
        action.rates(parent, body)[self.driven]
    }

    /// Revises what was known of a step that was solved, by the rate that was found. Whether it must be solved again.
    #[inline(always)]
    pub(super) fn revise(&self, action: &Action, rate: f64, known: &mut ActiveSet, step: f64) -> bool {
        let mut again = false;
        if let Some(motor) = action.motor.filter(|_| !action.is_swept) {
            let asked = motor.impulse(rate);
            let overdoes = if self.is_beam {
                let given = -self.spring(action, rate, step) * step;
                (asked.clamp(-motor.most, motor.most) - given).abs() > UNFORESEEN * motor.most
            } else {
                asked.abs() > motor.most
            };
            known.is_spent |= overdoes;
            again |= overdoes;
        }
        for (end, stop) in action.ends.iter().zip(&mut known.stops) {
            let Some(end) = end else { continue };
            let missing = end.least - end.away * rate;
            let next = match stop {
                EndState::Free if missing > BEYOND * end.least.abs().max(step) => EndState::Held,
                // It does not pull.
                EndState::Held if missing < 0.0 => EndState::Swept,
                EndState::Free | EndState::Held | EndState::Swept => continue,
            };
            *stop = next;
            again = true;
        }
        again
    }

    /// What the spring that drives it gives in the matrix at the end of a step after which it moves so, N m or N, against its deformation.
    #[inline(always)]
    fn spring(&self, action: &Action, rate: f64, step: f64) -> f64 {
        action.effort[self.driven] + action.stiffness[self.driven] * step * rate
    }

    /// What its drive does in a step after which the bodies move so. Of a motor, by the impulse that it gave: computed from the speed, it
    /// would differ by all that the contacts have not converged, times a stiff motor's damping.
    #[inline(always)]
    pub(super) fn work(&self, action: &Action, given: f64, parent: &Place, body: &Place, step: f64) -> Work {
        let own = self.driven;
        let rate = self.rate(action, parent, body);
        let impulse = match action.motor {
            // The damping of its material stays in the matrix.
            _ if self.is_beam => {
                let swept = if action.is_swept { given } else { 0.0 };
                swept - (self.spring(action, rate, step) + action.damping[own] * rate) * step
            }
            Some(_) if action.is_swept => given,
            Some(motor) => motor.impulse(rate),
            None => 0.0,
        };
        let (first, last) = (impulse * action.began, impulse * rate);
        let pushed = first.max(0.0) + last.max(0.0);
        // Where the joint turns round within the step, it pushes for a part of it.
        let share = if pushed > 0.0 { pushed / (first.abs() + last.abs()) } else { 0.0 };
        Work { positive: 0.5 * pushed * share, allowed: last }
    }

    /// How the speed of what is driven follows from those of the two bodies, the child's first: along their velocities and spins.
    pub(super) fn along(&self, action: &Action, parent: &Place, body: &Place) -> [Vector6<f64>; 2] {
        let column = |axis: usize| action.axes.column(axis).into_owned();
        let on = |place: &Place, sign: f64| {
            let (way, turn) = if self.driven < 3 {
                (Vector3::zeros(), column(self.driven))
            } else {
                let way = column(self.driven - 3);
                (way, (action.at - place.centre).cross(&way))
            };
            Vector6::new(way.x, way.y, way.z, turn.x, turn.y, turn.z) * sign
        };
        [on(body, 1.0), on(parent, -1.0)]
    }
}

impl Action {
    /// How fast it deforms when its bodies move so.
    #[inline(always)]
    pub(super) fn rates(&self, parent: &Place, body: &Place) -> [f64; 6] {
        let moves = |place: &Place| place.velocity + place.spin.cross(&(self.at - place.centre));
        let turns = self.axes.tr_mul(&(body.spin - parent.spin));
        let shifts = self.axes.tr_mul(&(moves(body) - moves(parent)));
        [turns.x, turns.y, turns.z, shifts.x, shifts.y, shifts.z]
    }

    /// The impulses of the springs on the child and on the parent: force first, then torque about the centre.
    #[inline(always)]
    pub(super) fn impulses(&self, parent: &Place, body: &Place, step: f64) -> [Vector6<f64>; 2] {
        let [a, b, c, d, e, f] = self.effort;
        let torque = self.axes * Vector3::new(a, b, c) * -step;
        let force = self.axes * Vector3::new(d, e, f) * -step;
        let on = |place: &Place, sign: f64| {
            let turning = (self.at - place.centre).cross(&force) + torque;
            Vector6::new(force.x, force.y, force.z, turning.x, turning.y, turning.z) * sign
        };
        [on(body, 1.0), on(parent, -1.0)]
    }

    /// What it adds to the matrix of a step: to the block of the child, to that of the parent, and between the two.
    #[inline(always)]
    pub(super) fn matrices(&self, parent: &Place, body: &Place, step: f64) -> [Matrix6<f64>; 3] {
        let each = |axis: usize| (self.stiffness[axis] * step + self.damping[axis]) * step;
        let in_world = |first: usize| {
            let diagonal =
                Matrix3::from_diagonal(&Vector3::new(each(first), each(first + 1), each(first + 2)));
            self.axes * diagonal * self.axes.transpose()
        };
        let (turning, shifting) = (in_world(0), in_world(3));
        let levers = [body, parent].map(|place| (self.at - place.centre).cross_matrix());
        // A point moves by velocity plus spin times arm: the cross product the other way round.
        let block = |left: &Matrix3<f64>, right: &Matrix3<f64>| {
            let mut block = Matrix6::zeros();
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&shifting);
            block.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-shifting * right));
            block.fixed_view_mut::<3, 3>(3, 0).copy_from(&(left * shifting));
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(&(turning - left * shifting * right));
            block
        };
        [block(&levers[0], &levers[0]), block(&levers[1], &levers[1]), -block(&levers[0], &levers[1])]
    }
}
