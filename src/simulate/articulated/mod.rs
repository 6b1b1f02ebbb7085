//! The fast hinge solver: reduced coordinates, direct servos, contacts by
//! projected Gauss-Seidel.
//!
//! A step goes: frames of all bodies ([`kinematics`]); mass matrix
//! ([`inertia`]) and bias forces ([`bias`]); servos as implicit spring-dampers
//! on its diagonal ([`joints`]); factorisation along the tree ([`factor`]);
//! candidates for contact with the [`ground`] and between parts ([`collide`]);
//! their [`rows`] in the factorised space; [`pgs`]; and the next state. The
//! order of all sums is fixed, and nothing depends on the platform.

mod bias;
mod collide;
mod factor;
mod ground;
mod inertia;
mod joints;
mod kinematics;
mod pgs;
mod rows;
mod scalar;
mod solver;
#[cfg(test)]
mod tests;
mod tree;
mod vector;

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

use self::kinematics::{Frame, State};
use self::scalar::Scalar;
use self::solver::Solver;
use self::tree::LENGTH;
use super::lowering::Lowered;
use super::motion::Placement;
use super::schedule::Schedule;
use super::servo::{Bends, Servo};
use super::{Invalid, Model, Motion, Settings, Simulation, Targets, Unfit};
use crate::design::assembly::{Assembly, Hinge};

/// The fast hinge solver, in single precision.
#[derive(Clone, Copy, Debug, Default)]
pub struct Articulated;

impl Model for Articulated {
    fn name(&self) -> &'static str {
        "articulated"
    }

    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        Ok(Box::new(Run::<f32>::new(assembly, settings)?))
    }
}

/// One body, ready to run.
#[derive(Debug)]
struct Run<S> {
    solver: Solver<S>,
    /// One per hinge, in the order of the bodies.
    servos: Vec<Servo>,
    bends: Bends,
    schedule: Schedule,
    placements: Arc<[Placement]>,
}

impl<S: Scalar> Run<S> {
    fn new(assembly: &Assembly, settings: &Settings) -> Result<Self, Unfit> {
        let lowered = Lowered::new(assembly, settings)?;
        let hinges = || lowered.bodies.iter().filter_map(|body| body.hinge.as_ref());
        Ok(Self {
            solver: Solver::new(&lowered, settings),
            servos: hinges().map(Servo::new).collect(),
            bends: Bends::new(hinges().collect::<Vec<&Hinge>>().into_iter(), lowered.actuators),
            schedule: Schedule::new(settings),
            placements: lowered.placements(),
        })
    }

    fn one(&mut self, drive: &Targets) -> Result<Motion, Invalid> {
        let schedule = self.schedule.clone();
        self.solver.reset();
        for servo in &mut self.servos {
            servo.target = 0.0;
        }
        let bodies = self.solver.frames.len();
        let mut motion = Motion {
            interval: schedule.interval,
            duration: schedule.duration,
            bodies,
            poses: Vec::with_capacity(schedule.frames * bodies),
            bends: Vec::new(),
            placements: Arc::clone(&self.placements),
        };
        let mut frame = 0;
        for step in 0..=schedule.steps {
            if step > 0 {
                self.step(drive, step as f64 * schedule.step, schedule.step)?;
            }
            while frame < schedule.frames && schedule.step_of(frame) == step {
                self.record(&mut motion);
                frame += 1;
            }
        }
        Ok(motion)
    }

    fn step(&mut self, drive: &Targets, t: f64, step: f64) -> Result<(), Invalid> {
        for (servo, target) in self.servos.iter_mut().zip(&mut self.solver.targets[1..]) {
            if !servo.follow(drive, t, step) {
                return Err(Invalid::NotFinite);
            }
            *target = S::of(servo.target);
        }
        self.solver.advance()
    }

    fn record(&self, motion: &mut Motion) {
        let state = &self.solver.state;
        motion.poses.extend(self.solver.frames.iter().map(|frame| pose(state, frame)));
        self.bends.append(state.angles[1..].iter().map(|angle| angle.to_f64()), &mut motion.bends);
    }
}

/// The pose of a body in the world, SI units.
fn pose<S: Scalar>(state: &State<S>, frame: &Frame<S>) -> Isometry3<f64> {
    let place = |axis: usize| (state.position[axis].to_f64() + frame.centre[axis].to_f64()) / LENGTH;
    let r = frame.rotation.map(|row| row.map(Scalar::to_f64));
    let matrix = Matrix3::from_fn(|row, column| r[row][column]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    let translation = Translation3::new(place(0), place(1), place(2));
    Isometry3::from_parts(translation, UnitQuaternion::new_normalize(turn.into_inner()))
}

impl<S: Scalar> Simulation for Run<S> {
    fn run(&mut self, drives: &[Targets]) -> Vec<Result<Motion, Invalid>> {
        drives.iter().map(|drive| self.one(drive)).collect()
    }
}
