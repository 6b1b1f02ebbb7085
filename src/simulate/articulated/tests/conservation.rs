//! What must not change when nothing acts: momentum, energy, the place of a standing foot.

use nalgebra::{Isometry3, Vector3};

use super::{aloft, chain, fine, loose, solver};
use crate::design::assembly::{Assembly, JointKind, Shape};
use crate::simulate::articulated::solver::Solver;
use crate::simulate::lowering::Lowered;
use crate::simulate::tests::bodies::{Builder, cube, element, fork, gait, hinge, m2, m4, m8};
use crate::simulate::tests::settings;
use crate::simulate::{Settings, Targets};

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
fn energy_error(
    mut solver: Solver<f32>,
    weight_length: f64,
    duration: f64,
    step: f64,
) -> (f64, f64, f64, f64) {
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
        let t = super::tumbling::<f32>(step);
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
    (
        solver.ledger.gained as f64 / solver.ledger.allowed as f64,
        way,
        solver.passes as f64 / (settings.duration / settings.step),
    )
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

/// How far a block of a shape slides in two seconds on a slope with a friction of 0.8.
fn creep(tangent: f64, half: Vector3<f64>, heading: f64, change: impl Fn(&mut Settings)) -> (f64, f64) {
    let body = element(Shape::Box { half }, Isometry3::identity());
    let assembly = Assembly { elements: vec![body], ..Assembly::default() };
    let mut set = fine(1.0 / 240.0);
    change(&mut set);
    let mut solver = solver::<f32>(&assembly, &set);
    let (s, c) = libm::sincos(libm::atan(tangent));
    let (z, x) = libm::sincos(heading);
    solver.gravity = [(981.0 * s * x) as f32, (-981.0 * c) as f32, (981.0 * s * z) as f32];
    let start = solver.state.position;
    let mut early = 0.0;
    let steps = (2.0 / set.step) as usize;
    for step in 0..steps {
        solver.advance();
        let [x, _, z] = [0, 1, 2].map(|i| f64::from(solver.state.position[i] - start[i]));
        if step == steps / 4 {
            early = x.hypot(z);
        }
    }
    let [x, _, z] = [0, 1, 2].map(|i| f64::from(solver.state.position[i] - start[i]));
    (early * 1e4, x.hypot(z) * 1e4)
}

#[test]
#[ignore = "prints measurements"]
fn report_creep() {
    for half in [Vector3::new(0.03, 0.01, 0.03), Vector3::repeat(0.015), Vector3::new(0.01, 0.01, 0.02)] {
        for heading in [0.0, 0.3, 0.6435] {
            for (name, iterations, tolerance) in
                [("std", 10, 2e-3), ("test", 8, 1e-3), ("tight", 100, 1e-4), ("exact", 2000, 1e-7)]
            {
                let f = |s: &mut Settings| {
                    s.iterations = iterations;
                    s.tolerance = tolerance;
                };
                let a = creep(0.8 * 0.999, half, heading, f);
                let (s, c) = libm::sincos(libm::atan(0.808));
                let law = 0.5 * 981.0 * (s - 0.8 * c) * 4.0 * 1e4;
                let b = creep(0.808, half, heading, f).1 / law;
                println!("creep {half:?} {heading} {name}: {a:.2?} um, above {b:.4}");
            }
        }
    }
}

/// A light core between two heavy feet, on an arm each.
fn bridge() -> Assembly {
    let mut body = Builder::default();
    let core = body.add(cube(Vector3::new(0.0, 0.05, 0.0)));
    for (actuator, side) in [(0, 1.0), (1, -1.0)] {
        let (mut last, mut at) = (core, Vector3::new(0.0, 0.05, 0.015 * side));
        let way = Vector3::z() * side;
        for _ in 0..5 {
            let turn = nalgebra::UnitQuaternion::rotation_between(&Vector3::x(), &way).unwrap();
            let pose = Isometry3::from_parts((at + way * 0.008).into(), turn);
            let child = body.add(element(Shape::Cylinder { radius: 0.01, half_length: 0.008 }, pose));
            body.join(last, child, JointKind::Hinge(hinge(at, Vector3::x() * side, actuator)));
            at += way * 0.016;
            last = child;
        }
        let mut foot = cube(at + Vector3::new(0.0, -0.02, 0.03 * side));
        foot.shape = Shape::Box { half: Vector3::new(0.05, 0.03, 0.03) };
        foot.mass = 1.0;
        let foot = body.add(foot);
        body.join(last, foot, JointKind::Rigid);
    }
    body.0.actuators = 2;
    body.0
}

#[test]
#[ignore = "prints measurements"]
fn report_planted() {
    let body = bridge();
    for rate in [120.0, 240.0, 480.0, 960.0] {
        for size in [0.05, 0.2, 0.4] {
            let set = Settings { step: 1.0 / rate, ground_friction: 2.0, ..settings() };
            let lowered = Lowered::new(&body, &set).unwrap();
            let mut solver = Solver::<f32>::new((), &lowered, &set);
            let feet: Vec<usize> = [6, 12].map(|e: usize| lowered.pieces[e].body).to_vec();
            let drive = Targets {
                interval: 0.02,
                actuators: 2,
                angles: (0..=1000)
                    .flat_map(|i| {
                        let a = size * libm::sin(f64::from(i) * 0.02 * 5.0);
                        [a, a * 0.7]
                    })
                    .collect(),
            };
            let mut servos = lowered.servos.clone();
            let place = |solver: &Solver<f32>| {
                feet.iter()
                    .map(|&f| {
                        [0, 1, 2].map(|i| f64::from(solver.state.position[i] + solver.frames[f].centre[i]))
                    })
                    .collect::<Vec<_>>()
            };
            let mut start = place(&solver);
            let mut most = 0.0_f64;
            let mut core = 0.0_f64;
            for step in 1..=(20.0 * rate) as usize {
                for (place, servo) in servos.iter_mut().enumerate() {
                    servo.follow(&drive, step as f64 * set.step, set.step);
                    solver.targets[place] = servo.target as f32;
                }
                solver.advance();
                if step == rate as usize {
                    start = place(&solver);
                }
                for (a, b) in place(&solver).iter().zip(&start) {
                    most = most.max(((a[0] - b[0]).powi(2) + (a[2] - b[2]).powi(2)).sqrt());
                }
                core = core.max(f64::from(solver.state.position[1]));
            }
            let end: Vec<f64> = place(&solver)
                .iter()
                .zip(&start)
                .map(|(a, b)| (a[0] - b[0]).hypot(a[2] - b[2]) * 1e4)
                .collect();
            println!(
                "planted {rate} {size}: most {:.2} um, end {end:.2?} core {core} {:?}",
                most * 1e4,
                solver.failures
            );
        }
    }
}
