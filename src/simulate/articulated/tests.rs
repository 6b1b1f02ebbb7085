//! Truth tests on the tree itself, where gravity may tilt and the root be held.

mod conservation;
mod contacts;
mod joints;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::scalar::Scalar;
use super::solver::Solver;
use super::vector::V3;
use crate::design::assembly::{Assembly, Dof, Element, JointKind, Shape};
use crate::simulate::lowering::Lowered;
use crate::simulate::tests::bodies::{Builder, cube, element, hinge, m4};
use crate::simulate::tests::settings;
use crate::simulate::{Settings, World};

fn solver<S: Scalar<Kit = ()>>(assembly: &Assembly, settings: &Settings) -> Solver<S> {
    Solver::new((), &Lowered::new(assembly, settings).unwrap(), settings, &[World::NOMINAL])
}

/// A solver in the air.
fn aloft<S: Scalar<Kit = ()>>(assembly: &Assembly, settings: &Settings) -> Solver<S> {
    let mut solver = solver(assembly, settings);
    solver.ground = None;
    solver
}

/// A hinge without a servo.
fn loose(anchor: Vector3<f64>, axis: Vector3<f64>) -> Dof {
    let free = (-1e3, 1e3);
    Dof { stiffness: 0.0, damping: 0.0, limits: free, ..hinge(anchor, axis, 0) }
}

/// A row of balls along x, each hinged at its own distance from the last.
fn chain<J: Into<JointKind>>(links: usize, pitch: f64, joint: impl Fn(Vector3<f64>) -> J) -> Assembly {
    let mut body = Builder::default();
    let mut last = body.add(cube(Vector3::zeros()));
    body.0.actuators = 1;
    for link in 0..links {
        let anchor = Vector3::x() * (pitch * link as f64);
        let ball =
            element(Shape::Ball { radius: 0.005 }, Translation3::from(anchor + Vector3::x() * pitch).into());
        let child = body.add(ball);
        body.join(last, child, joint(anchor).into());
        last = child;
    }
    body.0
}

fn fine(step: f64) -> Settings {
    Settings { step, self_collision: false, speed_limit: 1e3, ..settings() }
}

#[test]
fn a_free_body_falls_as_galileo_says() {
    let step = 1.0 / 240.0;
    let mut solver = aloft::<f32>(&m4(), &fine(step));
    let start = f64::from(solver.state.position[1]);
    for _ in 0..120 {
        solver.advance();
    }
    let expected = 981.0 * 0.5 * 0.5 * 0.5;
    let fallen = start - f64::from(solver.state.position[1]);
    assert!((fallen - expected).abs() < 1e-3 * expected, "{fallen} cm, not {expected}");
}

/// The time of a full swing of a point-like pendulum released at an angle.
fn period(amplitude: f64) -> (f64, f64) {
    let step = 1.0 / 2000.0;
    let mut solver = aloft::<f64>(&chain(1, 0.1, |anchor| loose(anchor, Vector3::z())), &fine(step));
    solver.anchored = true;
    // At rest the pendulum lies along x; hanging is minus a quarter turn.
    let hanging = -std::f64::consts::FRAC_PI_2;
    solver.state.positions[1] = hanging + amplitude;
    solver.begin();
    let (mut crossings, mut before) = (Vec::new(), amplitude);
    for count in 1..8000 {
        solver.advance();
        let now = solver.state.positions[1] - hanging;
        if before > 0.0 && now <= 0.0 {
            crossings.push((f64::from(count) - now / (now - before)) * step);
        }
        before = now;
    }
    // A ball of radius r on a rod L: I = m (L^2 + 2 r^2 / 5).
    let small = std::f64::consts::TAU * ((0.01 + 0.4 * 25e-6) / (9.81 * 0.1_f64)).sqrt();
    (crossings[1] - crossings[0], small)
}

