//! Single balls and springs, against closed forms.

use nalgebra::Vector3;

use super::{idle, lifted, place, ramp, row, run};
use crate::design::assembly::{Spring, Swelling};
use crate::simulate::Settings;
use crate::simulate::tests::lattices::{DAMPING, MASS, PITCH, STIFFNESS, lattice_settings};

#[test]
fn what_is_let_go_falls() {
    let settings = lattice_settings(0.4);
    let motion = run(&lifted(&row(1, PITCH), &settings, 1.0), &settings, &idle());
    for t in [0.1, 0.2, 0.3, 0.4] {
        let fallen = place(&motion, 0, 0.0).y - place(&motion, 0, t).y;
        assert!((fallen - 0.5 * 9.81 * t * t).abs() < 5e-6, "{fallen} m after {t} s");
    }
}

/// Ten balls below one that is held: each spring carries what hangs from it.
#[test]
fn a_chain_hangs_by_its_weight() {
    let settings = lattice_settings(15.0);
    let mut body = row(11, PITCH);
    for (from, element) in body.elements.iter_mut().enumerate() {
        element.pose.translation.vector = Vector3::y() * -PITCH * from as f64;
        if from > 0 {
            let damping = 20.0 * DAMPING;
            body.springs.push(Spring { from: from - 1, to: from, stiffness: 20.0, damping });
        }
    }
    let settings = Settings { step: 1.0 / 19200.0, ..settings };
    let mut chain = lifted(&body, &settings, 1.0);
    chain.balls[0].mass = f64::INFINITY;
    let motion = run(&chain, &settings, &idle());
    for ball in 0..11 {
        let below: f64 = (1..=ball).map(|n| f64::from(11 - n as u8) * MASS * 9.81 / 20.0).sum();
        let sag = place(&motion, ball, 0.0).y - place(&motion, ball, 15.0).y;
        assert!((sag - below).abs() < 1e-3 * below + 1e-6, "ball {ball} sags {sag} m, not {below}");
    }
}

/// A ball on a spring, pulled a little: its period, and how fast its swings die down.
#[test]
fn a_ball_on_a_spring_swings() {
    let (length, pulled) = (PITCH, 1e-3);
    for (damping, rate) in [(0.0, 2400.0), (0.02, 2400.0), (0.02, 9600.0), (0.0, 1200.0)] {
        let settings =
            Settings { step: 1.0 / rate, record: 1.0 / rate, gravity: 0.0, ..lattice_settings(0.2) };
        let mut body = row(2, length);
        body.springs.push(Spring { from: 0, to: 1, stiffness: STIFFNESS, damping });
        let mut lattice = lifted(&body, &settings, 1.0);
        lattice.balls[0].mass = f64::INFINITY;
        lattice.balls[1].centre.x += pulled;
        let motion = run(&lattice, &settings, &idle());
        let at = |frame: usize| place(&motion, 1, motion.time(frame)).x - length;
        let falls = |f: &usize| at(*f - 1) > 0.0 && at(*f) <= 0.0;
        let cross = |f: usize| motion.time(f) - at(f) / (at(f) - at(f - 1)) / rate;
        let crossings: Vec<f64> = (1..motion.frames()).filter(falls).map(cross).collect();
        let (first, last) = (crossings[0], crossings[crossings.len() - 1]);
        let own = (STIFFNESS / MASS - (damping / MASS / 2.0).powi(2)).sqrt();
        let found = std::f64::consts::TAU * (crossings.len() - 1) as f64 / (last - first);
        // Explicit steps are too fast by (omega h)^2 / 24, and dampers that lag by half a step take mass away.
        let faster = 1.0 + (own / rate).powi(2) / 24.0 + damping / MASS / rate / 4.0;
        assert!((found / own / faster - 1.0).abs() < 1e-3, "1/{rate} s, {damping}: {found}, not {own} rad/s");
        // The last peak is a quarter of a turn before the last crossing.
        let turn = std::f64::consts::TAU / own;
        let later = (0..motion.frames()).filter(|f| motion.time(*f) >= last - 0.75 * turn).map(at);
        let left = later.fold(0.0, f64::max) / pulled;
        let expected = libm::exp(-damping / MASS / 2.0 * (last - 0.25 * turn));
        assert!((left / expected - 1.0).abs() < 0.1, "{damping}: {left} are left, not {expected}");
    }
}

/// A load on a spring that shortens: mass times gravity times height, and nothing for letting it down.
#[test]
fn lifting_a_ball_is_work() {
    let settings = lattice_settings(6.0);
    let mut body = row(2, 10.0 * PITCH);
    body.elements[1].pose.translation.vector = Vector3::y() * -10.0 * PITCH;
    body.springs.push(Spring { from: 0, to: 1, stiffness: 20.0, damping: DAMPING });
    body.swellings.push(Swelling { element: 1, actuator: 0, gain: -2.0 });
    body.actuators = 1;
    let mut crane = lifted(&body, &settings, 1.0);
    crane.balls[0].mass = f64::INFINITY;
    crane.balls[1].centre.y -= MASS * 9.81 / 20.0;
    // The damper is beside the spring, so that it must be shortened, too.
    let expected = (MASS * 9.81 + DAMPING * 2.5 * PITCH) * 5.0 * PITCH;
    for angles in [vec![0.0, 0.5], vec![0.0, 0.5, 0.0]] {
        let drive = crate::simulate::Targets { interval: 2.0, actuators: 1, angles };
        let motion = run(&crane, &settings, &drive);
        let work = motion.work[0];
        assert!((work / expected - 1.0).abs() < 0.01, "{work} J, not {expected}");
        let asked = if drive.angles.len() == 2 { 0.5 } else { 0.0 };
        assert_eq!(*motion.bends.last().unwrap(), asked);
    }
}

/// A spring whose length at rest jumps holds what the jump has put in, no more and no less.
#[test]
fn a_strain_that_jumps_is_work() {
    let settings = Settings { gravity: 0.0, ..lattice_settings(0.2) };
    let mut body = row(2, PITCH);
    body.springs.push(Spring { from: 0, to: 1, stiffness: STIFFNESS, damping: 0.0 });
    body.swellings.push(Swelling { element: 1, actuator: 0, gain: 1.0 });
    body.actuators = 1;
    let body = lifted(&body, &settings, 1.0);
    let drive = crate::simulate::Targets { interval: 1.0, actuators: 1, angles: vec![0.3, 0.3] };
    let work = run(&body, &settings, &drive).work[0];
    let expected = 0.5 * STIFFNESS * (0.5 * 0.3 * PITCH).powi(2);
    assert!((work / expected - 1.0).abs() < 1e-4, "{work} J, not {expected}");
}

/// What stands on the ground rises as it swells, and no energy is missed.
#[test]
fn a_ball_swells_upwards() {
    let settings = lattice_settings(1.0);
    let mut body = row(1, PITCH);
    body.swellings.push(Swelling { element: 0, actuator: 0, gain: 0.5 });
    body.actuators = 1;
    let motion = run(&lifted(&body, &settings, 0.0), &settings, &ramp(1.0, 0.5));
    let end = place(&motion, 0, 1.0);
    assert!((end - Vector3::y() * 0.75 * PITCH).norm() < 1e-6, "{end}");
}
