//! Lattices: stiffness, convergence, bending, energy, momenta.

use nalgebra::Vector3;

use super::{gained, idle, lifted, middle, place, ramp, run};
use crate::simulate::balls::Balls;
use crate::simulate::lattice::{Ball, Lattice};
use crate::simulate::rapier::Rapier;
use crate::simulate::tests::lattices::{
    PITCH, STIFFNESS, bend, cells, lattice, lattice_settings, quadruped, trot,
};
use crate::simulate::{Model, Settings};

/// A beam of 7 x 2 x 2 balls in the air, its first four held. Damping in N s/m.
fn beam(settings: &Settings, damping: f64) -> Lattice {
    let mut beam = lifted(&lattice(&cells([0, 0, 0], [7, 2, 2])), settings, 0.2);
    for ball in &mut beam.balls {
        ball.mass = if ball.centre.x < 0.5 * PITCH { f64::INFINITY } else { ball.mass };
    }
    beam.links.iter_mut().for_each(|link| link.damping = damping);
    beam
}

fn sag(rate: f64, duration: f64, damping: f64) -> f64 {
    let settings = Settings { step: 1.0 / rate, ..lattice_settings(duration) };
    let motion = run(&beam(&settings, damping), &settings, &idle());
    place(&motion, 6, 0.0).y - place(&motion, 6, duration).y
}

#[test]
fn stiffness_is_independent_of_the_step() {
    let [coarse, fine] = [4800.0, 19200.0].map(|rate| sag(rate, 12.0, 0.4));
    assert!(coarse > 0.003, "{coarse} m");
    assert!((coarse / fine - 1.0).abs() < 1e-4, "{coarse} and {fine} m");
}

/// In mid-swing, where errors are largest.
#[test]
fn halving_the_step_converges() {
    let truth = sag(38400.0, 0.15, 0.02);
    let errors = [1200.0, 2400.0, 4800.0].map(|rate| (sag(rate, 0.15, 0.02) - truth).abs());
    assert!(errors[0] < 0.02 * truth && truth > 0.003, "{errors:?} of {truth} m");
    assert!(errors[1] < 0.65 * errors[0] && errors[2] < 0.65 * errors[1], "{errors:?} m");
}

/// Two rows of balls without weight, one stretched and one shrunk: the angle between the rods that join the rows.
#[test]
fn a_bimorph_bends_as_geometry_says() {
    let all = cells([0, 0, 0], [12, 2, 1]);
    for strain in [0.05, 0.2, -0.2] {
        let settings = Settings { gravity: 0.0, ..lattice_settings(6.0) };
        let mut body = lattice(&all);
        bend(&mut body, &all, |cell| if cell[1] == 1 { 1.0 } else { -1.0 });
        let motion = run(&lifted(&body, &settings, 0.5), &settings, &ramp(strain, 1.0));
        let rod = |cell: usize| place(&motion, cell + 12, 6.0) - place(&motion, cell, 6.0);
        let turn = |cell: usize| {
            let (here, there) = (rod(cell), rod(cell + 1));
            libm::atan2(here.cross(&there).z, here.dot(&there))
        };
        let bent = (1..10).map(turn).sum::<f64>() / 9.0;
        // Above the rods are 1 + strain apart, below 1 - strain, in lengths of a rod.
        let expected = -2.0 * libm::asin(strain);
        let off = (bent / expected - 1.0).abs();
        assert!(off < 0.01 + strain * strain, "{bent} rad a cell, not {expected}");
    }
}

/// Mirrored legs, moved alike: what is left is rounding, as springs are added up in one order for both sides.
#[test]
fn a_mirrored_body_moves_mirrored() {
    let settings = lattice_settings(2.0);
    let body = quadruped();
    let drive = trot(body.actuators, 0.2, true);
    let lowered = lifted(&body, &settings, 0.0);
    let motion = run(&lowered, &settings, &drive);
    let off = |t: f64| {
        let apart = lowered.balls.iter().enumerate().map(|(ball, own)| {
            let is_twin = |other: &Ball| {
                let [here, there] = [own.centre, other.centre];
                (here.xy() - there.xy()).norm() + (here.z + there.z - 4.0 * PITCH).abs() < 1e-6
            };
            let twin = lowered.balls.iter().position(is_twin).unwrap();
            let (here, there) = (place(&motion, ball, t), place(&motion, twin, t));
            (here.xy() - there.xy()).norm() + (here.z + there.z - 4.0 * PITCH).abs()
        });
        apart.fold(0.0, f64::max)
    };
    // Rounding is not mirrored, and what slips a moment earlier on one side grows: 0.2 um here, 24 um at 0.3 s, 1 mm at 1 s.
    assert!(off(0.2) < 1e-6, "off by {} m", off(0.2));
}