#[test]
fn a_pendulum_keeps_time() {
    let (measured, small) = period(0.05);
    assert!((measured / small - 1.0).abs() < 5e-4, "{measured} s, not {small}");
    // The series of the complete elliptic integral at 2 rad, by the
    // arithmetic-geometric mean of 1 and cos(1).
    let (mut a, mut b) = (1.0, libm::cos(1.0_f64));
    for _ in 0..20 {
        (a, b) = ((a + b) / 2.0, (a * b).sqrt());
    }
    let (measured, small) = period(2.0);
    assert!((measured * a / small - 1.0).abs() < 2e-3, "{measured} s, not {}", small / a);
}

/// A motorless chain of uneven bodies spinning in the air without weight.
fn tumbling<S: Scalar<Kit = ()>>(step: f64) -> Solver<S> {
    let axes = [Vector3::z(), Vector3::y(), Vector3::new(1.0, 1.0, 0.0)];
    let joint = |anchor: Vector3<f64>| loose(anchor, axes[(anchor.x * 40.0) as usize % 3]);
    thrown(chain(3, 0.03, joint), step)
}

/// A chain, made uneven, that turns and flies in the air without weight, each joint with a speed.
fn thrown<S: Scalar<Kit = ()>>(mut assembly: Assembly, step: f64) -> Solver<S> {
    for (place, element) in assembly.elements.iter_mut().enumerate() {
        element.shape = Shape::Box { half: Vector3::new(0.004, 0.012, 0.02 - 0.004 * place as f64) };
        element.mass = 0.01;
        // Away from all joints, or half of the terms would be zero.
        element.pose.translation.vector += Vector3::new(-0.01, 0.004, 0.002);
    }
    let mut solver = aloft::<S>(&assembly, &Settings { gravity: 0.0, ..fine(step) });
    for (dof, speed) in solver.state.speeds.iter_mut().enumerate() {
        *speed = S::of((), [4.0, -2.0, 3.0][dof % 3]);
    }
    solver.begin();
    solver
}

fn energy_of<S: Scalar>(solver: &Solver<S>) -> f64 {
    solver.energy().lane(0)
}

#[test]
fn what_cannot_be_ends_the_run() {
    use crate::simulate::Invalid;
    let after = |harm: &dyn Fn(&mut Solver<f32>)| {
        let mut solver = solver::<f32>(&m4(), &settings());
        (0..240).for_each(|_| solver.advance());
        assert_eq!(solver.failures, [None], "a body at rest is fine");
        harm(&mut solver);
        solver.begin();
        (0..16).for_each(|_| solver.advance());
        solver.failures[0]
    };
    assert_eq!(after(&|_| {}), None);
    assert_eq!(after(&|solver| solver.state.position[1] = -20.0), Some(Invalid::Sunk));
    assert_eq!(after(&|solver| solver.state.speeds[4] = 120.0), Some(Invalid::EnergyFromNowhere));
    assert_eq!(after(&|solver| solver.state.speeds[4] = 1e5), Some(Invalid::TooFast));
    assert_eq!(after(&|solver| solver.state.speeds[7] = f32::NAN), Some(Invalid::NotFinite));
}

/// Largest and last change of energy, relative to that at the start.
fn energy_drift<S: Scalar<Kit = ()>>(step: f64) -> (f64, f64) {
    let mut solver = tumbling::<S>(step);
    let start = energy_of(&solver);
    let mut most = 0.0_f64;
    for _ in 0..(0.5 / step) as usize {
        solver.advance();
        most = most.max(energy_of(&solver) / start - 1.0);
    }
    (most, energy_of(&solver) / start - 1.0)
}

#[test]
fn a_free_chain_keeps_its_energy() {
    let (coarse, _) = energy_drift::<f32>(1.0 / 240.0);
    // First order in the step: the coarse one may gain a little.
    assert!(coarse < 0.05, "gained {coarse}");
    let (fine, last) = energy_drift::<f64>(1.0 / 30720.0);
    assert!(fine < 5e-4 && last.abs() < 5e-4, "gained {fine}, ended at {last}");
}

