//! Truths that hold for every solver, through the public interface.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::bodies::{Builder, cube, element, fork, gait, hinge, idle, m2, m4, m8, millipede, servo};
use super::lattices::{bend, cells, lattice};
use super::{HINGED, settings};
use crate::design::assembly::{Assembly, Dof, JointKind, Shape};
use crate::simulate::{Invalid, Motion, Settings, Stop, Targets, model};

pub(super) fn run(name: &str, body: &Assembly, settings: &Settings, drive: &Targets) -> Motion {
    let mut simulation = model(name).unwrap().prepare(body, settings).unwrap();
    simulation.run(std::slice::from_ref(drive)).remove(0).unwrap()
}

/// For a time in s.
pub(super) fn during(duration: f64) -> Settings {
    Settings { duration, ..settings() }
}

pub(super) fn place(motion: &Motion, element: usize, t: f64) -> Vector3<f64> {
    motion.pose(element, t).unwrap().translation.vector
}

#[test]
fn solvers_are_found_by_their_names() {
    for name in crate::simulate::SolverName::ALL {
        assert_eq!(crate::simulate::SolverName::named(name.text()), Some(name));
    }
    assert!(model("bullet").is_none());
}

/// A heavy block with an arm of light links and a heavy tip over thin air.
pub(super) fn crane(links: usize, pitch: f64, tip: f64, stiffness: f64) -> Assembly {
    let mut body = Builder::default();
    let mut base = cube(Vector3::new(-0.05, 0.05, 0.0));
    base.shape = Shape::Box { half: Vector3::repeat(0.05) };
    base.mass = 5.0;
    let mut last = body.add(base);
    body.0.actuators = 1;
    for link in 0..links {
        let anchor = Vector3::new(pitch * link as f64, 0.09, 0.0);
        let place = anchor + Vector3::x() * pitch;
        let mut ball = element(Shape::Ball { radius: 0.015 }, Translation3::from(place).into());
        ball.mass = if link + 1 == links { tip } else { tip * 1e-3 };
        let child = body.add(ball);
        let joint = Dof { stiffness, share: 1.0 / links as f64, ..hinge(anchor, Vector3::z(), 0) };
        body.join(last, child, JointKind::Dof(joint));
        last = child;
    }
    body.0
}

#[test]
fn a_servo_sags_by_torque_over_stiffness() {
    let (pitch, mass, stiffness) = (0.05, 0.02, 0.3);
    for name in HINGED {
        let motion = run(name, &crane(1, pitch, mass, stiffness), &during(2.0), &idle(1));
        let angle = -motion.bends.last().unwrap();
        let torque = mass * 9.81 * pitch * libm::cos(angle);
        assert!((angle * stiffness / torque - 1.0).abs() < 0.02, "{name}: {angle} rad");
    }
}

/// Only the articulated solver: rapier's chains are too soft.
#[test]
fn a_cantilever_sags_by_the_closed_form() {
    let (links, pitch, mass, stiffness) = (5, 0.02, 0.004, 0.3);
    let settings = Settings { self_collision: false, ..during(2.0) };
    let motion = run("articulated", &crane(links, pitch, mass, stiffness), &settings, &idle(1));
    // The base itself sinks a little.
    let sunk = |element| place(&motion, element, 0.0).y - place(&motion, element, 2.0).y;
    let sag = sunk(links) - sunk(0);
    let (n, length) = (links as f64, pitch * links as f64);
    let sum: f64 = (0..links).map(|i| ((links - i) as f64 / n).powi(2)).sum();
    let expected = mass * 9.81 * length * length / stiffness * sum;
    assert!((sag / expected - 1.0).abs() < 0.01, "{sag} m, not {expected}");
}

#[test]
fn unactuated_robots_stay_put() {
    // rapier takes a hundred times as long, so it gets less to do.
    for (name, bodies, duration) in
        [("articulated", vec![m2(), m4(), m8()], 20.0), ("rapier", vec![m2()], 2.0)]
    {
        for body in bodies {
            let motion = run(name, &body, &during(duration), &idle(body.actuators));
            for piece in 0..body.elements.len() {
                // The first half second is for the limbs to sag.
                let way = place(&motion, piece, duration) - place(&motion, piece, 0.5);
                assert!(way.norm() < 2e-4, "{name}: element {piece} of {} crept {way}", body.elements.len());
            }
        }
    }
}

