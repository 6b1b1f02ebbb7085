//! Closed forms of joints that twist, slide and spin, for every solver that knows joints.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};

use super::bodies::{Builder, element, hinge, idle, servo};
use super::truth::{during, place, run};
use super::{HINGED, settings};
use crate::design::assembly::{Assembly, Control, Dof, Element, JointKind, Shape, Travel};
use crate::simulate::{Invalid, Motion, Settings, Targets, World, model};

/// A heavy block that stands, with one thing on a joint beside it, in the air.
fn stand(what: Element, dof: Dof) -> Assembly {
    let mut body = Builder::default();
    let block = Shape::Box { half: Vector3::repeat(0.05) };
    let mut base = element(block, Translation3::new(-0.06, 0.05, 0.0).into());
    base.mass = 50.0;
    let base = body.add(base);
    let what = body.add(what);
    body.0.actuators = usize::from(dof.actuator().is_some());
    body.join(base, what, JointKind::Dof(dof));
    body.0
}

/// A disc whose axis is x, and its moment of inertia.
fn disc() -> (Element, f64) {
    let (radius, mass) = (0.03, 0.05);
    let shape = Shape::Cylinder { radius, half_length: 0.004 };
    let mut disc = element(shape, Translation3::new(0.0, 0.05, 0.0).into());
    disc.mass = mass;
    (disc, 0.5 * mass * radius * radius)
}

/// A joint along x in the middle of what stands beside the block.
fn along_x(travel: Travel, control: Control) -> Dof {
    Dof {
        travel,
        control,
        share: 1.0,
        damping: 0.0,
        limits: (f64::NEG_INFINITY, f64::INFINITY),
        effort: f64::INFINITY,
        ..hinge(Vector3::new(0.0, 0.05, 0.0), Vector3::x(), 0)
    }
}

fn turn_about(motion: &Motion, element: usize, axis: UnitVector3<f64>, t: f64) -> f64 {
    let q = motion.pose(element, t).unwrap().rotation;
    2.0 * libm::atan2(q.imag().dot(&axis), q.w)
}

fn finely(duration: f64) -> Settings {
    Settings { record: 1.0 / 240.0, ..during(duration) }
}

/// Released at rest, a disc on a torsion spring swings about where the spring is slack: `1 - cos(t sqrt(k / I))`.
#[test]
fn a_torsion_pendulum_keeps_time() {
    let (disc, inertia) = disc();
    let (neutral, period) = (0.3, 0.8);
    let rate = 2.0 * std::f64::consts::PI / period;
    let spring =
        Dof { stiffness: inertia * rate * rate, ..along_x(Travel::Turn, Control::Passive { neutral }) };
    let body = stand(disc, spring);
    for (name, off) in [("articulated", 0.01), ("rapier", 0.05)] {
        let motion = run(name, &body, &finely(1.0), &idle(0));
        for t in [0.2, 0.4, 0.6, 0.8] {
            let due = neutral * (1.0 - libm::cos(rate * t));
            let angle = turn_about(&motion, 1, Vector3::x_axis(), t);
            assert!((angle - due).abs() < off * 2.0 * neutral, "{name}, {t} s: {angle} rad for {due}");
        }
    }
}

/// The same of a block that slides on a spring, and with a damper it dies away as it should.
#[test]
fn a_slider_on_a_spring_keeps_time() {
    let (mut block, _) = disc();
    block.mass = 0.04;
    let (neutral, period) = (0.01, 0.5);
    let rate = 2.0 * std::f64::consts::PI / period;
    for damped in [0.0, 0.2] {
        let spring = Dof {
            stiffness: block.mass * rate * rate,
            damping: 2.0 * damped * block.mass * rate,
            ..along_x(Travel::Slide, Control::Passive { neutral })
        };
        let body = stand(block.clone(), spring);
        for (name, off) in [("articulated", 0.01), ("rapier", 0.05)] {
            let motion = run(name, &body, &finely(1.0), &idle(0));
            for t in [0.125, 0.25, 0.5, 1.0] {
                let own = rate * libm::sqrt(1.0 - damped * damped);
                let lag = damped / libm::sqrt(1.0 - damped * damped);
                let fade = libm::exp(-damped * rate * t);
                let due = neutral * (1.0 - fade * (libm::cos(own * t) + lag * libm::sin(own * t)));
                let way = place(&motion, 1, t).x - place(&motion, 1, 0.0).x;
                assert!((way - due).abs() < off * 2.0 * neutral, "{name}, {t} s: {way} m for {due}");
            }
        }
    }
}

