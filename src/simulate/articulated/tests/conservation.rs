//! What must not change when nothing acts: momentum, energy, the place of a standing foot.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::{aloft, chain, fine, loose, solver, tumbling};
use crate::design::assembly::{Assembly, JointKind, Shape};
use crate::simulate::articulated::scalar::Scalar;
use crate::simulate::articulated::solver::Solver;
use crate::simulate::articulated::vector::V3;
use crate::simulate::lowering::Lowered;
use crate::simulate::tests::bodies::{Builder, cube, element, fork, gait, hinge, m2, m4, m8};
use crate::simulate::tests::settings;
use crate::simulate::{Settings, Targets};

/// Places and rotations of all bodies.
pub(super) fn poses<S: Scalar>(solver: &Solver<S>) -> Vec<(Vector3<f64>, Matrix3<f64>)> {
    let pose = |frame: &crate::simulate::articulated::kinematics::Frame<S>| {
        let place = |axis: usize| solver.state.position[axis].lane(0) + frame.centre[axis].lane(0);
        let turn = Matrix3::from_fn(|row, column| frame.rotation[row][column].lane(0));
        (Vector3::new(place(0), place(1), place(2)), turn)
    };
    solver.frames.iter().map(pose).collect()
}

/// The centre of mass, cm.
fn centre<S: Scalar>(solver: &Solver<S>) -> Vector3<f64> {
    let masses = || solver.tree.links.iter().map(|link| link.mass.lane(0));
    let sum: Vector3<f64> = masses().zip(poses(solver)).map(|(mass, (place, _))| place * mass).sum();
    sum / masses().sum::<f64>()
}

/// Runs a drive, and looks at every step.
fn drive<S: Scalar<Kit = ()>>(
    body: &Assembly,
    drive: &Targets,
    settings: &Settings,
    mut look: impl FnMut(usize, &Solver<S>),
) {
    let lowered = Lowered::new(body, settings).unwrap();
    let mut solver = super::solver::<S>(body, settings);
    let mut servos = lowered.servos.clone();
    look(0, &solver);
    for step in 1..=(settings.duration / settings.step).round() as usize {
        for (place, servo) in servos.iter_mut().enumerate() {
            servo.follow(|actuator| drive.asked(actuator, step as f64 * settings.step), settings.step);
            solver.targets[place].set_lane(0, servo.target);
        }
        solver.advance();
        look(step, &solver);
    }
    assert_eq!(solver.failures, [None]);
}

/// How far the centre of mass gets from where it began, in any direction along the ground, cm.
fn drift(body: &Assembly, targets: &Targets, settings: &Settings) -> f64 {
    let (mut start, mut most) = (None, 0.0_f64);
    drive::<f32>(body, targets, settings, |_, solver| {
        let now = centre(solver);
        let way = now - *start.get_or_insert(now);
        most = most.max(libm::hypot(way.x, way.z));
    });
    most
}

#[test]
fn nobody_moves_on_ice() {
    for body in [m2(), m4(), m8(), fork()] {
        for number in 1..4 {
            for step in [1.0 / 120.0, 1.0 / 240.0] {
                let ice = Settings { ground_friction: 0.0, step, ..settings() };
                let way = drift(&body, &gait(body.actuators, number, false), &ice);
                assert!(way < 1e-3, "{} elements, gait {number}: {way} cm", body.elements.len());
            }
        }
    }
}

#[test]
fn arms_that_beat_carry_nobody_away() {
    for rate in [120.0, 240.0] {
        let weightless = Settings {
            gravity: 0.0,
            ground_friction: 0.0,
            self_collision: false,
            step: 1.0 / rate,
            ..settings()
        };
        let way = drift(&m2(), &gait(2, 1, true), &weightless);
        assert!(way < 1e-3, "{way} cm");
    }
}

/// Angular momentum about the centre of mass between two places, g cm^2/s: from nothing but poses.
pub(super) fn turning<S: Scalar>(
    solver: &Solver<S>,
    from: &[(Vector3<f64>, Matrix3<f64>)],
    to: &[(Vector3<f64>, Matrix3<f64>)],
    step: f64,
) -> Vector3<f64> {
    let mass = |body: usize| solver.tree.links[body].mass.lane(0);
    let whole: f64 = (0..from.len()).map(mass).sum();
    let middle = |poses: &[(Vector3<f64>, Matrix3<f64>)]| -> Vector3<f64> {
        poses.iter().enumerate().map(|(body, (place, _))| place * mass(body)).sum::<Vector3<f64>>() / whole
    };
    let (before, after) = (middle(from), middle(to));
    let mut sum = Vector3::zeros();
    for (body, ((a, r), (b, s))) in from.iter().zip(to).enumerate() {
        let (a, b) = (a - before, b - after);
        sum += a.cross(&((b - a) * mass(body) / step));
        // Of a turn in a step the variational scheme knows the sine.
        let turn = Rotation3::from_matrix_unchecked(s * r.transpose());
        let inertia = solver.tree.links[body].inertia.0.map(|entry| entry.lane(0));
        let [xx, yy, zz, xy, xz, yz] = inertia;
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let second = Matrix3::identity() * own.trace() / 2.0 - own;
        let world = turn.matrix() * r * second * r.transpose();
        let odd = world - world.transpose();
        sum += Vector3::new(odd[(2, 1)], odd[(0, 2)], odd[(1, 0)]) / step;
    }
    sum
}