/// Momentum and angular momentum about the origin, g cm/s and g cm^2/s.
fn momenta(solver: &Solver<f64>) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (frame, link) in solver.frames.iter().zip(&solver.tree.links) {
        let momentum = frame.velocity * link.mass;
        let own = link.inertia.rotated(&frame.rotation) * frame.spin;
        let turning = own + (solver.state.position + frame.centre).cross(momentum);
        for axis in 0..3 {
            sum[axis] += momentum[axis];
            sum[3 + axis] += turning[axis];
        }
    }
    sum
}

/// Sees that a body has the same momenta after some steps.
fn keeps_momenta(solver: &mut Solver<f64>, steps: usize) {
    let start = momenta(solver);
    (0..steps).for_each(|_| solver.advance());
    let end = momenta(solver);
    for part in [0..3, 3..6] {
        let size: f64 = part.clone().map(|i| start[i].powi(2)).sum::<f64>().sqrt();
        let off: f64 = part.map(|i| (end[i] - start[i]).powi(2)).sum::<f64>().sqrt();
        assert!(off < 1e-3 * size, "{start:?} became {end:?}");
    }
}

#[test]
fn a_free_chain_keeps_its_momenta() {
    keeps_momenta(&mut tumbling(1.0 / 30720.0), 15360);
}

#[test]
fn a_spinning_body_turns_as_fast_as_it_spins() {
    let mut solver = aloft::<f32>(&sled(), &fine(1.0 / 240.0));
    solver.state.speeds[1] = 3.0;
    solver.begin();
    for _ in 0..240 {
        solver.advance();
    }
    let [w, _, y, _] = solver.state.rotation.0.map(f64::from);
    assert!((2.0 * libm::atan2(y, w) - 3.0).abs() < 1e-4, "{w}, {y}");
}

fn sled() -> Assembly {
    Assembly { elements: vec![cube(Vector3::zeros())], ..Assembly::default() }
}

#[test]
fn a_block_slides_as_far_as_friction_says() {
    for friction in [0.1, 0.8] {
        let settings = Settings { ground_friction: friction * friction / 0.8, ..fine(1.0 / 240.0) };
        let mut solver = solver::<f32>(&sled(), &settings);
        // Across the tangents, to see that the cone is round.
        let speed = 100.0_f64;
        (solver.state.speeds[3], solver.state.speeds[5]) = (60.0, 80.0);
        solver.begin();
        for _ in 0..720 {
            solver.advance();
        }
        let [x, _, z] = solver.state.position.0.map(f64::from);
        let expected = speed * speed / (2.0 * friction * 981.0);
        assert!(
            (libm::hypot(x, z) / expected - 1.0).abs() < 2e-3,
            "{} cm, not {expected}",
            libm::hypot(x, z)
        );
        assert!((z / x - 4.0 / 3.0).abs() < 0.01, "it turned aside: {x}, {z}");
    }
}

/// How far a block gets in two seconds on a slope with friction 0.8, cm.
fn slide(tangent: f64, shape: Shape) -> f64 {
    let element = element(shape, Isometry3::identity());
    let assembly = Assembly { elements: vec![element], ..Assembly::default() };
    let mut solver = solver::<f32>(&assembly, &fine(1.0 / 240.0));
    let slope = libm::atan(tangent);
    let (s, c) = libm::sincos(slope);
    solver.gravity = V3([(981.0 * s * 0.6) as f32, (-981.0 * c) as f32, (981.0 * s * 0.8) as f32]);
    // It may roll as fast as it can.
    solver.turn_limit = f32::MAX;
    for _ in 0..480 {
        solver.advance();
    }
    let V3([x, _, z]) = solver.state.position;
    libm::hypot(f64::from(x), f64::from(z))
}

#[test]
fn a_block_rests_on_a_slope_below_the_friction_angle() {
    let flat = Shape::Box { half: Vector3::new(0.03, 0.01, 0.03) };
    let rest = slide(0.76, flat);
    assert!(rest < 0.01, "crept {rest} cm");
    let far = slide(0.9, flat);
    let slope = libm::atan(0.9);
    let expected = 0.5 * 981.0 * (libm::sin(slope) - 0.8 * libm::cos(slope)) * 4.0;
    assert!((far / expected - 1.0).abs() < 0.03, "slid {far} cm, not {expected}");
}