/// A lift gives way by weight over stiffness, follows its drive at its speed, and stops at its end.
#[test]
fn a_slide_that_is_driven_goes_where_it_is_asked() {
    let (mut block, _) = disc();
    block.mass = 0.1;
    let stiffness = 400.0;
    let lift = Dof {
        axis: Vector3::y_axis(),
        stiffness,
        damping: 10.0,
        limits: (-0.005, 0.02),
        effort: 5.0,
        ..along_x(Travel::Slide, servo(0, 0.01))
    };
    let body = stand(block, lift);
    let sag = 0.1 * settings().gravity / stiffness;
    for name in HINGED {
        let ask = |way: f64| Targets { interval: 10.0, actuators: 1, angles: vec![way] };
        let still = run(name, &body, &during(2.0), &idle(1));
        // The block that it stands on sinks a little, too.
        let up_by = |motion: &Motion, t: f64| place(motion, 1, t).y - place(motion, 0, t).y;
        let sunk = up_by(&still, 2.0) - up_by(&still, 0.0);
        assert!((sunk + sag).abs() < 0.03 * sag, "{name}: {sunk} m, not {sag}");
        assert!(
            (still.bends.last().unwrap() - sunk).abs() < 1e-6,
            "{name}: {sunk} m, recorded as {:?}",
            still.bends.last()
        );
        let up = run(name, &body, &during(2.0), &ask(0.015));
        let way = place(&up, 1, 1.0).y - place(&up, 1, 0.5).y;
        assert!((way - 0.005).abs() < 2e-4, "{name}: {way} m in half a second");
        // Weight times way, and what the damper takes: at least the first.
        let lifted = 0.1 * settings().gravity * 0.015;
        assert!(up.work[0] > 0.95 * lifted && up.work[0] < 1.3 * lifted, "{name}: {} J", up.work[0]);
        let far = run(name, &body, &during(4.0), &ask(0.1));
        let end = place(&far, 1, 4.0).y - place(&far, 1, 0.0).y;
        assert!((end - 0.02).abs() < 3e-4, "{name}: it ends at {end} m");
    }
}

/// A flywheel gains speed by its motor's torque over its inertia, and then keeps what it is asked for.
#[test]
fn a_motor_turns_as_fast_as_it_is_asked() {
    let (disc, inertia) = disc();
    let (asked, torque) = (30.0, 1e-3);
    let motor = Dof {
        damping: 2e-3,
        effort: torque,
        ..along_x(Travel::Turn, Control::Speed { actuator: 0, times: 1.0 })
    };
    let body = stand(disc, motor);
    let drive = Targets { interval: 10.0, actuators: 1, angles: vec![asked] };
    for name in HINGED {
        let motion = run(name, &body, &finely(2.0), &drive);
        let speed = |t: f64| motion.bends[(t * 240.0).round() as usize];
        let due = torque / inertia * 0.4;
        assert!((speed(0.4) - due).abs() < 0.02 * due, "{name}: {} rad/s after 0.4 s for {due}", speed(0.4));
        assert!((speed(2.0) - asked).abs() < 0.01 * asked, "{name}: {} rad/s", speed(2.0));
        let energy = 0.5 * inertia * asked * asked;
        assert!((motion.work[0] - energy).abs() < 0.03 * energy, "{name}: {} J for {energy}", motion.work[0]);
    }
    // A motor that is slower in another world.
    let slow = || World { speed: 0.8, ..World::NOMINAL };
    for name in HINGED {
        let motion = super::worlds::in_worlds(name, &body, &finely(2.0), &drive, &[slow()]).remove(0);
        let end = *motion.bends.last().unwrap();
        assert!((end - 0.8 * asked).abs() < 0.01 * asked, "{name}: {end} rad/s");
    }
}

