//! What the balls must get right.

mod bodies;
mod ground;
mod refusals;
mod same;
mod single;
mod touching;

use fearless_simd::{Level, dispatch};
use nalgebra::Vector3;

use super::solver::Solver;
use super::widest;
use crate::design::assembly::Assembly;
use crate::simulate::lattice::Lattice;
use crate::simulate::run::{Stepper, alone};
use crate::simulate::{Motion, Settings, Targets};

/// Balls without springs in a row along x, so far apart.
fn row(count: usize, pitch: f64) -> Assembly {
    use crate::simulate::tests::lattices::{PITCH, cells, lattice};
    let mut body = lattice(&cells([0, 0, 0], [count as i32, 1, 1]));
    body.springs.clear();
    body.elements.iter_mut().for_each(|e| e.pose.translation.vector *= pitch / PITCH);
    body
}

/// A body as it is lowered, somewhere above the ground.
fn lifted(body: &Assembly, settings: &Settings, by: f64) -> Lattice {
    let mut lattice = Lattice::new(body, settings).unwrap();
    lattice.balls.iter_mut().for_each(|ball| ball.centre.y += by);
    lattice
}

fn run(lattice: &Lattice, settings: &Settings, drive: &Targets) -> Motion {
    super::stable::check(lattice, settings).unwrap();
    alone(widest(lattice, settings).unwrap().as_mut(), drive).unwrap()
}

fn place(motion: &Motion, ball: usize, t: f64) -> Vector3<f64> {
    motion.pose(ball, t).unwrap().translation.vector
}

/// Where all balls are in the mean.
fn middle(motion: &Motion, t: f64) -> Vector3<f64> {
    (0..motion.bodies).map(|ball| place(motion, ball, t)).sum::<Vector3<f64>>() / motion.bodies as f64
}

/// No actuators.
fn idle() -> Targets {
    crate::simulate::tests::bodies::idle(0)
}

/// A target that grows evenly from zero for a time and then stays.
fn ramp(to: f64, time: f64) -> Targets {
    Targets { interval: time, actuators: 1, angles: vec![0.0, to] }
}

/// The most energy that came from nowhere, as a height in m to which it lifts the body.
fn gained(lattice: &Lattice, settings: &Settings) -> f64 {
    let mass: f64 = lattice.balls.iter().map(|ball| ball.mass).filter(|mass| mass.is_finite()).sum();
    let energy = dispatch!(Level::new(), kit => {
        let mut solver = Solver::new(kit, lattice, settings).unwrap();
        (0..(settings.duration / settings.step) as usize).for_each(|_| solver.step());
        assert_eq!(solver.failure(0), None);
        solver.ledger.gained
    });
    energy / (mass * 9.81)
}
