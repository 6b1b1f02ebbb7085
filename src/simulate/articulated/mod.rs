//! The fast hinge solver: reduced coordinates, direct servos, contacts by
//! projected Gauss-Seidel.
//!
//! A step goes: frames of all bodies (`kinematics`); mass matrix
//! (`inertia`) and bias forces (`bias`); servos as implicit spring-dampers
//! on its diagonal (`joints`); factorisation along the tree (`factor`);
//! candidates for contact with the `ground` and between parts (`collide`);
//! their `rows` in the factorised space; `pgs`; and the next state. The
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

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

use self::scalar::Scalar;
use self::solver::Solver;
use self::tree::{LENGTH, TORQUE, dof_of};
use super::lowering::Lowered;
use super::run::{Run, Stepper};
use super::{Invalid, Model, Settings, Simulation, Unfit};
use crate::design::assembly::Assembly;

/// The fast hinge solver, in single precision.
#[derive(Clone, Copy, Debug, Default)]
pub struct Articulated;

impl Model for Articulated {
    fn name(&self) -> &'static str {
        "articulated"
    }

    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        let lowered = Lowered::new(assembly, settings)?;
        Ok(Box::new(Run::new(Solver::<f32>::new(&lowered, settings), &lowered, settings)))
    }
}

impl<S: Scalar> Stepper for Solver<S> {
    fn reset(&mut self) {
        Self::reset(self);
    }

    fn aim(&mut self, hinge: usize, target: f64) {
        self.targets[hinge + 1] = S::of(target);
    }

    fn step(&mut self) -> Result<(), Invalid> {
        self.advance()
    }

    fn pose(&self, body: usize) -> Isometry3<f64> {
        let frame = &self.frames[body];
        let place = |axis: usize| (self.state.position[axis].to_f64() + frame.centre[axis].to_f64()) / LENGTH;
        let r = frame.rotation.map(|row| row.map(Scalar::to_f64));
        let matrix = Matrix3::from_fn(|row, column| r[row][column]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
        let translation = Translation3::new(place(0), place(1), place(2));
        Isometry3::from_parts(translation, UnitQuaternion::new_normalize(turn.into_inner()))
    }

    fn angle(&self, hinge: usize) -> f64 {
        self.state.angles[hinge + 1].to_f64()
    }

    fn work(&self, hinge: usize) -> f64 {
        // The hinge has turned by its speed times the step, so impulse times
        // speed is torque times turn.
        let impulse = self.joints.impulse(hinge + 1).to_f64();
        impulse * self.state.speeds[dof_of(hinge + 1)].to_f64() / TORQUE
    }
}
