//! What a motion owes to sliding: no two simulators agree on what slides.

use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};

use super::Motion;
use crate::design::assembly::Shape;

/// An element touches the ground whose lowest point is not higher than this, m.
const TOUCH: f64 = 2e-4;
/// It slides if that point is faster than this, m/s.
const SLIDES: f64 = 1e-3;
/// A rolling surface slides if that point is faster than this share of how fast the surface turns past it: where a step
/// takes the chord for the arc, a wheel creeps by up to a hundredth.
const CREEPS: f64 = 0.015;
/// Edges and faces lie flat within about this angle, rad.
const FLAT: f64 = 0.02;
/// A turn is followed in pieces of at most this angle, rad.
const PIECE: f64 = 0.2;

/// How an element went over the ground in a whole motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sliding {
    /// The path of its centre, ups and downs aside, m.
    pub path: f64,
    /// The path that its points slid while they touched the ground, m.
    pub slid: f64,
    /// How long it touched the ground, s.
    pub touching: f64,
    /// How long of that it slid, s.
    pub sliding: f64,
}

impl Motion {
    /// How each element went over the ground, from frame to frame.
    #[must_use]
    pub fn sliding(&self) -> Vec<Sliding> {
        let mut all = vec![Sliding::default(); self.placements.len()];
        let frames: Vec<_> = self.poses.chunks_exact(self.bodies.max(1)).collect();
        for (frame, pair) in frames.windows(2).enumerate() {
            let span = self.time(frame + 1) - self.time(frame);
            for (placement, own) in self.placements.iter().zip(&mut all) {
                let at =
                    |frame: &[Isometry3<f64>]| frame.get(placement.body).map(|body| body * placement.local);
                if let (Some(before), Some(after)) = (at(pair[0]), at(pair[1])) {
                    let shape = |frame| placement.swollen(|actuator| self.position(frame, actuator));
                    let shapes = [shape(frame), shape(frame + 1)];
                    own.go(&shapes, &before, &after, span);
                }
            }
        }
        all
    }
}

impl Sliding {
    /// Adds a way from one pose to the next.
    fn go(
        &mut self,
        [shape, swollen]: &[Shape; 2],
        before: &Isometry3<f64>,
        after: &Isometry3<f64>,
        span: f64,
    ) {
        self.path += horizontal(&(after.translation.vector - before.translation.vector));
        let turn = rotation_vector(&(after.rotation * before.rotation.inverse()));
        if shape.lowest(before) > TOUCH || swollen.lowest(after) > TOUCH {
            return;
        }
        self.touching += span;
        // The point that touches is another one after a roll: it is found again in each piece of the turn, and its way there
        // is that of the body's velocity, as if the body moved and turned evenly from one pose to the next.
        let moved = after.translation.vector - before.translation.vector;
        let pieces = (turn.norm() / PIECE).ceil().max(1.0);
        let (mut slid, mut rolled) = (0.0, 0.0);
        for piece in 0..pieces as usize {
            let share = (piece as f64 + 0.5) / pieces;
            let turned = UnitQuaternion::new_normalize(half_turn(&(turn * share))) * before.rotation;
            let centre = before.translation.vector + moved * share;
            let pose = Isometry3::from_parts(centre.into(), turned);
            let arm = pose * shape.sole(&pose, FLAT) - Point3::from(centre);
            // The ends of what lies flat turn about its middle: their speeds are taken together as a root mean square.
            let about = turn.y * shape.sole_reach(&pose, FLAT);
            slid += libm::hypot(horizontal(&(moved + turn.cross(&arm))), about) / pieces;
            rolled += horizontal(&turn.cross(&arm)) / pieces;
        }
        // What spins where it is rolls, too, but not on.
        let rolled = rolled.min(horizontal(&moved));
        if slid > SLIDES * span + CREEPS * rolled {
            self.slid += slid;
            self.sliding += span;
        }
    }
}

/// The axis of a turn times its angle, at most half a turn.
pub(super) fn rotation_vector(turn: &UnitQuaternion<f64>) -> Vector3<f64> {
    let (sine, cosine) = (turn.imag().norm(), turn.w);
    let angle = if cosine < 0.0 { libm::atan2(-sine, -cosine) } else { libm::atan2(sine, cosine) };
    if sine > 0.0 { turn.imag() * (2.0 * angle / sine) } else { Vector3::zeros() }
}

/// The quaternion of a turn by so much about so much.
pub(super) fn half_turn(turn: &Vector3<f64>) -> Quaternion<f64> {
    let angle = turn.norm();
    let (sine, cosine) = libm::sincos(angle / 2.0);
    Quaternion::from_parts(cosine, if angle > 0.0 { turn * (sine / angle) } else { Vector3::zeros() })
}