#[test]
fn a_tumbling_body_keeps_its_angular_momentum() {
    for rate in [240.0, 480.0] {
        let mut solver = tumbling::<f64>(1.0 / rate);
        let (mut start, mut before) = (None, poses(&solver));
        for _ in 0..(20.0 * rate) as usize {
            solver.advance();
            let after = poses(&solver);
            let now = turning(&solver, &before, &after, 1.0 / rate);
            let first = *start.get_or_insert(now);
            assert!((now - first).norm() < 1e-4 * first.norm(), "{first} became {now} at 1/{rate} s");
            before = after;
        }
    }
}

/// A pendulum of two limp links of 10 cm on a root that is held.
fn double_pendulum(step: f64) -> Solver<f32> {
    let mut solver = aloft::<f32>(&chain(2, 0.1, |anchor| loose(anchor, Vector3::z())), &fine(step));
    solver.anchored = true;
    solver
}

/// Five limp links of a length on a base of 2 kg that is held.
fn whip(step: f64, link: f64) -> Solver<f32> {
    let mut body = chain(5, link, |anchor| loose(anchor, Vector3::z()));
    body.elements[0].mass = 2.0;
    let mut solver = aloft::<f32>(&body, &fine(step));
    solver.anchored = true;
    solver
}

/// A limp trunk with two limp branches, which swing about axes in the plane of the ground, turned by an
/// angle from the trunk's.
fn tree(step: f64, turn: f64) -> Solver<f32> {
    let mut body = Builder::default();
    let mut last = body.add(cube(Vector3::zeros()));
    body.0.actuators = 1;
    let ball = |place: Vector3<f64>| {
        element(Shape::Ball { radius: 0.01 }, Isometry3::translation(place.x, place.y, place.z))
    };
    let trunk = body.add(ball(Vector3::x() * 0.12));
    body.join(last, trunk, JointKind::Dof(loose(Vector3::zeros(), Vector3::z())));
    last = trunk;
    for side in [1.0, -1.0] {
        let at = Vector3::x() * 0.12;
        let child = body.add(ball(at + Vector3::new(0.045, 0.0, 0.105 * side)));
        let (s, c) = libm::sincos(turn);
        body.join(last, child, JointKind::Dof(loose(at, Vector3::new(c, 0.0, s * side))));
    }
    let mut solver = aloft::<f32>(&body.0, &fine(step));
    solver.anchored = true;
    solver
}

/// By how much the energy of what swings falls and rises in a time, as shares of its weight times its length.
fn swing(solver: &mut Solver<f32>, length: f64, duration: f64, rate: f64) -> (f64, f64) {
    let mass: f64 = solver.tree.links[1..].iter().map(|link| f64::from(link.mass)).sum();
    solver.begin();
    // A whip lashes as fast as it can.
    solver.turn_limit = f32::MAX;
    let start = f64::from(solver.energy());
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for _ in 0..(duration * rate).round() as usize {
        solver.advance();
        assert_eq!(solver.failures, [None], "at 1/{rate} s");
        let off = (f64::from(solver.energy()) - start) / (mass * 981.0 * length);
        (low, high) = (low.min(off), high.max(off));
    }
    (low, high)
}

#[test]
fn limp_chains_keep_their_energy() {
    let all = |rate: f64| {
        let step = 1.0 / rate;
        let double = swing(&mut double_pendulum(step), 20.0, 10.0, rate);
        let tree = swing(&mut tree(step, -0.4), 24.0, 10.0, rate);
        [double, tree].map(|(low, high)| high.max(-low))
    };
    let [coarse, usual, fine] = [120.0, 240.0, 480.0].map(all);
    for chain in 0..2 {
        let errors = [coarse[chain], usual[chain], fine[chain]];
        assert!(errors[1] < 0.01, "chain {chain}: {errors:?} of m g L");
        // Of second order: sixteen times, but for when the worst moment comes.
        assert!(errors[0] > 8.0 * errors[2], "chain {chain}: {errors:?} of m g L");
    }
}

/// Links that lash so fast that they turn by half a right angle in a step: that costs energy, and gains none
/// to speak of.
#[test]
fn a_whip_gains_no_energy() {
    for rate in [240.0, 480.0, 960.0] {
        let step = 1.0 / rate;
        let whips = [0.02, 0.04].map(|link| swing(&mut whip(step, link), 500.0 * link, 10.0, rate));
        // Branches whose ends are near their axes: they spin as tops.
        let tops = swing(&mut tree(step, 0.93), 24.0, 10.0, rate);
        for (low, high) in [whips[0], whips[1], tops] {
            assert!(high < 0.05 && low > -1.0, "1/{rate} s: {low}, {high} of m g L");
        }
    }
}