/// A ball, a cylinder and a capsule roll down a slope with the inertia of a filled body.
#[test]
fn round_bodies_roll() {
    let radius = 0.02;
    let slope = libm::atan(0.1);
    let ball = slide(0.1, Shape::Ball { radius });
    let expected = 0.5 * 981.0 * libm::sin(slope) * 4.0 / 1.4;
    assert!((ball / expected - 1.0).abs() < 0.02, "ball {ball} cm, not {expected}");

    // Of a capsule, the ends have the inertia of a ball.
    let (tube, ends) = (2.0 * 0.03, 4.0 / 3.0 * radius);
    let mixed = (0.5 * tube + 0.4 * ends) / (tube + ends);
    for (shape, inertia) in [
        (Shape::Cylinder { radius, half_length: 0.03 }, 0.5),
        (Shape::Capsule { radius, half_straight: 0.03 }, mixed),
    ] {
        let lying = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.3);
        let pose = Isometry3::from_parts(Translation3::identity(), lying);
        let assembly = Assembly { elements: vec![element(shape, pose)], ..Assembly::default() };
        let mut solver = solver::<f32>(&assembly, &fine(1.0 / 240.0));
        let down = lying * Vector3::z();
        let s = 981.0 * libm::sin(slope);
        solver.gravity = V3([(s * down.x) as f32, (-981.0 * libm::cos(slope)) as f32, (s * down.z) as f32]);
        solver.turn_limit = f32::MAX;
        for _ in 0..480 {
            solver.advance();
        }
        let [x, y, z] = solver.state.position.0.map(f64::from);
        let (far, expected) = (libm::hypot(x, z), 0.5 * s * 4.0 / (1.0 + inertia));
        assert!((far / expected - 1.0).abs() < 0.02, "{shape:?}: {far} cm, not {expected}");
        assert!((y - 2.0).abs() < 0.01, "it hops or sinks: {y}");
    }
}

/// On ice nothing pushes sideways: a capsule that falls over sinks straight down, and ends on its side.
#[test]
fn a_capsule_falls_over_on_ice() {
    for tilt in [0.1, 0.7, 1.3] {
        // From standing: its x axis is nearly upright.
        let leaning = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2 - tilt);
        let pose = Isometry3::from_parts(Translation3::identity(), leaning);
        let capsule = element(Shape::Capsule { radius: 0.01, half_straight: 0.02 }, pose);
        let assembly = Assembly { elements: vec![capsule], ..Assembly::default() };
        let settings = Settings { ground_friction: 0.0, ..fine(1.0 / 240.0) };
        let mut solver = solver::<f32>(&assembly, &settings);
        for _ in 0..960 {
            solver.advance();
        }
        let [x, y, z] = solver.state.position.0.map(f64::from);
        assert!(libm::hypot(x, z) < 1e-3, "tilt {tilt}: went {x}, {z} cm");
        assert!((y - 1.0).abs() < 0.01, "tilt {tilt}: at {y} cm");
    }
}

/// Cylinders stand, and lie, without moving; a leaning one falls over.
#[test]
fn cylinders_rest() {
    let quarter = std::f64::consts::FRAC_PI_2;
    for (tilt, height) in [(0.0, 1.0), (quarter, 1.5), (1.45, 1.5), (0.1, 1.0)] {
        for turn in [0.0, 0.4] {
            let about = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), tilt);
            let spin = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), turn);
            let pose = Isometry3::from_parts(Translation3::identity(), about * spin);
            let cylinder = element(Shape::Cylinder { radius: 0.01, half_length: 0.015 }, pose);
            let assembly = Assembly { elements: vec![cylinder], ..Assembly::default() };
            let mut solver = solver::<f32>(&assembly, &fine(1.0 / 240.0));
            for _ in 0..960 {
                solver.advance();
            }
            let V3([x, y, z]) = solver.state.position;
            let y = f64::from(y);
            assert!((y - height).abs() < 0.01, "tilt {tilt}, turn {turn}: height {y}, not {height}");
            if tilt == 0.0 || tilt == quarter {
                assert!(libm::hypotf(x, z) < 1e-3, "tilt {tilt}, turn {turn}: crept {x}, {z}");
            }
            let speed = solver.state.speeds.iter().map(|v| v.abs()).fold(0.0, f32::max);
            assert!(speed < 0.02, "tilt {tilt}, turn {turn}: still moves at {speed}");
        }
    }
}

