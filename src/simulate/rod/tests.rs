//! What rods must get right.

use nalgebra::{Isometry3, Point3, Translation3, UnitVector3, Vector3};

use super::Rod;
use super::again::Again;
use super::section::{POISSON, Section};
use super::solver::Rods;
use crate::design::assembly::{Assembly, Control, Dof, Element, Joint, JointKind, Shape, Travel};
use crate::simulate::articulated::Articulated;
use crate::simulate::tests::bodies::{Builder, element, gait, hinge, idle, m2, m4, servo};
use crate::simulate::tests::settings;
use crate::simulate::{Case, Invalid, Model, Motion, Settings, Simulation, Stop, Targets, Watch, World};

const RADIUS: f64 = 0.009;
const LENGTH: f64 = 0.08;

/// A heavy block high above the ground, which carries a row of segments along x, so heavy in kg, with hinges of a stiffness in N m/rad. Each
/// hinge is in the middle of its share of the length, as in designs: the segments at the ends are half as long as the others.
fn arm(segments: usize, mass: f64, stiffness: f64, axis: Vector3<f64>) -> Assembly {
    let mut body = Builder::default();
    let half = Vector3::new(0.05, 0.5, 0.05);
    let mut base: Element = element(Shape::Box { half }, Translation3::new(-0.05, 0.0, 0.0).into());
    base.mass = 1e3;
    let base = body.add(base);
    body.0.actuators = 1;
    let share = LENGTH / (segments - 1) as f64;
    let (mut last, mut begin) = (base, 0.0);
    for segment in 0..segments {
        let end = (share * (segment as f64 + 0.5)).min(LENGTH);
        let place = Vector3::x() * (0.5 * (begin + end));
        let shape = Shape::Cylinder { radius: RADIUS, half_length: 0.5 * (end - begin) };
        let pose: Isometry3<f64> = Translation3::from(place).into();
        let mut own = element(shape, pose);
        own.mass = mass * (end - begin) / LENGTH;
        let child = body.add(own);
        let dof = Dof {
            anchor: Point3::new(begin, 0.0, 0.0),
            axis: UnitVector3::new_normalize(axis),
            control: servo(0, 1e3),
            share: 1.0 / (segments - 1) as f64,
            limits: (-3.0, 3.0),
            stiffness,
            damping: 0.02 * stiffness,
            effort: 1e3,
            ..hinge(Vector3::zeros(), axis, 0)
        };
        let kind = if segment == 0 { JointKind::Rigid } else { JointKind::Dof(dof) };
        body.join(last, child, kind);
        (last, begin) = (child, end);
    }
    body.0
}

/// How far the middle of the last segment is from the beginning of the row, m.
fn reach(segments: usize) -> f64 {
    LENGTH - LENGTH / (segments - 1) as f64 / 4.0
}

fn run(discs: usize, body: &Assembly, settings: &Settings, drive: &Targets) -> Motion {
    let mut simulation = Rod { discs, stiffer: 1.0 }.prepare(body, settings).unwrap();
    simulation.run(std::slice::from_ref(drive)).remove(0).unwrap()
}

fn during(duration: f64) -> Settings {
    Settings { duration, self_collision: false, ..settings() }
}

/// Where the last segment is at the end, and how far it is turned about an axis.
fn end(motion: &Motion, body: &Assembly) -> Isometry3<f64> {
    motion.pose(body.elements.len() - 1, motion.duration).unwrap()
}

/// Stiffness of the row against bending, N m^2: that of its hinges together.
fn flexural(segments: usize, stiffness: f64) -> f64 {
    stiffness * LENGTH / (segments - 1) as f64
}