/// A capsule that leans falls over and rolls to rest on its side, in the same place in both solvers.
#[test]
fn a_capsule_that_leans_falls_over() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.2);
    let pose = Isometry3::from_parts(Translation3::identity(), turn);
    let capsule = element(Shape::Capsule { radius: 0.01, half_straight: 0.02 }, pose);
    let body = Assembly { elements: vec![capsule], ..Assembly::default() };
    let ends = HINGED.map(|name| place(&run(name, &body, &during(2.0), &idle(0)), 0, 2.0));
    for (name, end) in HINGED.iter().zip(ends) {
        assert!((end.y - 0.01).abs() < 3e-4, "{name}: {end}");
        // It rolls over the round end that stands, whose middle goes on by the angle that it falls.
        assert!((end.x - ends[0].x).abs() < 2e-3 && end.z.abs() < 1e-3, "{name}: {end}, {}", ends[0]);
    }
}

/// A long cylinder stays on its side, a flat one on its end.
#[test]
fn cylinders_lie_along_their_own_x() {
    for name in HINGED {
        for (radius, half_length, axis, height) in
            [(0.01, 0.03, Vector3::z(), 0.01), (0.03, 0.01, Vector3::y(), 0.01)]
        {
            let turn = UnitQuaternion::rotation_between(&Vector3::x(), &axis).unwrap();
            let pose = Isometry3::from_parts(Translation3::identity(), turn);
            let cylinder = element(Shape::Cylinder { radius, half_length }, pose);
            let body = Assembly { elements: vec![cylinder], ..Assembly::default() };
            let end = place(&run(name, &body, &during(0.5), &idle(0)), 0, 0.5);
            assert!((end - Vector3::y() * height).norm() < 2e-4, "{name}: {end}");
        }
    }
}

#[test]
fn a_run_is_the_same_every_time_and_in_any_company() {
    // The limbs of the larger body meet, so its collisions have a history too.
    for (name, body, duration) in [("articulated", m8(), 20.0), ("rapier", m4(), 0.3)] {
        let mut simulation = model(name).unwrap().prepare(&body, &during(duration)).unwrap();
        let drives: Vec<_> = (1..4).map(|number| gait(body.actuators, number, false)).collect();
        let together = simulation.run(&drives);
        for (place, drive) in drives.iter().enumerate() {
            let alone = run(name, &body, &during(duration), drive);
            let first = together[place].as_ref().unwrap();
            assert_eq!(first.poses, alone.poses, "{name}, drive {place}");
            assert_eq!(first.bends, alone.bends, "{name}, drive {place}");
            assert_eq!(first.work, alone.work, "{name}, drive {place}");
        }
    }
}

/// A simulation that is asked to stop gives up soon, and the next one does not know of it.
#[test]
fn a_run_that_was_given_up_leaves_no_trace() {
    for (name, body, duration) in [("articulated", m8(), 4.0), ("rapier", m4(), 0.3)] {
        let mut simulation = model(name).unwrap().prepare(&body, &during(duration)).unwrap();
        let drive = gait(body.actuators, 1, false);
        let whole = run(name, &body, &during(duration), &drive);
        let flag = AtomicBool::new(true);
        assert!(
            simulation.run_until(Stop::new(&flag, None), std::slice::from_ref(&drive)).is_none(),
            "{name}"
        );
        flag.store(false, Ordering::Relaxed);
        let late = Stop::new(&flag, Some(Instant::now() + Duration::from_millis(1)));
        assert!(simulation.run_until(late, std::slice::from_ref(&drive)).is_none(), "{name}");
        let stop = Stop::new(&flag, Some(Instant::now() + Duration::from_secs(3600)));
        let again = simulation.run_until(stop, std::slice::from_ref(&drive)).expect("nobody stops it");
        assert_eq!(again[0].as_ref().unwrap().poses, whole.poses, "{name}");
    }
}

