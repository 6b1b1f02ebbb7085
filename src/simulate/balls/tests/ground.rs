//! Bodies on the ground: Coulomb's law.

use nalgebra::Vector3;

use super::{idle, lifted, middle, place, run};
use crate::simulate::lattice::Lattice;
use crate::simulate::tests::bodies;
use crate::simulate::tests::lattices::{FRICTION, PITCH, cells, lattice, lattice_settings, quadruped};

fn block(duration: f64) -> Lattice {
    lifted(&lattice(&cells([0, 0, 0], [4, 3, 4])), &lattice_settings(duration), 0.0)
}

/// Gravity as on a slope of so many rad.
fn slope(angle: f64) -> Vector3<f64> {
    9.81 * Vector3::new(libm::sin(angle), -libm::cos(angle), 0.0)
}

#[test]
fn a_sliding_block_stops_after_its_distance() {
    for speed in [0.3, 0.6] {
        let mut block = block(2.0);
        block.balls.iter_mut().for_each(|ball| ball.velocity.x = speed);
        let motion = run(&block, &lattice_settings(2.0), &idle());
        let way = middle(&motion, 2.0) - middle(&motion, 0.0);
        let expected = speed * speed / (2.0 * FRICTION * 9.81);
        assert!((way.x / expected - 1.0).abs() < 0.01, "{way}, not {expected} m");
        let rest = middle(&motion, 2.0) - middle(&motion, 1.0);
        assert!(rest.norm() < 1e-6 && way.z.abs() < 1e-6, "it moves on by {rest}");
    }
}

#[test]
fn friction_holds_up_to_its_angle() {
    let hold = libm::atan(FRICTION);
    for (angle, slides) in [(hold - 0.03, false), (hold + 0.03, true)] {
        let mut block = block(4.0);
        block.gravity = slope(angle);
        let motion = run(&block, &lattice_settings(4.0), &idle());
        let way = middle(&motion, 4.0).x - middle(&motion, 2.0).x;
        if slides {
            let pull = 9.81 * (libm::sin(angle) - FRICTION * libm::cos(angle));
            let expected = 0.5 * pull * (16.0 - 4.0);
            assert!((way / expected - 1.0).abs() < 0.02, "slides {way} m, not {expected}");
        } else {
            assert!(way.abs() < 1e-6, "creeps {way} m");
        }
    }
}

#[test]
fn nothing_sinks_whatever_it_weighs() {
    let mut block = block(2.0);
    block.balls.iter_mut().for_each(|ball| ball.mass *= 3.0);
    block.links.iter_mut().for_each(|link| link.stiffness *= 10.0);
    let motion = run(&block, &lattice_settings(2.0), &idle());
    let lowest = (0..motion.bodies).map(|ball| place(&motion, ball, 2.0).y).fold(f64::INFINITY, f64::min);
    assert!((lowest - PITCH / 2.0).abs() < 1e-7, "the lowest ball is at {lowest} m");
}

#[test]
fn who_is_not_moved_stays() {
    let settings = lattice_settings(15.0);
    let body = quadruped();
    let motion = run(&lifted(&body, &settings, 0.0), &settings, &bodies::idle(body.actuators));
    for ball in 0..motion.bodies {
        // The first seconds are for the legs to give way.
        let way = place(&motion, ball, 15.0) - place(&motion, ball, 6.0);
        assert!(way.norm() < 1e-5, "ball {ball} crept {way}");
    }
    assert!(motion.work.iter().all(|work| *work == 0.0));
}
