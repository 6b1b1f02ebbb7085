//! What the solvers share: driving, checking and recording a run.

use std::sync::Arc;

use nalgebra::Isometry3;

use super::lowering::Lowered;
use super::motion::Placement;
use super::schedule::Schedule;
use super::servo::{Bends, Servo};
use super::{Invalid, Motion, Settings, Simulation, Targets};
use crate::design::assembly::Hinge;

/// A solver that advances one body step by step. Hinges and bodies are those
/// of the [`Lowered`] assembly; hinge h carries body h + 1.
pub(super) trait Stepper: Send {
    /// Back to the state at rest, bit for bit.
    fn reset(&mut self);
    /// Sets the target of a hinge's servo for the next step, rad.
    fn aim(&mut self, hinge: usize, target: f64);
    /// Moves on by one step.
    fn step(&mut self) -> Result<(), Invalid>;
    /// The pose of a body in the world, m.
    fn pose(&self, body: usize) -> Isometry3<f64>;
    /// The angle of a hinge, rad.
    fn angle(&self, hinge: usize) -> f64;
    /// The mechanical work of a hinge's servo in the last step, J: the torque
    /// that acted times the turn of the hinge; negative where the servo is
    /// turned against its torque.
    fn work(&self, hinge: usize) -> f64;
}

/// One body, ready to run.
#[derive(Debug)]
pub(super) struct Run<S> {
    stepper: S,
    servos: Vec<Servo>,
    bends: Bends,
    schedule: Schedule,
    placements: Arc<[Placement]>,
    bodies: usize,
    actuators: usize,
}

impl<S: Stepper> Run<S> {
    /// A run of a solver made for the same assembly and settings.
    pub(super) fn new(stepper: S, lowered: &Lowered, settings: &Settings) -> Self {
        let hinges: Vec<&Hinge> = lowered.bodies.iter().filter_map(|body| body.hinge.as_ref()).collect();
        Self {
            stepper,
            servos: hinges.iter().map(|hinge| Servo::new(hinge)).collect(),
            bends: Bends::new(&hinges, lowered.actuators),
            schedule: Schedule::new(settings),
            placements: lowered.placements(),
            bodies: lowered.bodies.len(),
            actuators: lowered.actuators,
        }
    }

    fn one(&mut self, drive: &Targets) -> Result<Motion, Invalid> {
        let Schedule { step, steps, interval, duration, frames } = self.schedule;
        self.stepper.reset();
        for servo in &mut self.servos {
            servo.target = 0.0;
        }
        let mut motion = Motion {
            interval,
            duration,
            bodies: self.bodies,
            poses: Vec::with_capacity(frames * self.bodies),
            bends: Vec::new(),
            work: vec![0.0; self.actuators],
            placements: Arc::clone(&self.placements),
        };
        let mut frame = 0;
        for now in 0..=steps {
            if now > 0 {
                self.step(drive, now as f64 * step, &mut motion.work)?;
            }
            while frame < frames && self.schedule.step_of(frame) == now {
                self.record(&mut motion);
                frame += 1;
            }
        }
        Ok(motion)
    }

    fn step(&mut self, drive: &Targets, t: f64, work: &mut [f64]) -> Result<(), Invalid> {
        for (hinge, servo) in self.servos.iter_mut().enumerate() {
            if !servo.follow(drive, t, self.schedule.step) {
                return Err(Invalid::NotFinite);
            }
            self.stepper.aim(hinge, servo.target);
        }
        self.stepper.step()?;
        for (hinge, servo) in self.servos.iter().enumerate() {
            if let Some(sum) = work.get_mut(servo.actuator) {
                *sum += self.stepper.work(hinge).max(0.0);
            }
        }
        Ok(())
    }

    fn record(&self, motion: &mut Motion) {
        motion.poses.extend((0..self.bodies).map(|body| self.stepper.pose(body)));
        self.bends.append((0..self.servos.len()).map(|hinge| self.stepper.angle(hinge)), &mut motion.bends);
    }
}

impl<S: Stepper> Simulation for Run<S> {
    fn run(&mut self, drives: &[Targets]) -> Vec<Result<Motion, Invalid>> {
        drives.iter().map(|drive| self.one(drive)).collect()
    }
}