/// A flywheel that is turned round again and again within five steps: braking it costs nothing, and each turn
/// the energy of its speed, also where the turn falls between two steps.
#[test]
fn turning_round_costs_the_energy_of_the_speed() {
    let (disc, inertia) = disc();
    let asked = 50.0;
    for steps in [2.5, 5.0, 40.0] {
        let torque = 2.0 * asked * inertia * 240.0 / steps;
        let motor = Dof {
            damping: 2e-3,
            effort: torque,
            ..along_x(Travel::Turn, Control::Speed { actuator: 0, times: 1.0 })
        };
        // From step to step, or the speed that is asked for would change slowly.
        let angles = (0..600).map(|step| if step / 60 % 2 == 0 { asked } else { -asked }).collect();
        let drive = Targets { interval: 1.0 / 240.0, actuators: 1, angles };
        let body = stand(disc.clone(), motor);
        let energy = 10.0 * 0.5 * inertia * asked * asked;
        for name in ["articulated", "rod"] {
            let work = run(name, &body, &finely(2.5), &drive).work[0];
            assert!((work / energy - 1.0).abs() < 0.03, "{name}, {steps} steps: {work} J for {energy}");
        }
    }
}

/// A motor much stronger than what it turns is switched on and off: no step overshoots, and it works for the energy of each start.
#[test]
fn a_strong_motor_does_not_overshoot() {
    let (disc, inertia) = disc();
    let asked = 30.0;
    for damping in [2e-2, 1.0, 100.0] {
        let motor = Dof { damping, ..along_x(Travel::Turn, Control::Speed { actuator: 0, times: 1.0 }) };
        let angles = (0..600).map(|step| if step / 60 % 2 == 0 { asked } else { 0.0 }).collect();
        let drive = Targets { interval: 1.0 / 240.0, actuators: 1, angles };
        let body = stand(disc.clone(), motor);
        let energy = 5.0 * 0.5 * inertia * asked * asked;
        for name in ["articulated", "rod"] {
            let motion = run(name, &body, &finely(2.5), &drive);
            let most = motion.bends.iter().fold(0.0_f64, |most, speed| most.max(*speed));
            assert!(most < 1.05 * asked, "{name}, {damping}: {most} rad/s");
            let work = motion.work[0];
            // The rods' motors tremble where they are much too strong.
            let most = if name == "rod" { 0.25 } else { 0.1 };
            assert!((work / energy - 1.0).abs() < most, "{name}, {damping}: {work} J for {energy}");
        }
    }
}

/// What turns by more than a quarter of a radian in its steps has a wrong way and a wrong momentum: that is refused, with a step
/// short enough not.
#[test]
fn what_turns_too_far_in_its_steps_is_refused() {
    let (disc, inertia) = disc();
    let asked = 80.0;
    let motor = Dof { damping: 1e-3, ..along_x(Travel::Turn, Control::Speed { actuator: 0, times: 1.0 }) };
    let body = stand(disc, motor);
    let drive = Targets { interval: 10.0, actuators: 1, angles: vec![asked] };
    let mut coarse = model("articulated").unwrap().prepare(&body, &finely(1.0)).unwrap();
    assert_eq!(coarse.run(std::slice::from_ref(&drive)).remove(0).unwrap_err(), Invalid::TurnsTooFast);
    let motion = run("articulated", &body, &Settings { step: 1.0 / 480.0, ..finely(1.0) }, &drive);
    let energy = 0.5 * inertia * asked * asked;
    assert!((motion.work[0] / energy - 1.0).abs() < 0.02, "{} J for {energy}", motion.work[0]);
}