/// However many drives run side by side, each gives the bits that it gives alone.
#[test]
fn lanes_do_not_see_each_other() {
    for (body, swing) in [(m2(), 1.0), (m4(), 1.0), (m8(), 1.0), (fork(), 2.0)] {
        let settings = during(6.0);
        let mut drives: Vec<_> = (1..=16).map(|number| gait(body.actuators, number, false)).collect();
        drives.iter_mut().flat_map(|drive| &mut drive.angles).for_each(|angle| *angle *= swing);
        // One asks for nonsense half way, which must stay its own affair.
        let middle = drives[2].angles.len() / 8;
        drives[2].angles[middle] = f64::NAN;
        let alone: Vec<_> = drives
            .iter()
            .map(|d| {
                model("articulated")
                    .unwrap()
                    .prepare(&body, &settings)
                    .unwrap()
                    .run(std::slice::from_ref(d))
                    .remove(0)
            })
            .collect();
        let mut simulation = model("articulated").unwrap().prepare(&body, &settings).unwrap();
        for count in [2, 3, 4, 7, 8, 11, 16] {
            for (place, (one, own)) in simulation.run(&drives[..count]).iter().zip(&alone).enumerate() {
                let (Ok(one), Ok(own)) = (one, own) else {
                    assert_eq!(one.as_ref().err(), own.as_ref().err(), "drive {place} of {count}");
                    continue;
                };
                let bits = |motion: &Motion| -> Vec<u64> {
                    let poses =
                        motion.poses.iter().flat_map(|p| p.to_matrix().iter().copied().collect::<Vec<_>>());
                    poses.chain(motion.bends.clone()).chain(motion.work.clone()).map(f64::to_bits).collect()
                };
                assert!(bits(one) == bits(own), "drive {place} of {count} on {} hinges", body.joints.len());
            }
        }
    }
}

/// The same body turned about the vertical.
fn turned(body: &Assembly, turn: UnitQuaternion<f64>) -> Assembly {
    let mut body = body.clone();
    for element in &mut body.elements {
        element.pose = Isometry3::from_parts(Translation3::identity(), turn) * element.pose;
    }
    for joint in &mut body.joints {
        if let JointKind::Dof(hinge) = &mut joint.kind {
            hinge.anchor = turn * hinge.anchor;
            hinge.axis = turn * hinge.axis;
        }
    }
    body
}

#[test]
fn the_compass_does_not_matter() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.7);
    for (name, duration) in [("articulated", 2.0), ("rapier", 0.5)] {
        let (body, drive) = (m4(), gait(4, 3, false));
        let straight = run(name, &body, &during(duration), &drive);
        let other = run(name, &turned(&body, turn), &during(duration), &drive);
        for element in 0..body.elements.len() {
            let off = turn * place(&straight, element, duration) - place(&other, element, duration);
            assert!(off.norm() < 1e-3, "{name}: element {element} is off by {} m", off.norm());
        }
    }
}

#[test]
fn a_mirrored_gait_goes_the_mirrored_way() {
    for (name, duration) in [("articulated", 2.0), ("rapier", 0.5)] {
        let (body, drive) = (m4(), gait(4, 3, false));
        let mut swapped = drive.clone();
        for sample in swapped.angles.chunks_mut(4) {
            sample.swap(0, 1);
            sample.swap(2, 3);
        }
        let straight = run(name, &body, &during(duration), &drive);
        let other = run(name, &body, &during(duration), &swapped);
        let (here, there) = (place(&straight, 0, duration), place(&other, 0, duration));
        let off = Vector3::new(here.x - there.x, here.y - there.y, here.z + there.z);
        assert!(off.norm() < 1e-3, "{name}: off by {off}");
    }
}

#[test]
fn sweeps_that_end_early_lead_to_the_same_motion() {
    let (body, drive) = (m4(), gait(4, 2, false));
    let end = |tolerance: f64, iterations: usize| {
        let settings = Settings { tolerance, iterations, ..during(1.5) };
        place(&run("articulated", &body, &settings, &drive), 0, 1.5)
    };
    let truth = end(0.0, 1000);
    let [close, once] = [(1e-3, 1000), (1e9, 1000)].map(|(t, n)| (end(t, n) - truth).norm());
    assert!(close < 1e-3 && once > 2.0 * close, "{close} m, after one sweep a step {once} m");
    // One sweep in a step is what a tolerance that nothing exceeds leaves.
    assert_eq!(end(1e9, 1000), end(1e9, 1));
}

