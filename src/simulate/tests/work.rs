//! The work of servos, and how low and long elements are.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::HINGED;
use super::bodies::{element, gait, idle, m2, servo};
use super::truth::{crane, during, place, run};
use crate::design::assembly::{Assembly, JointKind, Shape};
use crate::simulate::{Motion, Settings, Targets};

/// The arm of the crane in m, its tip in kg.
const ARM: f64 = 0.05;
const TIP: f64 = 0.02;

/// Up to an angle within three seconds, and one more to rest there.
fn lift(angle: f64) -> Targets {
    Targets { interval: 3.0, actuators: 1, angles: vec![0.0, angle] }
}

/// From the lowest that the tip ever is to where it ends.
fn raised(motion: &Motion) -> f64 {
    let heights = (0..motion.frames()).map(|frame| place(motion, 1, motion.time(frame)).y);
    place(motion, 1, motion.duration).y - heights.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_slow_lift_takes_mass_times_gravity_times_height() {
    for name in HINGED {
        let motion = run(name, &crane(1, ARM, TIP, 0.3), &during(4.0), &lift(0.7));
        let (height, work) = (raised(&motion), motion.work[0]);
        assert!(height > 0.03, "{name}: {height} m");
        let expected = TIP * 9.81 * height;
        assert!((work / expected - 1.0).abs() < 0.02, "{name}: {work} J, not {expected}");
    }
}

/// Lowering is no work, and gives nothing back.
#[test]
fn a_load_let_down_costs_nothing_more() {
    let drive = Targets { interval: 3.0, actuators: 1, angles: vec![0.0, 0.7, 0.0] };
    for name in HINGED {
        let up = run(name, &crane(1, ARM, TIP, 0.3), &during(4.0), &lift(0.7)).work[0];
        let both = run(name, &crane(1, ARM, TIP, 0.3), &during(7.0), &drive).work[0];
        assert!((both / up - 1.0).abs() < 0.02, "{name}: {up} J up, {both} J up and down");
    }
}

/// A servo that wants more than it can is counted with what it can.
#[test]
fn a_strained_servo_works_with_its_limit() {
    let mut body = crane(1, ARM, TIP, 30.0);
    let limit = 1.2 * TIP * 9.81 * ARM;
    for joint in &mut body.joints {
        if let JointKind::Dof(hinge) = &mut joint.kind {
            (hinge.effort, hinge.control) = (limit, servo(0, f64::INFINITY));
        }
    }
    let drive = Targets { interval: 1.0, actuators: 1, angles: vec![0.7] };
    for name in HINGED {
        // The tip is still on its way up.
        let motion = run(name, &body, &Settings { record: 1.0 / 240.0, ..during(0.1) }, &drive);
        let [before, turn] = motion.bends.last_chunk().unwrap();
        assert!(*turn > 0.1 && *turn < 0.5, "{name}: {turn} rad");
        // The speed changes evenly within a step, or is that after the step: the work ends in the middle of the last step, or at its end.
        let expected = limit * if name == "rapier" { *turn } else { (before + turn) / 2.0 };
        assert!(
            (motion.work[0] / expected - 1.0).abs() < 0.01,
            "{name}: {} J, not {expected}",
            motion.work[0]
        );
    }
}

#[test]
fn who_only_stands_does_no_work() {
    for (name, duration) in [("articulated", 20.0), ("rapier", 1.0)] {
        let body = m2();
        let motion = run(name, &body, &during(duration), &idle(body.actuators));
        let weight: f64 = body.elements.iter().map(|element| element.mass * 9.81).sum();
        // Less than it takes to raise the whole robot by a tenth of a millimetre.
        for work in &motion.work {
            assert!((0.0..weight * 1e-4).contains(work), "{name}: {work} J, weight {weight} N");
        }
        let rigid = Assembly { elements: body.elements[..1].to_vec(), ..Assembly::default() };
        assert!(run(name, &rigid, &during(0.1), &idle(0)).work.is_empty());
    }
}

#[test]
fn each_actuator_has_its_own_work() {
    let mut drive = gait(2, 4, false);
    for sample in drive.angles.chunks_mut(2) {
        sample[1] = 0.0;
    }
    let work = run("articulated", &m2(), &during(4.0), &drive).work;
    assert!(work[0] > 3.0 * work[1], "{work:?}");
}

#[test]
fn the_solvers_agree_on_the_work_of_a_swing() {
    // One hinge: rapier's chains are too soft to compare.
    let swing = |i: i32| 0.5 * libm::sin(f64::from(i) * 0.02 * std::f64::consts::TAU);
    let drive = Targets { interval: 0.02, actuators: 1, angles: (0..=150).map(swing).collect() };
    let [here, there] = ["articulated", "rapier"]
        .map(|name| run(name, &crane(1, ARM, TIP, 0.3), &during(3.0), &drive).work[0]);
    assert!(here > 0.02 && (here / there - 1.0).abs() < 0.03, "{here} J and {there} J");
}

/// A motion of one element that does not move.
fn still(shape: Shape, turn: UnitQuaternion<f64>) -> Motion {
    let pose = Isometry3::from_parts(Translation3::identity(), turn);
    let body = Assembly { elements: vec![element(shape, pose)], ..Assembly::default() };
    run("articulated", &body, &Settings { gravity: 0.0, ..during(0.1) }, &idle(0))
}

#[test]
fn the_lowest_point_is_on_the_ground_at_rest() {
    let turns = [(0.0, 0.0), (0.4, 0.0), (0.3, 0.8), (1.1, -2.0), (std::f64::consts::FRAC_PI_2, 0.3)];
    let shapes = [
        Shape::Box { half: Vector3::new(0.01, 0.02, 0.03) },
        Shape::Ball { radius: 0.015 },
        Shape::Cylinder { radius: 0.01, half_length: 0.025 },
        Shape::Capsule { radius: 0.01, half_straight: 0.025 },
    ];
    for shape in shapes {
        for (z, x) in turns {
            let motion = still(shape, UnitQuaternion::from_euler_angles(x, 0.0, z));
            let lowest = motion.lowest(0, 0.0).unwrap();
            assert!(lowest.abs() < 1e-6, "{shape:?} turned by {z}, {x}: {lowest} m");
            assert_eq!(motion.lowest(1, 0.0), None);
        }
    }
}

#[test]
fn the_size_is_the_longest_extent() {
    let none = UnitQuaternion::identity();
    let size = |shape| still(shape, none).size(0).unwrap();
    assert_eq!(size(Shape::Box { half: Vector3::new(0.01, 0.03, 0.02) }), 0.06);
    assert_eq!(size(Shape::Ball { radius: 0.02 }), 0.04);
    assert_eq!(size(Shape::Cylinder { radius: 0.01, half_length: 0.03 }), 0.06);
    assert_eq!(size(Shape::Cylinder { radius: 0.03, half_length: 0.01 }), 0.06);
    assert_eq!(size(Shape::Capsule { radius: 0.01, half_straight: 0.02 }), 0.06);
    assert_eq!(still(Shape::Ball { radius: 0.02 }, none).size(1), None);
}