/// Deflection of the tip of N equal segments under a force at the tip.
#[test]
fn a_cantilever_bends_by_the_closed_form() {
    let (count, pitch, stiffness, force) = (5, 0.02, 0.3, 0.02);
    let joint = |anchor| Dof { stiffness, effort: 1e3, ..hinge(anchor, Vector3::z(), 0) };
    let mut solver = aloft::<f32>(&chain(count, pitch, joint), &fine(1.0 / 240.0));
    solver.anchored = true;
    // Only the tip has weight to speak of: gravity is the tip force.
    for link in &mut solver.tree.links[1..count] {
        link.mass = 1e-4;
    }
    let tip = f64::from(solver.tree.links[count].mass);
    solver.gravity = V3([0.0, (-force * 1e5 / tip) as f32, 0.0]);
    for _ in 0..2400 {
        solver.advance();
    }
    let length = pitch * count as f64;
    let sum: f64 = (0..count).map(|i| ((count - i) as f64 / count as f64).powi(2)).sum();
    let expected = 100.0 * force * length * length / stiffness * sum;
    let sag = -f64::from(solver.frames[count].centre[1]);
    assert!((sag / expected - 1.0).abs() < 0.01, "{sag} cm, not {expected}");
}

/// A servo holds a load at load / stiffness, and gives way above its limit.
#[test]
fn a_servo_holds_what_its_torque_allows() {
    let pitch = 0.05;
    let assembly = chain(1, pitch, |anchor| hinge(anchor, Vector3::z(), 0));
    for (load, holds) in [(0.02, true), (0.0595, true), (0.0605, false)] {
        let mut solver = aloft::<f32>(&assembly, &fine(1.0 / 240.0));
        solver.anchored = true;
        let mass = f64::from(solver.tree.links[1].mass);
        // Always across the arm's rest direction, and the sag is small.
        solver.gravity = V3([0.0, (-load * 1e7 / (mass * pitch * 100.0)) as f32, 0.0]);
        for _ in 0..1200 {
            solver.advance();
        }
        let angle = f64::from(solver.state.positions[1]);
        if holds {
            let torque = load * libm::cos(angle);
            assert!((-angle * 0.3 / torque - 1.0).abs() < 2e-3, "{load} N m bent it by {angle}");
        }
    }
    // Far from its target, a servo gives exactly its torque.
    let weak = chain(1, pitch, |anchor| Dof { effort: 1e-3, ..hinge(anchor, Vector3::z(), 0) });
    let mut solver = aloft::<f64>(&weak, &fine(1.0 / 240.0));
    solver.anchored = true;
    solver.gravity = V3([0.0; 3]);
    // A target is where the servo is to be when the step ends: it acts from then on.
    solver.targets[0] = 0.7;
    solver.advance();
    assert_eq!(solver.state.speeds[6], 0.0);
    solver.advance();
    let link = &solver.tree.links[1];
    let inertia = link.mass * 25.0 + link.inertia.0[2];
    let speed = link.effort / inertia / 240.0;
    // The momentum of a turn is that of the chord.
    let found = libm::sin(solver.state.speeds[6] / 240.0) * 240.0;
    assert!((found / speed - 1.0).abs() < 1e-6, "{found} rad/s, not {speed}");
}

