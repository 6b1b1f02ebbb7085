//! The fast solver of joints: reduced coordinates, direct servos, contacts by
//! projected Gauss-Seidel.
//!
//! A step goes: mass matrix (`inertia`); servos as implicit spring-dampers on its
//! diagonal (`joints`); factorisation along the tree (`factor`); what the bodies bring along
//! from the last step (`momentum`); candidates for contact with the `ground` and between
//! parts (`collide`, of `hull`s), gathered by limb (`touches`); their `rows` in the factorised space;
//! `pgs`; how far the speeds found take every body (`stride`), and again from the momenta if that is
//! not as foreseen; the next state and the frames of all bodies (`kinematics`); and the
//! books (`energy`). The order of all sums is fixed, and nothing depends on the platform.
//!
//! All is generic over the numbers (`scalar`): one run, or several in the `lanes`
//! of a vector, which share the tree and differ only in data. `widths` has a
//! solver for each number of lanes that the processor does well.

mod angle;
mod collide;
mod energy;
mod factor;
mod ground;
mod hull;
mod inertia;
mod joints;
mod kinematics;
mod lanes;
mod momentum;
mod pgs;
mod places;
mod rows;
mod scalar;
mod single;
mod solver;
mod stride;
#[cfg(test)]
mod tests;
mod touches;
mod tree;
mod vector;
mod widths;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

pub(super) use self::collide::colliding;
use self::scalar::Scalar;
use self::solver::Solver;
use self::tree::{LENGTH, MASS, TORQUE, dof_of, scales};
use self::vector::V3;
use super::lowering::Lowered;
use super::run::Stepper;
use super::widths::Widths;
use super::{Invalid, Model, Settings, Simulation, SolverName, Unfit};
use crate::design::assembly::Assembly;

/// The fast solver of joints, in single precision.
#[derive(Clone, Copy, Debug, Default)]
pub struct Articulated;

impl Model for Articulated {
    fn name(&self) -> SolverName {
        SolverName::Articulated
    }

    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        let settings = settings.in_whole_steps();
        Ok(Box::new(Widths::new(widths::widths(Lowered::new(assembly, &settings)?, &settings))))
    }
}

impl<S: Scalar> Stepper for Solver<S> {
    const LANES: usize = S::LANES;

    fn reset(&mut self) {
        Self::reset(self);
    }

    #[inline]
    fn aim(&mut self, lane: usize, servo: usize, target: f64) {
        self.targets[servo].set_lane(lane, target * self.tree.servos[servo]);
    }

    fn step(&mut self) {
        self.advance();
    }

    #[inline]
    fn failure(&self, lane: usize) -> Option<Invalid> {
        self.failures[lane]
    }

    fn pose(&self, lane: usize, body: usize) -> Isometry3<f64> {
        let frame = &self.frames[body];
        // Adding zero makes minus zero zero, so that lanes agree to the bit.
        let place = |axis: usize| {
            (self.state.position[axis].lane(lane) + frame.centre[axis].lane(lane)) / LENGTH + 0.0
        };
        let matrix = Matrix3::from_fn(|row, column| frame.rotation[row][column].lane(lane) + 0.0);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
        let translation = Translation3::new(place(0), place(1), place(2));
        Isometry3::from_parts(translation, UnitQuaternion::new_normalize(turn.into_inner()))
    }

    #[inline]
    fn position(&self, lane: usize, joint: usize) -> f64 {
        let (body, tree) = (joint + 1, &self.tree);
        let now = if tree.spun[body] { self.state.speeds[dof_of(body)] } else { self.state.positions[body] };
        // Adding zero leaves no negative zero.
        now.lane(lane) / scales(tree.travels[body]).0 + 0.0
    }

    fn work(&self, lane: usize, joint: usize) -> f64 {
        self.joints.work(joint + 1).lane(lane) / TORQUE + 0.0
    }

    fn rate(&self, lane: usize, joint: usize) -> Option<f64> {
        let body = joint + 1;
        let rate = self.state.speeds[dof_of(body)].lane(lane);
        Some(rate / scales(self.tree.travels[body]).0 + 0.0)
    }

    fn velocity(&self, lane: usize, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let frame = &self.frames[body];
        let along =
            |vector: &V3<S>, scale: f64| Vector3::from_fn(|axis, _| vector[axis].lane(lane) / scale + 0.0);
        Some((along(&frame.velocity, LENGTH), along(&frame.spin, 1.0)))
    }

    fn load(&self, lane: usize, element: usize) -> Option<f64> {
        Some(self.carried_by(lane, element) / (MASS * LENGTH) + 0.0)
    }
}