/// A rod under its own weight sags by q L^4 / 8 E I and the shear q L^2 / 2 kappa G A; that of its last segment, which is not at its end, by the
/// same law. Also out of the driven plane, where hinges do not give way at all.
#[test]
fn a_cantilever_sags_by_the_closed_form_in_every_plane() {
    let (segments, mass, stiffness) = (4, 0.01, 0.1);
    let (rigid, q) = (flexural(segments, stiffness), mass * 9.81 / LENGTH);
    let section = Section::round(RADIUS);
    let shear = rigid / section.driven / (2.0 * (1.0 + POISSON)) * section.shear * section.area;
    let x = reach(segments);
    let bending = q * x * x / (24.0 * rigid) * (x * x - 4.0 * LENGTH * x + 6.0 * LENGTH * LENGTH);
    let expected = bending + q * (LENGTH * x - x * x / 2.0) / shear;
    for axis in [Vector3::z(), Vector3::y()] {
        let body = arm(segments, mass, stiffness, axis);
        for (discs, near) in [(2, 0.03), (8, 0.004)] {
            let motion = run(discs, &body, &during(3.0), &idle(1));
            let base = motion.pose(0, 3.0).unwrap().translation.vector.y
                - motion.pose(0, 0.0).unwrap().translation.vector.y;
            let sag = motion.pose(segments, 0.0).unwrap().translation.vector.y + base
                - end(&motion, &body).translation.vector.y;
            assert!((sag / expected - 1.0).abs() < near, "{discs} about {axis:?}: {sag} m, not {expected}");
        }
    }
}

/// What a row says of its stiffness across the axis counts in place of that of a solid rod: it bends less by that factor.
#[test]
fn a_row_may_say_how_stiff_it_is_sideways() {
    let (segments, mass, stiffness) = (4, 0.01, 0.1);
    let (rigid, q) = (flexural(segments, stiffness), mass * 9.81 / LENGTH);
    let section = Section::round(RADIUS);
    let shear = rigid / section.driven / (2.0 * (1.0 + POISSON)) * section.shear * section.area;
    let x = reach(segments);
    let bending = q * x * x / (24.0 * 3.0 * rigid) * (x * x - 4.0 * LENGTH * x + 6.0 * LENGTH * LENGTH);
    let expected = bending + q * (LENGTH * x - x * x / 2.0) / shear;
    let mut body = arm(segments, mass, stiffness, Vector3::y());
    each_hinge(&mut body, |dof| dof.sideways = Some(3.0 * stiffness));
    let motion = run(8, &body, &during(3.0), &idle(1));
    let base =
        motion.pose(0, 3.0).unwrap().translation.vector.y - motion.pose(0, 0.0).unwrap().translation.vector.y;
    let sag = motion.pose(segments, 0.0).unwrap().translation.vector.y + base
        - end(&motion, &body).translation.vector.y;
    assert!((sag / expected - 1.0).abs() < 0.01, "{sag} m, not {expected}");
}

/// A weight beside the tip twists the row by the torsion that it says, and hardly bends it.
#[test]
fn a_row_may_say_how_stiff_it_is_against_twisting() {
    let (segments, torsion, side) = (4, 0.1, 0.03);
    let mut body = arm(segments, 1e-4, 10.0, Vector3::z());
    each_hinge(&mut body, |dof| {
        dof.torsion = Some(torsion);
        dof.damping = 0.2;
    });
    let mut weight = element(Shape::Ball { radius: 0.004 }, Translation3::new(LENGTH, 0.0, side).into());
    weight.mass = 0.005;
    let last = body.elements.len() - 1;
    body.elements.push(weight);
    body.joints.push(Joint { parent: last, child: last + 1, kind: JointKind::Rigid });
    let motion = run(8, &body, &during(3.0), &idle(1));
    let turned = motion.pose(0, 3.0).unwrap().rotation.inverse() * motion.pose(last, 3.0).unwrap().rotation;
    let angle = turned.scaled_axis().x;
    // The last segment is turned by nearly the whole angle; the lever gets shorter as it goes down.
    let whole = (segments - 1) as f64 / torsion;
    let due = 0.005 * 9.81 * side * libm::cos(angle) * whole * reach(segments) / LENGTH;
    assert!((angle / due - 1.0).abs() < 0.05, "{angle} rad, not {due}");
}

