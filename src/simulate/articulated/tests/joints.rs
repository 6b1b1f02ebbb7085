//! Bodies whose joints turn and slide: what must not change when nothing acts, and what springs may give back.

use nalgebra::Vector3;

use super::conservation::{poses, turning};
use super::{aloft, chain, energy_of, fine, keeps_momenta, loose, solver, thrown};
use crate::design::assembly::{Control, Dof, JointKind, Travel};
use crate::simulate::Settings;
use crate::simulate::articulated::kinematics::place;
use crate::simulate::articulated::scalar::Scalar;
use crate::simulate::articulated::solver::Solver;
use crate::simulate::articulated::vector::{Sym, V3};
use crate::simulate::tests::bodies::hinge;

/// A joint with a spring of its own, N m/rad or N/m.
fn sprung(anchor: Vector3<f64>, axis: Vector3<f64>, travel: Travel, stiffness: f64) -> Dof {
    let control = Control::Passive { neutral: 0.0 };
    Dof { travel, control, stiffness, effort: f64::INFINITY, ..loose(anchor, axis) }
}

/// An uneven body that tumbles in the air without weight: it slides, turns, and slides again. With springs, or limp.
fn tumbling<S: Scalar<Kit = ()>>(step: f64, springs: bool) -> Solver<S> {
    let joint = |anchor: Vector3<f64>| match (anchor.x * 40.0) as usize {
        0 => sprung(anchor, Vector3::new(0.3, 1.0, 0.2), Travel::Slide, if springs { 4.0 } else { 0.0 }),
        1 => sprung(anchor, Vector3::new(1.0, 0.0, 1.0), Travel::Turn, if springs { 2e-3 } else { 0.0 }),
        _ => sprung(anchor, Vector3::new(-0.5, 0.2, 1.0), Travel::Slide, if springs { 6.0 } else { 0.0 }),
    };
    thrown(chain(3, 0.03, joint), step)
}

/// A joint about all axes, with a spring about each of them or none.
fn socket(anchor: Vector3<f64>, stiffness: f64) -> JointKind {
    let axes = [Vector3::y(), Vector3::z(), Vector3::x()];
    JointKind::Socket(Box::new(axes.map(|axis| sprung(anchor, axis, Travel::Turn, stiffness))))
}

/// The same with sockets. Without springs they must not come to where two of their axes are one: it tumbles more slowly.
fn in_sockets<S: Scalar<Kit = ()>>(step: f64, springs: bool) -> Solver<S> {
    let mut solver: Solver<S> =
        thrown(chain(3, 0.03, |anchor| socket(anchor, if springs { 2e-3 } else { 0.0 })), step);
    if !springs {
        for speed in &mut solver.state.speeds {
            *speed *= speed.like(0.3);
        }
        solver.begin();
    }
    solver
}

/// The velocities of all bodies are those with which their places and rotations change.
#[test]
fn velocities_are_how_places_change() {
    let bodies: [Solver<f64>; 2] = [tumbling(1.0 / 240.0, true), in_sockets(1.0 / 240.0, true)];
    bodies.into_iter().for_each(velocities_are_theirs);
}

fn velocities_are_theirs(mut solver: Solver<f64>) {
    (0..40).for_each(|_| solver.advance());
    let small = 1e-6;
    let place_after = |solver: &Solver<f64>, time: f64| {
        let (mut state, mut frames) = (solver.state.clone(), solver.frames.clone());
        state.turn(&solver.tree, time);
        // Places are relative to the root's centre, which moves, too.
        place(&solver.tree, &state, &mut frames);
        frames
    };
    let (before, after) = (place_after(&solver, -small), place_after(&solver, small));
    let root = solver.frames[0].velocity;
    for (body, frame) in solver.frames.iter().enumerate() {
        for axis in 0..3 {
            let rate = (after[body].centre[axis] - before[body].centre[axis]) / (2.0 * small);
            let velocity = frame.velocity[axis] - root[axis];
            assert!((rate - velocity).abs() < 1e-4, "body {body}: {rate} cm/s for {velocity}");
        }
        let turn = (after[body].rotation[2][1] - before[body].rotation[2][1]) / (2.0 * small);
        let second = V3([0, 1, 2].map(|row| frame.rotation[row][1]));
        let due = frame.spin.cross(second)[2];
        assert!((turn - due).abs() < 1e-4, "body {body}: {turn} for {due}");
    }
}

/// The mass matrix is that of the kinetic energy of all bodies.
#[test]
fn the_mass_matrix_is_that_of_the_energy() {
    let bodies: [Solver<f64>; 2] = [tumbling(1.0 / 240.0, false), in_sockets(1.0 / 240.0, false)];
    bodies.into_iter().for_each(the_mass_matrix_is_right);
}

fn the_mass_matrix_is_right(mut solver: Solver<f64>) {
    use crate::simulate::articulated::inertia::{Composite, mass_matrix, turn_inertias};
    (0..40).for_each(|_| solver.advance());
    let tree = &solver.tree;
    let mut inertias = vec![Sym::null(()); tree.links.len()];
    turn_inertias(tree, &solver.frames, &mut inertias);
    let mut composites = vec![Composite::null(()); tree.links.len()];
    let mut h = vec![0.0; tree.entries];
    mass_matrix(tree, &solver.frames, &inertias, &mut composites, &mut h);
    let speeds = &solver.state.speeds;
    let mut by_matrix = 0.0;
    for dof in 0..tree.dofs() {
        let path = tree.path_to(dof);
        for (place, &other) in path.iter().enumerate() {
            let twice = if other as usize == dof { 1.0 } else { 2.0 };
            by_matrix += 0.5 * twice * h[tree.rows[dof] + place] * speeds[dof] * speeds[other as usize];
        }
    }
    let by_bodies: f64 = tree
        .links
        .iter()
        .zip(&solver.frames)
        .zip(&inertias)
        .map(|((link, frame), inertia)| {
            0.5 * (frame.velocity.square() * link.mass + frame.spin.dot(*inertia * frame.spin))
        })
        .sum();
    assert!((by_matrix / by_bodies - 1.0).abs() < 1e-9, "{by_matrix} and {by_bodies} erg");
}