#[test]
fn halving_the_step_converges() {
    let (body, drive) = (m4(), gait(4, 2, false));
    let end = |rate: f64| {
        let settings = Settings { step: 1.0 / rate, iterations: 20, ..during(1.5) };
        place(&run("articulated", &body, &settings, &drive), 0, 1.5)
    };
    let truth = end(7680.0);
    let errors = [60.0, 240.0, 960.0].map(|rate| (end(rate) - truth).norm());
    assert!(errors[1] < 2e-4 && errors[2] < 1e-4, "{errors:?} m");
    assert!(errors[2] < errors[0], "{errors:?} m");
}

/// The two solvers share no physics code, so where they agree both may be
/// right. Slowly, as rapier's servos lag.
#[test]
fn the_solvers_agree_on_a_slow_bend() {
    let body = m2();
    let drive = Targets { interval: 2.0, actuators: 2, angles: vec![0.0, 0.0, 0.9, 0.6] };
    let settings = Settings { iterations: 20, ..during(2.0) };
    let ends = ["articulated", "rapier"].map(|name| run(name, &body, &settings, &drive));
    for element in 0..body.elements.len() {
        let [here, there] = [0, 1].map(|solver: usize| place(&ends[solver], element, 2.0));
        assert!((here - there).norm() < 2e-3, "element {element}: {here} and {there}");
    }
    for (a, b) in ends[0].bends.iter().zip(&ends[1].bends) {
        assert!((a - b).abs() < 0.06, "bends {a} and {b}");
    }
}

#[test]
fn a_body_of_two_hundred_parts_walks() {
    let body = millipede(16);
    assert!(body.elements.len() > 200);
    let motion = run("articulated", &body, &during(2.0), &gait(body.actuators, 3, true));
    let top = (0..motion.frames()).map(|f| place(&motion, 0, motion.time(f)).y).fold(0.0, f64::max);
    assert!(top.is_finite() && top < 0.15, "it rose to {top} m");
}

#[test]
fn extreme_friction_is_stable() {
    for (name, duration) in [("articulated", 10.0), ("rapier", 0.5)] {
        for friction in [0.0, 10.0, 1e4] {
            let mut body = m4();
            for element in &mut body.elements {
                element.friction = friction;
            }
            let settings = Settings { ground_friction: friction, ..during(duration) };
            let motion = run(name, &body, &settings, &gait(4, 1, false));
            let top = (0..motion.frames()).map(|f| place(&motion, 0, motion.time(f)).y).fold(0.0, f64::max);
            assert!(top < 0.15, "{name}, friction {friction}: it rose to {top} m");
        }
    }
}

#[test]
fn a_run_that_goes_wrong_says_so() {
    for name in HINGED {
        let settings = Settings { speed_limit: 0.01, ..during(1.0) };
        let mut simulation = model(name).unwrap().prepare(&m2(), &settings).unwrap();
        let mut drive = gait(2, 1, false);
        assert_eq!(simulation.run(&[drive.clone()])[0].as_ref().unwrap_err(), &Invalid::TooFast, "{name}");
        drive.angles[0] = f64::NAN;
        assert_eq!(simulation.run(&[drive])[0].as_ref().unwrap_err(), &Invalid::NotFinite, "{name}");
    }
}

/// The sentence with which an assembly or its settings are refused.
fn refusal(change: impl FnOnce(&mut Assembly, &mut Settings)) -> String {
    let (mut body, mut settings) = (m2(), settings());
    change(&mut body, &mut settings);
    let reason = |name: &&str| match model(name).unwrap().prepare(&body, &settings) {
        Ok(_) => "was not refused".to_owned(),
        Err(unfit) => unfit.reason,
    };
    let reasons: Vec<_> = HINGED.iter().map(reason).collect();
    assert!(reasons.windows(2).all(|pair| pair[0] == pair[1]), "{reasons:?}");
    reasons[0].clone()
}