fn each_hinge(body: &mut Assembly, change: impl Fn(&mut Dof)) {
    for joint in &mut body.joints {
        joint.kind.dofs_mut().iter_mut().for_each(&change);
    }
}

/// What is asked to bend by an angle becomes an arc of that angle.
#[test]
fn a_bent_rod_is_an_arc() {
    let body = arm(4, 0.01, 0.3, Vector3::z());
    let settings = Settings { gravity: 0.0, ..during(2.0) };
    let asked = 2.5;
    let drive = Targets { interval: 1.0, actuators: 1, angles: vec![asked; 3] };
    for (discs, near) in [(2, 1e-3), (8, 1e-4)] {
        let motion = run(discs, &body, &settings, &drive);
        assert!((motion.bends.last().unwrap() - asked).abs() < 1e-3, "{:?}", motion.bends.last());
        let (at, radius) = (asked * reach(4) / LENGTH, LENGTH / asked);
        let due = Vector3::new(radius * libm::sin(at), radius * (1.0 - libm::cos(at)), 0.0);
        let base = motion.pose(0, 2.0).unwrap() * Vector3::new(0.05, 0.0, 0.0);
        let found = end(&motion, &body).translation.vector
            - motion.pose(0, 2.0).unwrap().translation.vector
            - Vector3::x() * 0.05;
        assert!((found - due).norm() < near * 10.0, "{discs}: {found} for {due}, {base}");
    }
}

/// The first frequency of a cantilever is that of Timoshenko's beam: squared periods of bending, shear and turning add up (Dunkerley).
#[test]
fn a_plucked_rod_swings_at_its_first_frequency() {
    let (segments, mass, stiffness) = (4, 0.02, 0.05);
    let mut body = arm(segments, mass, stiffness, Vector3::z());
    for joint in &mut body.joints {
        for dof in joint.kind.dofs_mut() {
            dof.damping = 0.0;
        }
    }
    let (beta, line, section) = (1.875_104_07_f64, mass / LENGTH, Section::round(RADIUS));
    let rigid = flexural(segments, stiffness);
    let young = rigid / section.driven;
    let shear = young / (2.0 * (1.0 + POISSON)) * section.shear * section.area;
    let bending = beta.powi(4) * rigid / (line * LENGTH.powi(4));
    let shearing = (std::f64::consts::PI / (2.0 * LENGTH)).powi(2) * shear / line;
    // The inertia of the slices against turning counts as the shear does, by the ratio of the two moduli.
    let turning = shearing * young * section.area / shear;
    let due = (1.0 / (1.0 / bending + 1.0 / shearing + 1.0 / turning)).sqrt() / std::f64::consts::TAU;
    let settings = Settings { step: 1.0 / 3840.0, record: 1.0 / 960.0, gravity: 0.0, ..during(1.0) };
    // Asked to bend a little, and then to be straight again.
    let drive = Targets { interval: 0.1, actuators: 1, angles: [vec![0.05; 3], vec![0.0; 9]].concat() };
    let motion = run(8, &body, &settings, &drive);
    let bends: Vec<f64> = motion.bends.clone();
    let from = (0.35 / settings.record) as usize;
    let crossings: Vec<f64> = (from..bends.len() - 1)
        .filter(|i| bends[*i] < 0.0 && bends[i + 1] >= 0.0)
        .map(|i| (i as f64 + bends[i] / (bends[i] - bends[i + 1])) * settings.record)
        .collect();
    assert!(crossings.len() > 2, "{due} Hz: {crossings:?}");
    let found = (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0]);
    assert!((found / due - 1.0).abs() < 0.01, "{found} Hz, not {due}");
}