fn horizontal(way: &Vector3<f64>) -> f64 {
    libm::hypot(way.x, way.z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};
    use std::sync::Arc;

    use nalgebra::Translation3;

    use super::*;
    use crate::simulate::motion::Placement;

    /// The motion of one element over two seconds, 30 frames in each.
    fn moved(shape: Shape, pose: impl Fn(f64) -> Isometry3<f64>) -> Sliding {
        let interval = 1.0 / 30.0;
        let motion = Motion {
            interval,
            duration: 2.0,
            bodies: 1,
            poses: (0..=60).map(|frame| pose(f64::from(frame) * interval)).collect(),
            bends: Vec::new(),
            work: Vec::new(),
            commands: None,
            placements: Arc::new([Placement::new(0, Isometry3::identity(), shape)]),
        };
        motion.sliding()[0]
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    fn at(x: f64, y: f64) -> Translation3<f64> {
        Translation3::new(x, y, 0.0)
    }

    /// A box that turns flat on the ground about the vertical: its corners slide.
    #[test]
    fn corners_of_what_turns_flat_slide() {
        let half = nalgebra::Vector3::new(0.03, 0.01, 0.04);
        let spun = moved(Shape::Box { half }, |time| {
            Isometry3::new(Vector3::new(0.0, 0.01, 0.0), Vector3::y() * (0.5 * time))
        });
        // A turn of 1 rad at 5 cm from the middle.
        assert!((spun.slid - 0.05).abs() < 1e-6 && (spun.sliding - 2.0).abs() < 1e-6, "{spun:?}");
        let end = moved(Shape::Cylinder { radius: 0.03, half_length: 0.02 }, |time| {
            let stands = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2);
            let turns = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.5 * time);
            Isometry3::from_parts(Translation3::new(0.0, 0.02, 0.0), turns * stands)
        });
        assert!((end.slid - 0.03).abs() < 1e-6, "{end:?}");
    }

    #[test]
    fn what_is_dragged_slides_and_what_rolls_does_not() {
        let half = Vector3::new(0.02, 0.01, 0.01);
        let dragged = moved(Shape::Box { half }, |t| at(0.1 * t, 0.01).into());
        close(dragged.path, 0.2);
        close(dragged.slid, 0.2);
        close(dragged.touching, 2.0);
        close(dragged.sliding, 2.0);
        let roll = |t: f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -t * TAU);
        let across = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
        let round = [
            (Shape::Ball { radius: 0.01 }, UnitQuaternion::identity()),
            (Shape::Cylinder { radius: 0.01, half_length: 0.03 }, across),
        ];
        for (shape, turned) in round {
            // Slowly, and as fast as a wheel goes: more than a radian from frame to frame.
            for turns in [1.0, 6.0] {
                let fast = |t: f64| roll(turns * t) * turned;
                let rolling = moved(shape, |t| at(0.01 * TAU * turns * t, 0.01) * fast(t));
                close(rolling.path, 0.02 * TAU * turns);
                close(rolling.touching, 2.0);
                close(rolling.sliding, 0.0);
            }
            // Where a step takes the chord for the arc, a wheel creeps: that is no sliding, as a spinning wheel's is.
            for (creep, slides) in [(0.01, 0.0), (0.05, 2.0)] {
                let creeping = |t: f64| at((1.0 - creep) * 0.06 * TAU * t, 0.01) * (roll(6.0 * t) * turned);
                close(moved(shape, creeping).sliding, slides);
            }
            let spinning = moved(shape, |t| at(0.0, 0.01) * (roll(t) * turned));
            close(spinning.path, 0.0);
            assert!((spinning.slid / (0.02 * TAU) - 1.0).abs() < 0.02, "{spinning:?}");
            close(spinning.sliding, 2.0);
        }
    }

    #[test]
    fn what_flies_or_stands_or_tips_over_an_edge_does_not_slide() {
        let half = Vector3::new(0.02, 0.01, 0.01);
        let flying = moved(Shape::Box { half }, |t| at(0.1 * t, 0.011).into());
        close(flying.touching + flying.slid + flying.sliding, 0.0);
        let standing = moved(Shape::Box { half }, |t| at(0.0, 0.01 + 1e-4 * libm::sin(40.0 * t)).into());
        close(standing.touching, 2.0);
        close(standing.slid, 0.0);
        // About the edge at x = 0.
        let tipping = moved(Shape::Box { half }, |t| {
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4 * t) * at(0.02, 0.01)
        });
        close(tipping.touching, 2.0);
        assert!(tipping.slid < 2e-4 && tipping.path > 0.004, "{tipping:?}");
    }
}
