//! What the solvers share: driving, checking and recording runs.

use std::sync::Arc;

use std::cell::OnceCell;

use nalgebra::{Isometry3, Vector3};

use super::feedback::{ControlLoop, Controller, Earlier, Measured, Observable};
use super::motion::{Placement, pose_between};
use super::schedule::Schedule;
use super::servo::{Bends, Servo};
use super::{Case, Invalid, LAST_STRETCH, Motion, Settings, Stop, Targets, Watch, World};
use crate::design::assembly::Dof;

/// A solver that advances one body step by step, in one or several runs at
/// once, its *lanes*. What moves is either the joints of a
/// [`Lowered`](super::lowering::Lowered) assembly, of which joint j carries body j + 1, or the strains of
/// a [`Lattice`](super::lattice::Lattice): then "joint" stands for an actuator, and its position for its strain.
pub(super) trait Stepper: Send {
    /// Number of runs at once.
    const LANES: usize;
    /// Back to the state at rest, bit for bit.
    fn reset(&mut self);
    /// Sets the target of a servo for the next step of a lane, rad, m or rad/s.
    fn aim(&mut self, lane: usize, servo: usize, target: f64);
    /// Moves all lanes on by one step.
    fn step(&mut self);
    /// What has gone wrong in a lane since the last reset.
    fn failure(&self, lane: usize) -> Option<Invalid>;
    /// The pose of a body in the world, m.
    fn pose(&self, lane: usize, body: usize) -> Isometry3<f64>;
    /// The position of a joint, rad or m; of one whose speed is driven that speed, rad/s.
    fn position(&self, lane: usize, joint: usize) -> f64;
    /// The mechanical work that has been done at a joint since the last reset, J:
    /// the torque that acted times the turn of the joint (or the force times its way), step by step, where
    /// that is positive.
    fn work(&self, lane: usize, joint: usize) -> f64;
    /// How fast a joint moves, rad/s or m/s. None where that is not known.
    fn rate(&self, lane: usize, joint: usize) -> Option<f64> {
        let _ = (lane, joint);
        None
    }
    /// The velocity of a body's origin, m/s, and its angular velocity, rad/s, in the axes of the world. None where that is not known.
    fn velocity(&self, lane: usize, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let _ = (lane, body);
        None
    }
    /// The force with which the ground carries an element, N, in the mean over the last step. None where that is not known.
    fn load(&self, lane: usize, element: usize) -> Option<f64> {
        let _ = (lane, element);
        None
    }
}

/// So many steps between two looks at whether to stop: milliseconds at most.
const STEPS_PER_LOOK: usize = 16;

/// What is driven and recorded of a body.
#[derive(Clone, Debug)]
pub(super) struct Driven {
    /// The servos at rest.
    servos: Vec<Servo>,
    /// The actuator of each joint, if one drives it.
    joints: Vec<Option<usize>>,
    bends: Bends,
    placements: Arc<[Placement]>,
    bodies: usize,
    actuators: usize,
}

impl Driven {
    /// The joints of so many bodies.
    pub(super) fn joints(
        dofs: &[&Dof],
        servos: &[Servo],
        bodies: usize,
        actuators: usize,
        placements: Arc<[Placement]>,
    ) -> Self {
        Self {
            servos: servos.to_vec(),
            joints: dofs.iter().map(|dof| dof.actuator()).collect(),
            bends: Bends::new(dofs, actuators),
            placements,
            bodies,
            actuators,
        }
    }

    /// The strains of so many actuators, of bodies that are one element each.
    pub(super) fn strains(actuators: usize, placements: Arc<[Placement]>) -> Self {
        Self {
            servos: (0..actuators).map(Servo::free).collect(),
            joints: (0..actuators).map(Some).collect(),
            bends: Bends::themselves(actuators),
            bodies: placements.len(),
            placements,
            actuators,
        }
    }
}