fn flying(body: &Assembly, settings: &Settings) -> Rods {
    let (mut rods, _) = Rod::FINE.made(body, settings, &World::NOMINAL).unwrap();
    rods.float();
    rods
}

/// Without weight and ground a body that is thrown keeps its momentum and its angular momentum, whatever its actuators do.
#[test]
fn a_thrown_body_keeps_its_momenta() {
    use crate::simulate::run::Stepper;
    let settings = Settings { gravity: 0.0, ..settings() };
    let mut rods = flying(&m4(), &settings);
    rods.throw(0, Vector3::new(0.3, -0.1, 0.2), Vector3::new(2.0, 5.0, -3.0));
    let before = rods.momentum();
    for step in 0..2400 {
        for servo in 0..4 {
            rods.aim(0, servo, 0.2 * libm::sin(f64::from(step) * 0.02 + servo as f64));
        }
        rods.step();
        assert_eq!(rods.failure(0), None);
    }
    let after = rods.momentum();
    assert!((after.0 - before.0).norm() < 1e-9 * before.0.norm(), "{} {}", before.0, after.0);
    assert!((after.1 - before.1).norm() < 1e-9 * before.1.norm(), "{} {}", before.1, after.1);
}

/// What falls without ground falls as a stone, and its actuators do not care.
#[test]
fn a_body_falls_as_a_stone() {
    use crate::simulate::run::Stepper;
    let settings = settings();
    let mut rods = flying(&m2(), &settings);
    let steps = 120;
    let place = |rods: &Rods| rods.pose(0, 0).translation.vector;
    let before = place(&rods);
    (0..steps).for_each(|_| rods.step());
    let time = f64::from(steps) * settings.step;
    let due = 0.5 * 9.81 * time * (time + settings.step);
    assert!((before.y - place(&rods).y - due).abs() < 1e-9);
    assert!((before - place(&rods)).xz().norm() < 1e-12);
}

/// A block that slides stops after v^2 / (2 mu g), less half of its last step.
#[test]
fn a_sliding_block_stops_by_the_law_of_coulomb() {
    use crate::simulate::run::Stepper;
    let cube = element(Shape::Box { half: Vector3::repeat(0.015) }, Isometry3::identity());
    let body = Assembly { elements: vec![cube], ..Assembly::default() };
    let settings = Settings { ground_friction: 0.8, ..during(2.0) };
    let (mut rods, _) = Rod::FINE.made(&body, &settings, &World::NOMINAL).unwrap();
    for _ in 0..10 {
        rods.step();
    }
    let before = rods.pose(0, 0).translation.vector;
    let speed = 1.0;
    rods.throw(0, Vector3::x() * speed, Vector3::zeros());
    for _ in 0..240 {
        rods.step();
    }
    let way = rods.pose(0, 0).translation.vector - before;
    let due = speed * speed / (2.0 * 0.8 * 9.81) - speed * settings.step / 2.0;
    assert!((way.x / due - 1.0).abs() < 0.01, "{} m, not {due}", way.x);
    // It does not creep: it only sinks to the depth that is left.
    let rest = rods.pose(0, 0).translation.vector;
    for _ in 0..960 {
        rods.step();
    }
    let crept = rods.pose(0, 0).translation.vector - rest;
    assert!(crept.xz().norm() < 1e-6 && crept.y.abs() < 3e-5, "{crept}");
}

/// On a slope below the angle of friction nothing creeps, above it all slides.
#[test]
fn friction_holds_up_to_its_angle() {
    let cube = element(Shape::Box { half: Vector3::repeat(0.015) }, Isometry3::identity());
    let body = Assembly { elements: vec![cube], ..Assembly::default() };
    let limit = libm::atan(0.8);
    for (slope, slides) in [(0.95 * limit, false), (1.05 * limit, true)] {
        let world = World { slope, ..World::NOMINAL };
        let mut simulation = Rod::FINE.prepare(&body, &during(2.0)).unwrap();
        let drive = idle(0);
        let case = crate::simulate::Case::new(&drive, &world);
        let motion = simulation.run_cases(crate::simulate::Stop::NEVER, &[case]).unwrap().remove(0).unwrap();
        let place = |t| motion.pose(0, t).unwrap().translation.vector;
        let way = (place(2.0) - place(0.5)).norm();
        assert!((way > 0.05) == slides && (slides || way < 1e-5), "{slope}: {way} m");
    }
}

