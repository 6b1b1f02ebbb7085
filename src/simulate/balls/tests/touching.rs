//! Balls that no spring joins.

use nalgebra::Vector3;

use super::{gained, idle, lifted, place, row, run};
use crate::simulate::lattice::Lattice;
use crate::simulate::tests::lattices::{PITCH, cells, lattice, lattice_settings};
use crate::simulate::{Motion, Settings};

/// The least distance of balls that no spring joins, as a share of the sum of their radii.
fn closest(lattice: &Lattice, motion: &Motion, t: f64) -> f64 {
    let joined = |a: usize, b: usize| lattice.links.iter().any(|l| l.ends == [a, b] || l.ends == [b, a]);
    let pairs = (0..motion.bodies).flat_map(|b| (0..b).map(move |a| (a, b)));
    let apart = pairs.filter(|&(a, b)| !joined(a, b)).map(|(a, b)| {
        (place(motion, a, t) - place(motion, b, t)).norm()
            / (lattice.balls[a].radius + lattice.balls[b].radius)
    });
    apart.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_ball_comes_to_rest_on_another() {
    let settings = lattice_settings(1.0);
    let mut pair = lifted(&row(2, PITCH), &settings, 0.1);
    pair.balls[0].mass = f64::INFINITY;
    pair.balls[1].centre = pair.balls[0].centre + Vector3::y() * 0.05;
    let motion = run(&pair, &settings, &idle());
    let way = place(&motion, 1, 1.0) - place(&motion, 0, 1.0);
    assert!((way - Vector3::y() * PITCH).norm() < 1e-6, "{way}");
}

/// Without friction momentum goes on; what meets in the middle stays there together.
#[test]
fn two_balls_share_their_momentum() {
    let settings = Settings { gravity: 0.0, ..lattice_settings(1.0) };
    let mut pair = lifted(&row(2, 5.0 * PITCH), &settings, 0.1);
    pair.balls[0].velocity.x = 0.2;
    pair.balls[1].mass *= 3.0;
    let motion = run(&pair, &settings, &idle());
    let speed = |ball: usize| (place(&motion, ball, 1.0).x - place(&motion, ball, 0.5).x) / 0.5;
    assert!((speed(0) - 0.05).abs() < 1e-5 && (speed(1) - 0.05).abs() < 1e-5);
    assert!((closest(&pair, &motion, 1.0) - 1.0).abs() < 1e-4);
}

/// Balls that graze each other keep their angular momentum: friction between balls that do not rotate would be a couple.
#[test]
fn grazing_balls_keep_their_angular_momentum() {
    let settings = Settings { gravity: 0.0, ..lattice_settings(1.0) };
    let mut pair = lifted(&row(2, 5.0 * PITCH), &settings, 0.1);
    pair.balls[0].velocity.x = 0.2;
    pair.balls[1].centre.y += 0.7 * PITCH;
    pair.balls[1].mass *= 3.0;
    let motion = run(&pair, &settings, &idle());
    let momentum = |t: f64| {
        let of = |ball: usize| {
            let (now, later) = (place(&motion, ball, t), place(&motion, ball, t + 0.1));
            now.cross(&(later - now)) * (pair.balls[ball].mass / 0.1)
        };
        of(0) + of(1)
    };
    let (before, after) = (momentum(0.0), momentum(0.85));
    let speed = (place(&motion, 1, 0.95) - place(&motion, 1, 0.85)).norm() / 0.1;
    assert!(speed > 0.01, "they do not meet: {speed} m/s");
    assert!((after - before).norm() < 1e-4 * before.norm(), "{before} {after}");
}

/// A block of balls falls on another: nothing goes through, and they come to rest.
#[test]
fn a_block_lies_on_a_block() {
    let settings = lattice_settings(3.0);
    let mut all = cells([0, 0, 0], [6, 2, 6]);
    all.extend(cells([1, 4, 1], [4, 2, 4]));
    let blocks = lifted(&lattice(&all), &settings, 0.0);
    let motion = run(&blocks, &settings, &idle());
    for frame in 0..motion.frames() {
        let near = closest(&blocks, &motion, motion.time(frame));
        assert!(near > 0.97, "{near} of a diameter apart after {} s", motion.time(frame));
    }
    let way = place(&motion, 72, 3.0) - place(&motion, 72, 2.0);
    assert!(way.norm() < 1e-4, "it still moves by {way}");
    assert!(place(&motion, 72, 3.0).y > 2.0 * PITCH, "it fell through");
    assert!(gained(&blocks, &settings) < 1e-4);
}

/// They may be told not to touch.
#[test]
fn without_self_collision_they_pass() {
    let settings = Settings { self_collision: false, gravity: 0.0, ..lattice_settings(1.0) };
    let mut pair = lifted(&row(2, 5.0 * PITCH), &settings, 0.1);
    pair.balls[0].velocity.x = 0.2;
    let motion = run(&pair, &settings, &idle());
    assert!((place(&motion, 0, 1.0).x - 0.2).abs() < 1e-5);
}