/// A light slide with a stiff motor is moved three times: that costs the energy of its speed, and no trembling counts.
#[test]
fn a_stiff_motor_that_trembles_does_no_work() {
    let (disc, _) = disc();
    let mass = 1.5e-3;
    let disc = Element { mass, ..disc };
    let speed = 0.03;
    let control = Control::Position { actuator: 0, rate: speed, relaxing_rate: speed, rest: 0.0 };
    let dof = Dof {
        stiffness: 500.0,
        damping: 10.0,
        effort: 5.0,
        limits: (-0.02, 0.02),
        ..along_x(Travel::Slide, control)
    };
    let body = stand(disc.clone(), dof);
    let drive = Targets { interval: 2.0, actuators: 1, angles: vec![0.02, -0.02, 0.005] };
    let due = 3.0 * 0.5 * mass * speed * speed;
    // It stands still or moves steadily for nearly all of the time. rapier does a tenth of what it takes to lift it as far.
    let lifted = mass * settings().gravity * 0.085;
    for (name, most) in [("articulated", 1.5 * due), ("rapier", 0.1 * lifted)] {
        let work = run(name, &body, &during(6.0), &drive).work[0];
        assert!(work > 0.3 * due && work < most, "{name}: {work} J for {due}");
    }
}

const RADIUS: f64 = 0.03;

/// A block on four wheels, on axles across it.
fn cart(control: Control) -> Assembly {
    let mut body = Builder::default();
    let block = Shape::Box { half: Vector3::new(0.06, 0.01, 0.02) };
    let core = body.add(element(block, Translation3::new(0.0, RADIUS, 0.0).into()));
    body.0.actuators = usize::from(!matches!(control, Control::Passive { .. }));
    for (x, z) in [(-0.05, -0.04), (-0.05, 0.04), (0.05, -0.04), (0.05, 0.04)] {
        let centre = Vector3::new(x, RADIUS, z);
        let lies = UnitQuaternion::rotation_between(&Vector3::x(), &Vector3::z()).unwrap();
        let shape = Shape::Cylinder { radius: RADIUS, half_length: 0.005 };
        let wheel = body.add(element(shape, Isometry3::from_parts(Translation3::from(centre), lies)));
        let axle = Dof { anchor: centre.into(), axis: Vector3::z_axis(), ..along_x(Travel::Turn, control) };
        let driven = matches!(control, Control::Speed { .. });
        let axle = Dof { stiffness: 0.0, damping: if driven { 0.01 } else { 0.0 }, effort: 0.1, ..axle };
        body.join(core, wheel, JointKind::Dof(axle));
    }
    body.0
}

/// Free wheels roll down a slope with the inertia of the cart and of what turns.
#[test]
fn a_cart_rolls_down_a_slope() {
    let body = cart(Control::Passive { neutral: 0.0 });
    let mass: f64 = body.elements.iter().map(|element| element.mass).sum();
    let wheels: f64 = body.elements[1..].iter().map(|element| element.mass).sum();
    let slope = libm::atan(0.1);
    for (name, off) in [("articulated", 0.01), ("rapier", 0.05)] {
        let world = World { slope, ..World::NOMINAL };
        let motion = super::worlds::in_worlds(name, &body, &during(1.0), &idle(0), &[world]).remove(0);
        let way = place(&motion, 0, 1.0) - place(&motion, 0, 0.0);
        let due = -0.5 * settings().gravity * libm::sin(slope) * mass / (mass + 0.5 * wheels);
        assert!((way.x / due - 1.0).abs() < off && way.z.abs() < 1e-3, "{name}: {way} m, not {due}");
    }
}

