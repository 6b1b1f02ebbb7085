//! What must not change when nothing acts: momentum, energy, the place of a standing foot.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::{aloft, chain, fine, loose, solver};
use crate::design::assembly::{Assembly, JointKind, Shape};
use crate::simulate::articulated::scalar::Scalar;
use crate::simulate::articulated::solver::Solver;
use crate::simulate::articulated::vector::{add, apply, cross};
use crate::simulate::lowering::Lowered;
use crate::simulate::tests::bodies::{Builder, cube, element, fork, gait, hinge, m2, m4, m8};
use crate::simulate::{Settings, Targets};
use crate::simulate::tests::settings;

/// A pendulum of two limp links on a root that is held.
fn double_pendulum(step: f64) -> Solver<f32> {
    let mut solver = aloft::<f32>(&chain(2, 0.1, |anchor| loose(anchor, Vector3::z())), &fine(step));
    solver.anchored = true;
    solver
}

/// Five limp links on a base of 2 kg.
fn whip(step: f64) -> Solver<f32> {
    let mut body = chain(5, 0.04, |anchor| loose(anchor, Vector3::z()));
    body.elements[0].mass = 2.0;
    aloft::<f32>(&body, &Settings { gravity: 9.81, ..fine(step) })
}

/// The most and least that the energy has changed by, as shares of m g L of the links.
fn energy_error(mut solver: Solver<f32>, weight_length: f64, duration: f64, step: f64) -> (f64, f64, f64, f64) {
    solver.begin();
    let start = f64::from(solver.energy());
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let mut last = 0.0;
    for _ in 0..(duration / step).round() as usize {
        solver.advance();
        last = (f64::from(solver.energy()) - start) / weight_length;
        (low, high) = (low.min(last), high.max(last));
    }
    (low, high, last, solver.passes as f64 / (duration / step))
}

#[test]
#[ignore = "prints measurements"]
fn report_limp() {
    for rate in [120.0, 240.0, 480.0, 960.0, 1920.0] {
        let step = 1.0 / rate;
        let s = double_pendulum(step);
        let mgl = f64::from(s.tree.links[1].mass) * 2.0 * 981.0 * 20.0;
        let a = energy_error(s, mgl, 10.0, step);
        let mut s = whip(step);
        s.anchored = true;
        let mgl = f64::from(s.tree.links[1].mass) * 5.0 * 981.0 * 20.0;
        let b = energy_error(s, mgl, 10.0, step);
        let mut t = super::tumbling::<f32>(step);
        let start = f64::from(t.energy());
        let c = energy_error(t, start, 10.0, step);
        println!("{rate}: double {a:.4?} whip {b:.4?} tumble {c:.4?}");
    }
}

/// Runs a gait; the way of the centre of mass and the largest foot creep.
fn slide(body: &Assembly, drive: &Targets, settings: &Settings) -> (f64, [f64; 3], f64) {
    let lowered = Lowered::new(body, settings).unwrap();
    let mut solver = Solver::<f32>::new((), &lowered, settings);
    let mut servos = lowered.servos.clone();
    let start = solver.state.centre;
    for step in 1..=(settings.duration / settings.step) as usize {
        for (place, servo) in servos.iter_mut().enumerate() {
            servo.follow(drive, step as f64 * settings.step, settings.step);
            solver.targets[place] = servo.target as f32;
        }
        solver.advance();
    }
    let end = solver.state.centre;
    let way = [0, 1, 2].map(|i| f64::from(end[i] - start[i]));
    (solver.ledger.gained as f64 / solver.ledger.allowed as f64, way, solver.passes as f64 / (settings.duration / settings.step))
}

#[test]
#[ignore = "prints measurements"]
fn report_ice() {
    for body in [m2(), m4(), m8(), fork()] {
        for number in 1..4 {
            let drive = gait(body.actuators, number, false);
            let ice = Settings { ground_friction: 0.0, ..settings() };
            println!("ice {:?}", slide(&body, &drive, &ice));
            for rate in [60.0, 120.0, 240.0, 480.0, 960.0, 1920.0, 3840.0] {
                let usual = Settings { step: 1.0 / rate, iterations: 50, tolerance: 1e-4, ..settings() };
                let s = slide(&body, &drive, &usual);
                println!("  {rate} {:.3?} {:.3} {:.3}", s.1, s.0, s.2);
            }
        }
    }
}