#[test]
fn hinges_keep_their_hard_limits() {
    let joint = |anchor| Dof { limits: (-0.5, 0.4), ..loose(anchor, Vector3::z()) };
    let mut solver = aloft::<f32>(&chain(3, 0.03, joint), &fine(1.0 / 240.0));
    solver.anchored = true;
    for _ in 0..960 {
        solver.advance();
        for &angle in &solver.state.positions[1..] {
            assert!((-0.53..0.43).contains(&angle), "{angle}");
        }
    }
    assert!((solver.state.positions[1] + 0.5).abs() < 2e-3, "{}", solver.state.positions[1]);
}

/// A blow makes a joint much faster than it would be without it: the limit holds in that step, too.
#[test]
fn hinges_keep_their_hard_limits_in_a_blow() {
    let joint = |anchor| Dof { limits: (-0.2, 0.15), ..loose(anchor, Vector3::z()) };
    for height in [0.3_f32, 1.0, 3.0] {
        let mut solver = solver::<f32>(&chain(3, 0.03, joint), &fine(1.0 / 240.0));
        // At rest it stands on the ground.
        solver.state.position[1] += height * 100.0;
        solver.begin();
        let mut most = 0.0_f32;
        for _ in 0..480 {
            solver.advance();
            for &angle in &solver.state.positions[1..] {
                most = most.max(angle - 0.15).max(-0.2 - angle);
            }
        }
        assert!(most < 2e-3, "from {height} m: {most} rad beyond");
    }
}

/// A servo that follows a steady target lags by what its damping takes.
#[test]
fn a_moving_servo_lags_by_its_damping() {
    let assembly = chain(1, 0.05, |anchor| hinge(anchor, Vector3::z(), 0));
    let mut solver = aloft::<f32>(&assembly, &Settings { gravity: 0.0, ..fine(1.0 / 240.0) });
    solver.anchored = true;
    for step in 1..=120 {
        solver.targets[0] = step as f32 / 240.0;
        solver.advance();
    }
    let lag = f64::from(solver.targets[0] - solver.state.positions[1]);
    assert!((lag * 0.3 / 0.01 - 1.0).abs() < 3e-3, "{lag} rad");
}

/// Two parts driven into each other do not pass through.
#[test]
fn parts_do_not_pass_through_each_other() {
    // Boxes and cylinders meet with their far edges: sharp ones would stop 2.28 cm apart.
    for (shape, least, most) in [
        (Shape::Ball { radius: 0.01 }, 1.97, 2.01),
        (Shape::Box { half: Vector3::repeat(0.01) }, 2.15, 2.24),
        (Shape::Cylinder { radius: 0.01, half_length: 0.01 }, 2.15, 2.24),
        (Shape::Capsule { radius: 0.01, half_straight: 0.005 }, 1.97, 2.7),
    ] {
        let mut body = Builder::default();
        body.0.actuators = 2;
        let core = body.add(cube(Vector3::zeros()));
        for (actuator, side) in [(0, 1.0), (1, -1.0)] {
            let place = Vector3::new(0.06, 0.0, 0.02 * side);
            let tip: Element = element(shape, Translation3::from(place).into());
            let tip = body.add(tip);
            let axis = Vector3::y() * side;
            let anchor = Vector3::new(0.0, 0.0, 0.02 * side);
            body.join(core, tip, JointKind::Dof(hinge(anchor, axis, actuator)));
        }
        let mut solver = aloft::<f32>(&body.0, &Settings { self_collision: true, ..fine(1.0 / 240.0) });
        solver.anchored = true;
        solver.gravity = V3([0.0; 3]);
        solver.targets.fill(0.8);
        for _ in 0..480 {
            solver.advance();
            let apart = solver.frames[1].centre[2] - solver.frames[2].centre[2];
            assert!(apart > least, "{shape:?}: {apart} cm apart");
        }
        let end = solver.state.positions.clone();
        solver.reset();
        for _ in 0..480 {
            solver.advance();
        }
        assert_eq!(end, solver.state.positions, "{shape:?}: not the same again");
        let apart = solver.frames[1].centre[2] - solver.frames[2].centre[2];
        assert!(apart < most, "{shape:?}: stopped {apart} cm apart");
    }
}