/// One body in a row of worlds, ready to run: a solver with one lane for each.
pub(super) trait Row: Send {
    /// Simulates as many cases as there are lanes, or fewer, each in the world of its lane, the first of which has this
    /// number for the watch. None if it was asked to stop.
    fn together(
        &mut self,
        stop: Stop<'_>,
        first: usize,
        cases: &[Case<'_>],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>>;
}

/// A row of a solver.
#[derive(Debug)]
pub(super) struct Run<S> {
    stepper: S,
    driven: Driven,
    /// Factor of the rates of servos, by lane.
    speeds: Vec<f64>,
    schedule: Schedule,
    pace_limit: Option<f64>,
}

/// One run under way.
struct Lane<'a> {
    drive: &'a Targets,
    feedback: Option<Feedback<'a>>,
    servos: Vec<Servo>,
    motion: Motion,
    failure: Option<Invalid>,
}

/// A controller at work in a lane.
struct Feedback<'a> {
    controller: &'a dyn Controller,
    own: Box<dyn ControlLoop + 'a>,
    /// What it last asked each actuator for.
    commands: Vec<f64>,
    /// How often it was asked.
    moments: usize,
    /// Where the body was when it was last asked.
    earlier: Option<Earlier>,
}

impl Feedback<'_> {
    /// Whether a control moment has come at a time, s.
    fn is_due(&self, time: f64) -> bool {
        let moment = self.moments as f64 * self.controller.interval();
        time >= moment - 1e-9 * moment.max(1.0)
    }
}

impl Lane<'_> {
    /// What an actuator is asked for at a time.
    fn asked(drive: &Targets, feedback: Option<&Feedback<'_>>, actuator: usize, t: f64) -> f64 {
        match feedback {
            Some(feedback) if feedback.controller.commands(actuator) => {
                feedback.commands.get(actuator).copied().unwrap_or(0.0)
            }
            _ => drive.asked(actuator, t),
        }
    }
}

/// So many steps at rest tell what the ground carries before a motion begins: the first one has not its whole weight yet.
const AT_REST: usize = 4;

/// What is known of a lane between two steps.
struct Now<'a, S> {
    stepper: &'a S,
    /// What the ground carries before the first step.
    at_rest: Option<&'a [Option<f64>]>,
    driven: &'a Driven,
    lane: usize,
    positions: OnceCell<Vec<f64>>,
    rates: OnceCell<Vec<f64>>,
}

impl<S: Stepper> Observable for Now<'_, S> {
    fn pose(&self, body: usize) -> Isometry3<f64> {
        self.stepper.pose(self.lane, body)
    }

    fn velocity(&self, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        self.stepper.velocity(self.lane, body)
    }

    fn positions(&self) -> &[f64] {
        self.positions.get_or_init(|| {
            let mut along = Vec::with_capacity(self.driven.actuators);
            let joints = 0..self.driven.joints.len();
            self.driven.bends.append(joints.map(|joint| self.stepper.position(self.lane, joint)), &mut along);
            along
        })
    }

    fn rates(&self) -> &[f64] {
        self.rates.get_or_init(|| {
            let joints = 0..self.driven.joints.len();
            let rates: Option<Vec<f64>> = joints.map(|joint| self.stepper.rate(self.lane, joint)).collect();
            rates.map_or_else(Vec::new, |rates| self.driven.bends.rates(rates.into_iter()))
        })
    }

    fn load(&self, element: usize) -> Option<f64> {
        match self.at_rest {
            Some(loads) => loads.get(element).copied().flatten(),
            None => self.stepper.load(self.lane, element),
        }
    }
}

/// What is recorded of a lane at one time: the pose of every body, and the position of every joint.
struct State {
    poses: Vec<Isometry3<f64>>,
    positions: Vec<f64>,
}

impl State {
    /// The state when a share of a step has passed, which led from another state to this one.
    fn within(self, before: &Self, share: f64) -> Self {
        let pose = |(from, to): (&Isometry3<f64>, &Isometry3<f64>)| pose_between(from, to, share);
        let position = |(from, to): (&f64, &f64)| from + (to - from) * share;
        Self {
            poses: before.poses.iter().zip(&self.poses).map(pose).collect(),
            positions: before.positions.iter().zip(&self.positions).map(position).collect(),
        }
    }
}

impl<S: Stepper> Run<S> {
    /// Runs of a solver made for the same assembly, settings and worlds.
    pub(super) fn new(stepper: S, driven: Driven, settings: &Settings, worlds: &[World]) -> Self {
        let speeds = worlds.iter().map(|world| world.speed).collect();
        Self { stepper, driven, speeds, schedule: Schedule::new(settings), pace_limit: settings.pace_limit }
    }