#[test]
#[ignore = "prints measurements"]
fn report_limp() {
    for rate in [120.0, 240.0, 480.0, 960.0, 1920.0] {
        let step = 1.0 / rate;
        let double = swing(&mut double_pendulum(step), 20.0, 10.0, rate);
        let tree = swing(&mut tree(step, -0.4), 24.0, 10.0, rate);
        let whips = [0.02, 0.04, 0.08].map(|link| swing(&mut whip(step, link), 500.0 * link, 10.0, rate));
        let tops = swing(&mut self::tree(step, 0.93), 24.0, 10.0, rate);
        println!(
            "1/{rate} s: double {double:.4?} tree {tree:.4?} tops {tops:.4?} whips of 2, 4, 8 cm {whips:.4?}"
        );
    }
}

/// Solutions of a step, of which one is the least, at steps of many lengths.
#[test]
#[ignore = "prints measurements"]
fn report_passes() {
    for rate in [120.0, 240.0, 480.0] {
        for body in [m2(), m4(), m8(), fork()] {
            let passes = (1..5).map(|number| {
                let settings = Settings { step: 1.0 / rate, ..settings() };
                let (mut passes, mut steps) = (0, 0);
                drive::<f32>(&body, &gait(body.actuators, number, false), &settings, |step, solver| {
                    (passes, steps) = (solver.passes, step);
                });
                passes as f64 / steps as f64
            });
            println!("1/{rate} s, {} elements: {:.3?}", body.elements.len(), passes.collect::<Vec<_>>());
        }
    }
}

/// How far a block slides in two seconds on a slope with a friction of 0.8, cm.
fn slide(tangent: f64, half: Vector3<f64>, heading: f64, settings: &Settings) -> f64 {
    let body = element(Shape::Box { half }, Isometry3::identity());
    let assembly = Assembly { elements: vec![body], ..Assembly::default() };
    let mut solver = solver::<f32>(&assembly, settings);
    let (s, c) = libm::sincos(libm::atan(tangent));
    let (z, x) = libm::sincos(heading);
    solver.gravity = V3([981.0 * s * x, -981.0 * c, 981.0 * s * z].map(|part| part as f32));
    let start = centre(&solver);
    for _ in 0..(2.0 / settings.step) as usize {
        solver.advance();
    }
    let way = centre(&solver) - start;
    libm::hypot(way.x, way.z)
}

#[test]
fn friction_holds_to_its_limit_and_no_further() {
    // The settings of the library's model of hinges.
    let usual = Settings { iterations: 10, tolerance: 2e-3, ..fine(1.0 / 240.0) };
    for half in [Vector3::new(0.03, 0.01, 0.03), Vector3::repeat(0.015), Vector3::new(0.01, 0.01, 0.02)] {
        for heading in [0.0, 0.3, 0.6435] {
            let creep = slide(0.8 * 0.999, half, heading, &usual);
            // As it sinks at first, its weight is not borne in full, and it slips a little.
            assert!(creep < 6e-3, "crept {creep} cm, {half} towards {heading}");
            let (s, c) = libm::sincos(libm::atan(0.808));
            let law = 0.5 * 981.0 * (s - 0.8 * c) * 4.0;
            let way = slide(0.808, half, heading, &usual);
            assert!((way / law - 1.0).abs() < 0.02, "slid {way} cm, not {law}, {half} towards {heading}");
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
            let turn = UnitQuaternion::rotation_between(&Vector3::x(), &way).unwrap();
            let pose = Isometry3::from_parts((at + way * 0.008).into(), turn);
            let child = body.add(element(Shape::Cylinder { radius: 0.01, half_length: 0.008 }, pose));
            body.join(last, child, JointKind::Dof(hinge(at, Vector3::x() * side, actuator)));
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

/// A body that bends on feet that stand moves none of them.
#[test]
fn planted_feet_do_not_creep() {
    let body = bridge();
    for rate in [120.0, 240.0, 480.0] {
        for size in [0.05, 0.4] {
            let wave = |sample: i32| size * libm::sin(f64::from(sample) * 0.1);
            let targets = Targets {
                interval: 0.02,
                actuators: 2,
                angles: (0..=1000).flat_map(|sample| [wave(sample), 0.7 * wave(sample)]).collect(),
            };
            let settings = Settings { step: 1.0 / rate, ground_friction: 2.0, ..settings() };
            let lowered = Lowered::new(&body, &settings).unwrap();
            let feet = [6, 12].map(|element: usize| lowered.pieces[element].body);
            let (mut start, mut most) = (None, 0.0_f64);
            drive::<f32>(&body, &targets, &settings, |step, solver| {
                // The first second is for the arms to sag.
                if step >= rate as usize {
                    let poses = poses(solver);
                    let now = feet.map(|foot| poses[foot].0);
                    for (now, start) in now.iter().zip(start.get_or_insert(now)) {
                        let way = now - *start;
                        most = most.max(libm::hypot(way.x, way.z));
                    }
                }
            });
            assert!(most < 3e-3, "{size} rad at 1/{rate} s: {most} cm");
        }
    }
}