/// What `no_overlap` forgives does not let parts pass through each other; a wheel that is drawn over a hub turns about it.
#[test]
fn parts_across_a_joint_collide_unless_they_overlap() {
    for (overlap, collide) in [(-0.002, true), (0.0, true), (0.0002, true), (0.004, false)] {
        let mut body = Builder::default();
        body.0.actuators = 1;
        let core = body.add(cube(Vector3::zeros()));
        let arm = body.add(cube(Vector3::new(0.035, 0.0, 0.0)));
        body.join(core, arm, JointKind::Dof(hinge(Vector3::new(0.0175, 0.0, 0.0), Vector3::y(), 0)));
        let post = body.add(cube(Vector3::new(0.035, 0.0, 0.03 - overlap)));
        body.join(core, post, JointKind::Rigid);
        let pairs = super::colliding(&Lowered::new(&body.0, &settings()).unwrap());
        // The arm and the core are joined, the post and the core are one body.
        assert_eq!(pairs, if collide { vec![(post, arm)] } else { vec![] }, "{overlap} m");
    }
}

/// Milliseconds for 20 s of a gait, and where the core ends.
fn timed<S: Scalar<Kit = ()>>(assembly: &Assembly, drives: &[crate::simulate::Targets]) -> (f64, Vec<f64>) {
    use crate::simulate::run::{Run, alone};
    let settings = settings();
    let lowered = Lowered::new(assembly, &settings).unwrap();
    let mut run = Run::new(solver::<S>(assembly, &settings), lowered.driven(), &settings, &[World::NOMINAL]);
    alone(&mut run, &drives[0]).unwrap();
    let start = std::time::Instant::now();
    let motions: Vec<_> = drives.iter().map(|drive| alone(&mut run, drive)).collect();
    let time = start.elapsed().as_secs_f64() * 1e3 / drives.len() as f64;
    let way = |m: &crate::simulate::Motion| {
        100.0
            * (m.pose(0, 20.0).unwrap().translation.vector - m.pose(0, 0.0).unwrap().translation.vector)
                .norm()
    };
    (time, motions.iter().map(|m| m.as_ref().map_or(f64::NAN, way)).collect())
}

#[test]
#[ignore = "prints measurements"]
fn report_precision() {
    use crate::simulate::tests::bodies::{gait, m2, m8};
    for body in [m2(), m4(), m8()] {
        let drives: Vec<_> = (1..7).map(|n| gait(body.actuators, n, n % 2 == 1)).collect();
        let (single, double) = (timed::<f32>(&body, &drives), timed::<f64>(&body, &drives));
        println!("f32 {:.1} ms {:.2?}\nf64 {:.1} ms {:.2?}", single.0, single.1, double.0, double.1);
    }
}

/// The most energy that came from nowhere in a gait, as a height of the whole body in cm.
fn most_gained(body: &Assembly, drive: &crate::simulate::Targets, settings: &Settings) -> f64 {
    let lowered = Lowered::new(body, settings).unwrap();
    let mut solver = solver::<f32>(body, settings);
    let mut servos = lowered.servos.clone();
    let mut most = 0.0_f64;
    for step in 1..=(settings.duration / settings.step) as usize {
        for (place, servo) in servos.iter_mut().enumerate() {
            servo.follow(|actuator| drive.asked(actuator, step as f64 * settings.step), settings.step);
            solver.targets[place] = servo.target as f32;
        }
        solver.advance();
        most = most.max(f64::from(solver.ledger.gained / solver.ledger.allowed));
    }
    most
}

#[test]
#[ignore = "prints measurements"]
fn report_energy() {
    use crate::simulate::tests::bodies::{gait, m2, m8};
    for body in [m2(), m4(), m8()] {
        for step in [1.0 / 120.0, 1.0 / 240.0, 1.0 / 480.0] {
            let settings = Settings { step, ..settings() };
            let gains: Vec<_> = (1..9)
                .map(|n| {
                    format!("{:.3}", most_gained(&body, &gait(body.actuators, n, n % 2 == 1), &settings))
                })
                .collect();
            println!("step {step:.4} s: {}", gains.join(" "));
        }
    }
}