    fn lane<'a>(&self, number: usize, case: &Case<'a>) -> Lane<'a> {
        let Schedule { interval, duration, frames, .. } = self.schedule;
        let Driven { bodies, actuators, ref placements, ref servos, .. } = self.driven;
        let motion = Motion {
            interval,
            duration,
            bodies,
            poses: Vec::with_capacity(frames * bodies),
            bends: Vec::with_capacity(frames * actuators),
            work: vec![0.0; actuators],
            commands: case.controller.map(|controller| Targets {
                interval: controller.interval(),
                actuators,
                angles: Vec::new(),
            }),
            placements: Arc::clone(placements),
        };
        let speed = self.speeds.get(number).copied().unwrap_or(1.0);
        let servos = servos.iter().map(|servo| servo.faster(speed)).collect();
        let feedback = case.controller.map(|controller| Feedback {
            controller,
            own: controller.begin(),
            commands: vec![0.0; actuators],
            moments: 0,
            earlier: None,
        });
        Lane { drive: case.drive, feedback, servos, motion, failure: None }
    }

    /// Shows the watch what has been recorded, once in a second of the motion.
    fn look(&self, lanes: &mut [Lane], first: usize, frames: usize, watch: &dyn Watch) {
        let Schedule { interval, duration, .. } = self.schedule;
        let (before, now) = (frames.saturating_sub(2) as f64 * interval, (frames - 1) as f64 * interval);
        if libm::floor(now + 1e-9) <= libm::floor(before + 1e-9) || now > duration - LAST_STRETCH {
            return;
        }
        for (number, lane) in lanes.iter_mut().enumerate() {
            if lane.failure.is_none() && watch.gives_up(first + number, &lane.motion, now) {
                lane.failure = Some(Invalid::GivenUp);
            }
        }
    }

    /// Asks the controllers whose moment has come, before a step from this time on.
    fn control(&self, lanes: &mut [Lane], time: f64, at_rest: &[Vec<Option<f64>>]) {
        for (number, lane) in lanes.iter_mut().enumerate() {
            let Some(feedback) = lane.feedback.as_mut().filter(|own| own.is_due(time)) else { continue };
            // A step that is longer than the interval passes several moments at once.
            while feedback.is_due(time) {
                feedback.moments += 1;
            }
            if lane.failure.is_some() {
                continue;
            }
            let known = Now {
                stepper: &self.stepper,
                at_rest: at_rest.get(number).filter(|_| time <= 0.0).map(Vec::as_slice),
                driven: &self.driven,
                lane: number,
                positions: OnceCell::new(),
                rates: OnceCell::new(),
            };
            let placements = &self.driven.placements;
            let measured = Measured { time, known: &known, placements, earlier: feedback.earlier.as_ref() };
            lane.failure = feedback.own.answer(&measured, &mut feedback.commands).err();
            let poses = (0..self.driven.bodies).map(|body| known.pose(body)).collect();
            feedback.earlier = Some(Earlier { time, poses, positions: known.positions().to_vec() });
            if let Some(told) = &mut lane.motion.commands {
                let asked = |(actuator, command): (usize, &f64)| match feedback.controller.commands(actuator)
                {
                    true => *command,
                    false => lane.drive.asked(actuator, time),
                };
                told.angles.extend(feedback.commands.iter().enumerate().map(asked));
            }
        }
    }

    /// What the ground carries of each element in each lane while the body is at rest; nothing where no controller asks.
    fn loads_at_rest(&mut self, lanes: &[Lane]) -> Vec<Vec<Option<f64>>> {
        if lanes.iter().all(|lane| lane.feedback.is_none()) {
            return Vec::new();
        }
        self.stepper.reset();
        for (place, servo) in self.driven.servos.iter().enumerate() {
            (0..S::LANES).for_each(|lane| self.stepper.aim(lane, place, servo.target));
        }
        (0..AT_REST).for_each(|_| self.stepper.step());
        let elements = 0..self.driven.placements.len();
        let of = |lane: usize| elements.clone().map(|element| self.stepper.load(lane, element)).collect();
        (0..lanes.len()).map(of).collect()
    }

    fn step(&mut self, lanes: &mut [Lane], t: f64, at_rest: &[Vec<Option<f64>>]) {
        self.control(lanes, t - self.schedule.step, at_rest);
        let last = lanes.len() - 1;
        for (number, lane) in lanes.iter_mut().enumerate() {
            let end = if number == last { S::LANES } else { number + 1 };
            let (drive, feedback) = (lane.drive, lane.feedback.as_ref());
            for (place, servo) in lane.servos.iter_mut().enumerate() {
                let asked = |actuator| Lane::asked(drive, feedback, actuator, t);
                if !servo.follow(asked, self.schedule.step) {
                    lane.failure = lane.failure.or(Some(Invalid::NotFinite));
                    servo.target = 0.0;
                }
                for lane in number..end {
                    self.stepper.aim(lane, place, servo.target);
                }
            }
        }
        self.stepper.step();
        for (number, lane) in lanes.iter_mut().enumerate() {
            lane.failure = lane.failure.or(self.stepper.failure(number));
        }
    }

    fn state(&self, lane: usize) -> State {
        State {
            poses: (0..self.driven.bodies).map(|body| self.stepper.pose(lane, body)).collect(),
            positions: (0..self.driven.joints.len())
                .map(|joint| self.stepper.position(lane, joint))
                .collect(),
        }
    }

    /// Records a frame of each lane when a share of the step has passed that led here from the states before.
    fn record(&self, lanes: &mut [Lane], before: &[State], share: f64) {
        for (number, lane) in lanes.iter_mut().enumerate() {
            if lane.failure.is_none() {
                let now = self.state(number);
                let state = match before.get(number) {
                    Some(before) if share < 1.0 => now.within(before, share),
                    _ => now,
                };
                lane.motion.poses.extend(state.poses);
                self.driven.bends.append(state.positions.into_iter(), &mut lane.motion.bends);
            }
        }
    }
}