/// Rods that do nothing but what hinges do move as a row of as many hinges does with the fast solver: an arm that swings under its weight.
#[test]
fn stiff_rods_are_rows_of_hinges() {
    let settings = Settings { step: 1.0 / 1920.0, record: 0.05, ..during(2.0) };
    let mut body = Builder(arm(4, 0.05, 0.1, Vector3::z()));
    let ball = body.add(element(Shape::Ball { radius: 0.008 }, Translation3::new(LENGTH, 0.0, 0.0).into()));
    body.join(ball - 1, ball, JointKind::Rigid);
    let body = body.0;
    let swing = |i: i32| 1.5 * libm::sin(f64::from(i) * 0.3);
    let drive = Targets { interval: 0.1, actuators: 1, angles: (0..=20).map(swing).collect() };
    let motion = |model: &dyn Model, body: &Assembly| {
        let mut simulation = model.prepare(body, &settings).unwrap();
        simulation.run(std::slice::from_ref(&drive)).remove(0).unwrap()
    };
    let own = motion(&Rod { discs: 2, stiffer: 1e3 }, &body);
    let soft = motion(&Rod { discs: 2, stiffer: 1.0 }, &body);
    // The same slices with a hinge between two of them; the ball comes before them.
    let theirs = motion(&Articulated, &super::discs::Discs::new(&body, 2).unwrap().into_hinges());
    let tip = |motion: &Motion, element: usize, t: f64| {
        let place = |element| motion.pose(element, t).unwrap().translation.vector;
        place(element) - place(0)
    };
    let (mut off, mut soft_off, mut way) = (0.0_f64, 0.0_f64, 0.0_f64);
    for moment in 0..=40 {
        let t = f64::from(moment) * 0.05;
        off = off.max((tip(&own, ball, t) - tip(&theirs, 1, t)).norm());
        soft_off = soft_off.max((tip(&soft, ball, t) - tip(&theirs, 1, t)).norm());
        way = way.max((tip(&own, ball, t) - tip(&own, ball, 0.0)).norm());
    }
    assert!(way > 0.04 && off < 3e-4, "{off} of {way} m");
    // The test can tell: what gives way in every direction is elsewhere.
    assert!(soft_off > 2.0 * off, "{soft_off} {off}");
}

/// Without actuation a body lies still.
#[test]
fn idle_bodies_stay_put() {
    for body in [m2(), m4()] {
        let motion = run(2, &body, &Settings { self_collision: true, ..during(4.0) }, &idle(body.actuators));
        for piece in 0..body.elements.len() {
            let place = |t| motion.pose(piece, t).unwrap().translation.vector;
            let way = place(4.0) - place(1.0);
            assert!(way.norm() < 2e-4, "element {piece} of {} crept {way}", body.elements.len());
        }
    }
}

/// The same motion, whatever ran before; and half the step finds nearly the same.
#[test]
fn a_run_is_the_same_every_time() {
    let body = m4();
    let settings = Settings { self_collision: true, ..during(2.0) };
    let mut simulation = Rod::FINE.prepare(&body, &settings).unwrap();
    let drives: Vec<Targets> = (1..3).map(|number| gait(4, number, true)).collect();
    let both = simulation.run(&drives);
    let alone = run(2, &body, &settings, &drives[1]);
    assert_eq!(both[1].as_ref().unwrap().poses, alone.poses);
    assert_eq!(both[1].as_ref().unwrap().work, alone.work);
    let half = run(2, &body, &settings.finer(), &drives[1]);
    let place = |motion: &Motion| motion.pose(0, 2.0).unwrap().translation.vector;
    assert!((place(&alone) - place(&half)).norm() < 0.01, "{} {}", place(&alone), place(&half));
}