#[test]
fn what_tumbles_keeps_its_momenta() {
    for (springs, sockets) in [(false, false), (true, false), (false, true), (true, true)] {
        let body = |step: f64| if sockets { in_sockets(step, springs) } else { tumbling(step, springs) };
        keeps_momenta(&mut body(1.0 / 30720.0), 7680);
        // At every step, whatever its length.
        let mut solver: Solver<f64> = body(1.0 / 240.0);
        let (mut first, mut before) = (None, poses(&solver));
        for _ in 0..480 {
            solver.advance();
            let after = poses(&solver);
            let now = turning(&solver, &before, &after, 1.0 / 240.0);
            let first = *first.get_or_insert(now);
            assert!((now - first).norm() < 1e-4 * first.norm(), "{first} became {now}");
            before = after;
        }
    }
}

/// Springs store what they take: the sum falls by what the scheme takes from stiff motion, and gains nothing.
#[test]
fn what_tumbles_keeps_its_energy() {
    for (springs, sockets) in [(false, false), (true, false), (false, true), (true, true)] {
        let drift = |rate: f64| {
            let step = 1.0 / rate;
            let mut solver: Solver<f64> =
                if sockets { in_sockets(step, springs) } else { tumbling(step, springs) };
            let start = energy_of(&solver);
            let (mut low, mut high) = (0.0_f64, 0.0_f64);
            for _ in 0..(0.5 * rate) as usize {
                solver.advance();
                let off = energy_of(&solver) / start - 1.0;
                (low, high) = (low.min(off), high.max(off));
            }
            (low, high)
        };
        let [(coarse, most), (fine, _)] = [240.0, 3840.0].map(drift);
        assert!(most < 0.02, "springs {springs}, sockets {sockets}: gained {most}");
        assert!(
            coarse > -0.2 && fine > coarse / 8.0 - 1e-3,
            "springs {springs}, sockets {sockets}: lost {coarse}, then {fine}"
        );
    }
}

/// A pendulum in a socket goes round in a circle as fast as it should: `w^2 = g / (L cos(angle from below))`.
#[test]
fn a_pendulum_in_a_socket_goes_round() {
    let (length, down) = (10.0, 0.7_f64);
    let step = 1.0 / 960.0;
    let mut solver: Solver<f64> = aloft(&chain(1, 0.1, |anchor| socket(anchor, 0.0)), &fine(step));
    solver.anchored = true;
    // At rest it lies along x; its third body is the ball.
    solver.state.positions[2] = -down;
    let speed = libm::sqrt(981.0 / (length * libm::sin(down)));
    let first = solver.state.speeds.len() - 3;
    solver.state.speeds[first] = speed;
    solver.begin();
    let steps = 1920;
    for _ in 0..steps {
        solver.advance();
        let off = solver.state.positions[2] + down;
        assert!(off.abs() < 5e-3, "it swings by {off} rad");
    }
    let (turned, due) = (solver.state.positions[1], speed * step * f64::from(steps));
    assert!((turned / due - 1.0).abs() < 2e-3, "{turned} rad for {due}");
    assert!(solver.state.positions[3].abs() < 1e-3, "it twists by {}", solver.state.positions[3]);
}

/// A spring that is drawn back and forth by a servo, for long: what it gives back is counted, and no more.
#[test]
fn no_spring_gives_more_than_it_took() {
    let joint = |anchor: Vector3<f64>| {
        if anchor.x < 0.01 {
            Dof { limits: (-1.0, 1.0), share: 1.0, ..hinge(anchor, Vector3::z(), 0) }
        } else {
            sprung(anchor, Vector3::y(), Travel::Slide, 20.0)
        }
    };
    let mut assembly = chain(2, 0.03, joint);
    assembly.elements[2].mass = 0.02;
    let mut solver = aloft::<f32>(&assembly, &Settings { gravity: 0.0, ..fine(1.0 / 240.0) });
    let mut most = 0.0_f32;
    for step in 0..4800 {
        solver.targets[0] = 0.4 * libm::sinf(step as f32 / 240.0 * 20.0);
        solver.advance();
        most = most.max(solver.ledger.gained / solver.ledger.allowed);
    }
    assert_eq!(solver.failures, [None]);
    assert!(most < 0.2, "{most} of what is allowed");
}

/// Servos of a row of light joints are all at their limits when a blow has made the joints fast. Each may only brake then: one that
/// pushed on would throw its joint from one hard limit to the other, in every step.
#[test]
fn servos_at_their_limits_brake() {
    let joint = |anchor| Dof { limits: (-0.5, 0.5), ..hinge(anchor, Vector3::z(), 0) };
    let mut worst = 0.0_f64;
    for seed in 0..10 {
        let mut solver = solver::<f64>(&chain(10, 0.012, joint), &fine(1.0 / 240.0));
        for (place, speed) in solver.state.speeds.iter_mut().skip(6).enumerate() {
            *speed = 50.0 * libm::sin(f64::from(seed) + 1.7 * (place * place) as f64);
        }
        solver.begin();
        for _ in 0..60 {
            solver.advance();
            for body in 1..solver.tree.links.len() {
                let (given, right) = solver.joints.given(body, &solver.state.speeds);
                worst = worst.max((given - right).abs());
            }
        }
    }
    assert!(worst < 0.2, "a servo was off by {worst} of its limit");
}