impl<S: Stepper> Row for Run<S> {
    // Idle lanes do what the last one does.
    fn together(
        &mut self,
        stop: Stop<'_>,
        first: usize,
        cases: &[Case<'_>],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let mut lanes: Vec<Lane> =
            cases.iter().enumerate().map(|(number, case)| self.lane(number, case)).collect();
        let at_rest = self.loads_at_rest(&lanes);
        self.stepper.reset();
        let mut frame = 0;
        for now in 0..=self.schedule.steps {
            if now % STEPS_PER_LOOK == 0 && stop.is_asked() {
                return None;
            }
            let mut before = Vec::new();
            if now > 0 {
                // Needed only where a frame lies within the step.
                let (step, share) = self.schedule.moment(frame);
                if step == now && share < 1.0 {
                    before.extend((0..lanes.len()).map(|lane| self.state(lane)));
                }
                self.step(&mut lanes, now as f64 * self.schedule.step, &at_rest);
            }
            if lanes.iter().all(|lane| lane.failure.is_some()) {
                break;
            }
            while frame < self.schedule.frames
                && let (step, share) = self.schedule.moment(frame)
                && step == now
            {
                self.record(&mut lanes, &before, share);
                frame += 1;
                self.look(&mut lanes, first, frame, watch);
            }
        }
        for lane in &mut lanes {
            if lane.failure.is_none() && self.pace_limit.is_some_and(|limit| lane.motion.outpaces(limit)) {
                lane.failure = Some(Invalid::TooFar);
            }
        }
        for (number, lane) in lanes.iter_mut().enumerate() {
            for (joint, &actuator) in self.driven.joints.iter().enumerate() {
                if let Some(sum) = actuator.and_then(|actuator| lane.motion.work.get_mut(actuator)) {
                    *sum += self.stepper.work(number, joint);
                }
            }
        }
        let outcome = |lane: Lane| lane.failure.map_or(Ok(lane.motion), Err);
        Some(lanes.into_iter().map(outcome).collect())
    }
}

/// The motion of one drive, in the world of the first lane.
#[cfg(test)]
pub(super) fn alone(row: &mut dyn Row, drive: &Targets) -> Result<Motion, Invalid> {
    row.together(Stop::NEVER, 0, &[Case::nominal(drive)], &super::Unwatched).unwrap().remove(0)
}