/// What is reported of a body has the centre of mass that the body has: on ice this stays, whatever the actuators do.
#[test]
fn nothing_moves_a_body_on_ice() {
    let body = m4();
    let settings = Settings { ground_friction: 0.0, self_collision: true, ..during(4.0) };
    let motion = run(2, &body, &settings, &gait(4, 2, false));
    assert!(motion.drift(&body) < 1e-5, "{} m", motion.drift(&body));
    let bent = motion.bends.chunks(4).map(|bends| bends.iter().map(|bend| bend.abs()).fold(0.0, f64::max));
    assert!(bent.fold(0.0, f64::max) > 0.5);
}

/// A motor that is strong for what it turns gives it the speed that is asked for, and never more, whatever the step.
#[test]
fn a_strong_motor_does_not_overshoot() {
    use crate::simulate::run::Stepper;
    for (step, effort) in [(1.0 / 240.0, 0.05), (1.0 / 240.0, 0.001), (1.0 / 960.0, 0.05)] {
        let mut body = Builder::default();
        let mut base = element(Shape::Box { half: Vector3::repeat(0.05) }, Isometry3::identity());
        base.mass = 1.0;
        let base = body.add(base);
        body.0.actuators = 1;
        let pose = Translation3::new(0.06, 0.0, 0.0).into();
        let wheel = body.add(element(Shape::Cylinder { radius: 0.02, half_length: 0.004 }, pose));
        let dof = Dof {
            control: crate::design::assembly::Control::Speed { actuator: 0, times: 1.0 },
            share: 1.0,
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            stiffness: 0.0,
            damping: 0.005,
            effort,
            ..hinge(Vector3::new(0.055, 0.0, 0.0), Vector3::x(), 0)
        };
        body.join(base, wheel, JointKind::Dof(dof));
        let settings = Settings { step, ..during(1.0) };
        let (mut rods, _) = Rod::FINE.made(&body.0, &settings, &World::NOMINAL).unwrap();
        let asked = 3.0;
        rods.aim(0, 0, asked);
        let inertia = body.0.elements[1].shape.moments(body.0.elements[1].mass).x;
        for count in 1..=(0.5 / step) as i32 {
            rods.step();
            let speed = rods.rate(0, 0).unwrap();
            assert!(speed < asked * 1.001, "{step} {effort}: {speed} rad/s");
            // No more than the torque can do.
            let most = effort * f64::from(count) * step / inertia;
            assert!(speed < most * 1.01, "{step} {effort}: {speed} rad/s, {most}");
        }
        assert!((rods.rate(0, 0).unwrap() / asked - 1.0).abs() < 1e-3);
    }
}