/// The two share no physics code. A slender block bends, tips over and lies: alike, if rapier's steps are short; its
/// contacts with the ground give way by a third of a millimetre.
#[test]
fn rapier_agrees_on_a_small_bend() {
    let all = cells([0, 0, 0], [2, 5, 2]);
    let mut body = lattice(&all);
    bend(&mut body, &all, |cell| if cell[0] == 0 { 1.0 } else { -1.0 });
    let settings = Settings { iterations: 4, ..lattice_settings(1.5) };
    let drive = ramp(0.1, 0.5);
    let run = |model: &dyn Model| {
        let mut simulation = model.prepare(&body, &settings).unwrap();
        simulation.run(std::slice::from_ref(&drive)).remove(0).unwrap()
    };
    let (here, there) = (run(&Balls), run(&Rapier { substep: 1.0 / 38400.0 }));
    let off = |ball: usize| place(&here, ball, 1.5) - place(&there, ball, 1.5);
    let middle = (0..all.len()).map(off).sum::<nalgebra::Vector3<f64>>() / all.len() as f64;
    assert!(middle.x.abs() < 1e-4 && middle.y.abs() < 5e-4 && middle.z.abs() < 1e-6, "off by {middle}");
    let shape = (0..all.len()).map(|ball| (off(ball) - middle).norm()).fold(0.0, f64::max);
    assert!(shape < 2e-4, "a ball is off by {shape} m");
    assert!((here.work[0] / there.work[0] - 1.0).abs() < 0.05, "{:?} and {:?} J", here.work, there.work);
}

/// Undamped: a beam that swings and a block that is dropped.
#[test]
fn energy_does_not_grow() {
    let settings = lattice_settings(3.0);
    let swing = gained(&beam(&settings, 0.0), &settings);
    assert!(swing < 1e-5, "the beam gained {swing} m");
    let mut block = lifted(&lattice(&cells([0, 0, 0], [4, 4, 4])), &settings, 0.1);
    block.balls.iter_mut().for_each(|ball| ball.velocity.x = 0.5);
    block.links.iter_mut().for_each(|link| link.damping = 0.0);
    let drop = gained(&block, &settings);
    assert!(drop < 2e-4, "the block gained {drop} m");
}

/// Bones in flesh: springs a hundred times as stiff, at the step that is asked for.
#[test]
fn stiff_and_soft_go_together() {
    let mut body = quadruped();
    for spring in &mut body.springs {
        let bone = body.elements[spring.from].pose.translation.vector.y > 5.5 * PITCH;
        spring.stiffness = if bone { 20.0 * STIFFNESS } else { STIFFNESS };
    }
    let settings = Settings { step: 1.0 / 9600.0, ..lattice_settings(3.0) };
    let motion = run(&lifted(&body, &settings, 0.0), &settings, &trot(4, 0.2, false));
    let span = |t: f64| (place(&motion, 0, t) - place(&motion, 8, t)).norm();
    assert!((span(3.0) - span(0.0)).abs() < 0.002, "the trunk is {} m long", span(3.0));
}

/// Recorded at every step, so that a ball's momentum is that of the scheme: its mass times its way. Legs swing, so that
/// trunk and legs turn against each other.
#[test]
fn in_the_air_momenta_are_kept() {
    let body = quadruped();
    let settings = Settings { record: 1.0 / 2400.0, gravity: 0.0, ..lattice_settings(3.0) };
    let lattice = lifted(&body, &settings, 0.1);
    assert!(lattice.balls.iter().all(|ball| ball.mass == lattice.balls[0].mass));
    let motion = run(&lattice, &settings, &trot(body.actuators, 0.2, false));
    let at = |frame: usize| -> Vec<Vector3<f64>> {
        (0..motion.bodies).map(|ball| place(&motion, ball, motion.time(frame))).collect()
    };
    let start = middle(&motion, 0.0);
    let (mut most, mut turns) = (0.0_f64, Vec::new());
    for frame in (0..motion.frames() - 1).step_by(101) {
        let (t, before, after) = (motion.time(frame), at(frame), at(frame + 1));
        let (from, to) = (middle(&motion, t), middle(&motion, motion.time(frame + 1)));
        assert!((from - start).norm() < 1e-6, "{t} s: off by {} m", from - start);
        let turn = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - from).cross(&(b - to - (a - from)));
        turns.push((t, before.iter().zip(&after).map(turn).sum::<Vector3<f64>>()));
        most = most.max(before.iter().zip(&after).map(|pair| turn(pair).norm()).sum());
    }
    for (t, turn) in turns {
        assert!(turn.norm() < 2e-3 * most, "{t} s: it turns by {turn} of {most} m^2 in a step");
    }
}