/// Motors of wheels on the ground work for what they speed up, also stiff ones, whose torque follows the least error of their speed.
#[test]
fn motors_of_wheels_work_for_what_they_speed_up() {
    let drive = Targets { interval: 10.0, actuators: 1, angles: vec![-8.0] };
    for damping in [0.01, 0.1] {
        let mut body = cart(Control::Speed { actuator: 0, times: 1.0 });
        for joint in &mut body.joints {
            if let JointKind::Dof(dof) = &mut joint.kind {
                dof.damping = damping;
            }
        }
        let [hinges, rods] = ["articulated", "rod"]
            .map(|name| run(name, &body, &during(4.0), &drive).work.iter().sum::<f64>());
        assert!((rods / hinges - 1.0).abs() < 0.2, "{damping}: {rods} J with rods, {hinges} J with hinges");
    }
}

/// Driven wheels carry the cart by their speed times their radius, and turn forwards about -z.
#[test]
fn a_cart_drives_as_fast_as_its_wheels_turn() {
    let asked = -8.0;
    let body = cart(Control::Speed { actuator: 0, times: 1.0 });
    let drive = Targets { interval: 10.0, actuators: 1, angles: vec![asked] };
    for name in HINGED {
        let motion = run(name, &body, &during(2.0), &drive);
        let way = place(&motion, 0, 2.0) - place(&motion, 0, 1.0);
        assert!((way.x / (-asked * RADIUS) - 1.0).abs() < 0.02, "{name}: {way} m in a second");
        assert!(way.z.abs() < 1e-3 && place(&motion, 0, 2.0).y < RADIUS + 1e-3, "{name}: {way}");
    }
}

/// A motor turns an arm about the vertical until the arm meets a tower that stands on what carries the motor. The wheel of the
/// motor is drawn over a hub and never touches it.
#[test]
fn an_arm_stops_at_a_tower_across_its_joint() {
    let at = |x: f64, y: f64, z: f64| -> Isometry3<f64> { Translation3::new(x, y, z).into() };
    let block = |x: f64, y: f64, z: f64| Shape::Box { half: Vector3::new(x, y, z) };
    let mut body = Builder::default();
    let base = body.add(Element { mass: 20.0, ..element(block(0.1, 0.01, 0.1), at(0.0, 0.01, 0.0)) });
    let hub = body.add(element(block(0.005, 0.01, 0.005), at(0.0, 0.03, 0.0)));
    body.join(base, hub, JointKind::Rigid);
    let tower = body.add(element(block(0.01, 0.03, 0.01), at(0.0, 0.05, 0.06)));
    body.join(base, tower, JointKind::Rigid);
    let arm = body.add(element(block(0.04, 0.005, 0.005), at(0.05, 0.03, 0.0)));
    let wheel = body.add(element(block(0.02, 0.005, 0.02), at(0.0, 0.03, 0.0)));
    body.0.actuators = 1;
    let control = Control::Speed { actuator: 0, times: 1.0 };
    let motor = Dof { axis: Vector3::y_axis(), ..along_x(Travel::Turn, control) };
    let motor = Dof { anchor: [0.0, 0.03, 0.0].into(), damping: 0.01, effort: 0.02, ..motor };
    body.join(base, wheel, JointKind::Dof(motor));
    body.join(wheel, arm, JointKind::Rigid);
    let drive = Targets { interval: 10.0, actuators: 1, angles: vec![-3.0] };
    let settings = finely(1.0);
    for name in HINGED {
        let motion = run(name, &body.0, &settings, &drive);
        let turned = |t| -turn_about(&motion, 3, Vector3::y_axis(), t);
        // Freely, it would turn by 3 rad. The edge of the arm meets the tower 5 mm before its middle would meet it
        // 10 mm beside the line from the motor.
        let end = turned(1.0);
        assert!((1.1..1.5).contains(&end), "{name}: it stops at {end} rad");
        assert!((end - turned(0.8)).abs() < 0.01, "{name}: it rests at {end} rad");
    }
    let ghost = Settings { self_collision: false, ..settings };
    let motion = run("articulated", &body.0, &ghost, &drive);
    let end = (-turn_about(&motion, 3, Vector3::y_axis(), 1.0)).rem_euclid(std::f64::consts::TAU);
    assert!(end > 2.5, "nothing else stops it, at {end} rad");
}