/// Several strong motors in a row, which turn a load to and fro, work as a row of hinges with the fast solver does: sweeps that had not
/// converged gave them several times the work, and threw the load.
#[test]
fn strong_motors_in_a_row_work_as_hinges_do() {
    let mut body = Builder::default();
    let mut base =
        element(Shape::Box { half: Vector3::repeat(0.05) }, Translation3::new(-0.05, 0.0, 0.0).into());
    base.mass = 1e3;
    let mut last = body.add(base);
    body.0.actuators = 1;
    let (many, share) = (8, 0.01);
    for segment in 0..many {
        let begin = share * f64::from(segment);
        let shape = Shape::Cylinder { radius: RADIUS, half_length: 0.5 * share };
        let mut own = element(shape, Translation3::new(begin + 0.5 * share, 0.0, 0.0).into());
        own.mass = 0.002;
        let child = body.add(own);
        let dof = Dof {
            control: servo(0, 1e3),
            share: 1.0 / f64::from(many),
            limits: (-3.0, 3.0),
            stiffness: 0.3,
            damping: 0.01,
            effort: 0.06,
            ..hinge(Vector3::x() * begin, Vector3::x(), 0)
        };
        body.join(last, child, JointKind::Dof(dof));
        last = child;
    }
    let mut load = element(
        Shape::Box { half: Vector3::new(0.01, 0.03, 0.01) },
        Translation3::new(0.09, 0.0, 0.0).into(),
    );
    load.mass = 0.03;
    let load = body.add(load);
    body.join(last, load, JointKind::Rigid);
    let settings = Settings { gravity: 0.0, ..during(2.0) };
    let swing = |i: i32| 0.6 * libm::sin(f64::from(i) * std::f64::consts::TAU / 30.0);
    let drive = Targets { interval: 1.0 / 60.0, actuators: 1, angles: (0..=120).map(swing).collect() };
    let motion = |model: &dyn Model| {
        model.prepare(&body.0, &settings).unwrap().run(std::slice::from_ref(&drive)).remove(0).unwrap()
    };
    let (rods, hinges) = (motion(&Rod::FINE), motion(&Articulated));
    let work = |motion: &Motion| motion.work.last().copied().unwrap();
    assert!((work(&rods) / work(&hinges) - 1.0).abs() < 0.05, "{} J, not {}", work(&rods), work(&hinges));
    let far = |motion: &Motion| motion.bends.iter().fold(0.0_f64, |far, bend| far.max(bend.abs()));
    assert!((far(&rods) / far(&hinges) - 1.0).abs() < 0.02, "{} rad, not {}", far(&rods), far(&hinges));
}

/// Two parts that a joint connects do not collide, even where there is a gap between them at first: only the range of the joint stops them.
#[test]
fn what_a_joint_connects_does_not_collide() {
    let mut body = Builder::default();
    let shape = Shape::Box { half: Vector3::repeat(0.05) };
    let base = body.add(element(shape, Isometry3::identity()));
    let load = body.add(element(shape, Translation3::new(0.0, 0.105, 0.0).into()));
    let mass = body.0.elements[load].mass;
    let spring = Dof {
        travel: Travel::Slide,
        control: Control::Passive { neutral: 0.0 },
        limits: (-0.03, 0.03),
        stiffness: mass * 9.81 / 0.02,
        damping: 10.0 * mass,
        ..hinge(Vector3::y() * 0.05, Vector3::y(), 0)
    };
    body.join(base, load, JointKind::Dof(spring));
    let motion = run(2, &body.0, &Settings { self_collision: true, ..during(3.0) }, &idle(0));
    let fell = motion.pose(load, 0.0).unwrap().translation.y - motion.pose(load, 3.0).unwrap().translation.y;
    assert!((fell - 0.02).abs() < 2e-4, "{fell} m");
}

/// A stiff row with a small torque and hardly any damping gets to its limit and back within a step: it works as at shorter steps.
#[test]
fn a_stiff_row_with_a_small_torque_works_as_at_shorter_steps() {
    let mut body = arm(6, 0.02, 0.953, Vector3::z());
    for dof in body.joints.iter_mut().flat_map(|joint| joint.kind.dofs_mut()) {
        dof.damping = 0.000_546;
        dof.effort = 0.0286;
    }
    let settings = during(3.0);
    let swing = |i: i32| 5.0 * libm::sin(f64::from(i) * std::f64::consts::TAU / 120.0);
    let drive = Targets { interval: 1.0 / 60.0, actuators: 1, angles: (0..=180).map(swing).collect() };
    let work = |step: f64| -> f64 {
        run(2, &body, &Settings { step, ..settings.clone() }, &drive).work.iter().sum()
    };
    let (coarse, fine) = (work(1.0 / 240.0), work(1.0 / 960.0));
    assert!((coarse / fine - 1.0).abs() < 0.15, "{coarse} J, and {fine} J at shorter steps");
}