fn first_hinge(body: &mut Assembly) -> &mut Dof {
    body.joints.iter_mut().flat_map(|joint| joint.kind.dofs_mut()).next().unwrap()
}

#[test]
fn nonsense_is_refused_with_advice() {
    let cases: Vec<(String, &str)> = vec![
        (refusal(|_, s| s.step = 0.0), "step is 0 s"),
        (refusal(|_, s| s.duration = f64::NAN), "duration is NaN s"),
        (refusal(|_, s| s.step = 30.0), "longer than the duration"),
        (refusal(|_, s| (s.duration, s.record) = (1e5, 0.01)), "let `record` be at least 0.175 s"),
        (refusal(|_, s| s.gravity = -1.0), "it points down"),
        (refusal(|_, s| s.iterations = 0), "at least one iteration"),
        (refusal(|b, _| b.elements[1].mass = 0.0), "element 1 has a mass of 0 kg"),
        (refusal(|b, _| b.elements[1].mass = f64::NAN), "give it a positive mass"),
        (refusal(|b, _| b.elements[2].shape = Shape::Ball { radius: -0.1 }), "positive sizes"),
        (refusal(|b, _| b.elements[2].friction = -0.1), "zero or a positive number"),
        (refusal(|b, _| first_hinge(b).limits = (0.1, 0.5)), "excludes its place at rest"),
        (refusal(|b, _| first_hinge(b).control = servo(7, 3.0)), "number them from zero"),
        (refusal(|b, _| first_hinge(b).effort = -1.0), "largest torque of -1"),
        (refusal(|b, _| b.joints.truncate(3)), "hang together as a tree"),
        (refusal(|b, _| b.joints[0].child = 99), "does not exist"),
        (refusal(|b, _| b.joints.reverse()), "from the core outwards"),
        (refusal(|b, _| *b = Assembly::default()), "at least a core"),
    ];
    for (reason, part) in cases {
        assert!(reason.contains(part), "{reason:?} does not say {part:?}");
    }
}

/// An actuator that goes at a steady pace is as far at each frame as the frame's time says, also where neither the
/// duration nor the frames are multiples of the step.
#[test]
fn frames_and_the_end_are_when_they_say() {
    let arm = crane(1, 0.05, 0.02, 0.3);
    let row = cells([0, 0, 0], [3, 1, 1]);
    let mut swelling = lattice(&row);
    bend(&mut swelling, &row, |_| 1.0);
    let pace = 0.1;
    let drive = Targets { interval: 2.0, actuators: 1, angles: vec![0.0, 2.0 * pace] };
    for (name, body, step) in
        [("articulated", &arm, 0.007), ("rapier", &arm, 0.007), ("balls", &swelling, 0.0009)]
    {
        for (duration, record) in [(0.777, 0.013), (1.0, 0.0101), (0.9, 0.003)] {
            let settings = Settings { step, duration, record, gravity: 0.0, ..settings() };
            let motion = run(name, body, &settings, &drive);
            assert!((motion.time(motion.frames() - 1) - duration).abs() < 1e-12);
            // What it lags behind by is the same in all frames once it is on its way.
            for frame in motion.frames() / 2..motion.frames() {
                let due = pace * (motion.time(frame) - motion.time(frame - 1));
                let way = motion.bends[frame] - motion.bends[frame - 1];
                assert!(
                    (way / due - 1.0).abs() < 0.02,
                    "{name}, frame {frame}: {way} for {due} of {record} s"
                );
            }
        }
    }
}

/// What takes gigabytes is refused before any of them is taken.
#[test]
fn a_body_of_thousands_of_elements_is_refused() {
    let mut body = Builder::default();
    let core = body.add(cube(Vector3::zeros()));
    for k in 1..=1000 {
        let next = body.add(cube(Vector3::x() * (0.1 * f64::from(k))));
        body.join(core, next, JointKind::Rigid);
    }
    for name in ["articulated", "rapier", "rod"] {
        let unfit = model(name).unwrap().prepare(&body.0, &settings()).err().unwrap();
        assert!(unfit.reason.contains("it has 1001 elements"), "{name}: {}", unfit.reason);
    }
}