/// A row of slides that a load holds on its stops does no work, whatever the step: sweeps that had not converged shook it, the more the finer
/// the step was.
#[test]
fn a_row_on_its_stops_stays_there() {
    let mut body = Builder::default();
    let mut base = element(Shape::Box { half: Vector3::repeat(0.05) }, Isometry3::identity());
    base.mass = 5.0;
    let mut last = body.add(base);
    body.0.actuators = 1;
    let share = 0.01;
    for segment in 0..6 {
        let begin = 0.05 + share * f64::from(segment);
        let half = Vector3::new(0.01, 0.5 * share, 0.01);
        let mut own = element(Shape::Box { half }, Translation3::new(0.0, begin + 0.5 * share, 0.0).into());
        own.mass = 0.002;
        let child = body.add(own);
        let dof = Dof {
            travel: Travel::Slide,
            control: servo(0, 0.1),
            share: 1.0 / 6.0,
            limits: (0.0, 0.005),
            stiffness: 500.0,
            damping: 10.0,
            effort: 2.0,
            ..hinge(Vector3::y() * begin, Vector3::y(), 0)
        };
        body.join(last, child, JointKind::Dof(dof));
        last = child;
    }
    let load = Shape::Box { half: Vector3::repeat(0.01) };
    let mut load = element(load, Translation3::new(0.0, 0.05 + 6.0 * share + 0.01, 0.0).into());
    load.mass = 0.3;
    let load = body.add(load);
    body.join(last, load, JointKind::Rigid);
    let drive = Targets { interval: 1.0, actuators: 1, angles: vec![0.002; 3] };
    for step in [1.0 / 240.0, 1.0 / 960.0, 1.0 / 3840.0] {
        let motion = run(2, &body.0, &Settings { step, ..during(2.0) }, &drive);
        let work: f64 = motion.work.iter().sum();
        assert!(work < 1e-4, "{work} J at {step} s");
        let at = |time: f64| motion.pose(load, time).unwrap().translation.vector;
        let moved = at(2.0) - at(0.5);
        // Its foot sinks to the depth that is left.
        assert!(moved.xz().norm() < 1e-5 && moved.y.abs() < 3e-5, "{step}: {moved}");
    }
}

/// Refuses every motion.
struct Refuses;

impl Simulation for Refuses {
    fn lanes(&self) -> usize {
        1
    }

    fn run_watched(
        &mut self,
        _: Stop<'_>,
        cases: &[Case<'_>],
        _: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        Some(cases.iter().map(|_| Err(Invalid::EnergyFromNowhere)).collect())
    }
}

/// A motion that is refused is made again at half and at a quarter of the step, and what is refused there, too, has none.
#[test]
fn what_is_refused_is_made_again_in_finer_steps() {
    let body = arm(4, 0.02, 0.3, Vector3::z());
    let coarse = Settings { duration: 0.2, ..settings() };
    let finely = |step: f64| Articulated.prepare(&body, &Settings { step, ..coarse.clone() }).unwrap();
    let quarter = coarse.step / 4.0;
    let make = |finer: &Settings| -> Option<Box<dyn Simulation>> {
        if finer.step > 1.5 * quarter { Some(Box::new(Refuses)) } else { Some(finely(finer.step)) }
    };
    let drives = [idle(1)];
    let made = Again::new(Box::new(Refuses), &coarse, make).run(&drives).remove(0).unwrap();
    let due = finely(quarter).run(&drives).remove(0).unwrap();
    assert_eq!(format!("{made:?}"), format!("{due:?}"));
    let never = |_: &Settings| -> Option<Box<dyn Simulation>> { Some(Box::new(Refuses)) };
    let refused = Again::new(Box::new(Refuses), &coarse, never).run(&drives).remove(0);
    assert_eq!(refused.map(|_| ()), Err(Invalid::EnergyFromNowhere));
}
