//! What a motion owes to sliding: no two simulators agree on what slides.

use nalgebra::{Isometry3, Point3, Vector3};

use super::Motion;
use crate::design::assembly::Shape;

/// An element touches the ground whose lowest point is not higher than this, m.
const TOUCH: f64 = 2e-4;
/// It slides if that point is faster than this, m/s.
const SLIDES: f64 = 1e-3;
/// Edges and faces that lie flat, within about this angle in rad, touch with their middle.
const FLAT: f64 = 0.02;

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
                    own.go(&placement.shape, &before, &after, span);
                }
            }
        }
        all
    }
}

impl Sliding {
    /// Adds a way from one pose to the next.
    fn go(&mut self, shape: &Shape, before: &Isometry3<f64>, after: &Isometry3<f64>, span: f64) {
        self.path += horizontal(&(after.translation.vector - before.translation.vector));
        if shape.lowest(before) > TOUCH || shape.lowest(after) > TOUCH {
            return;
        }
        self.touching += span;
        // The point that touches is another one after a roll: what touches before goes on, what touches after
        // has come, and the mean of both errs in the third order of the turn only.
        let way = |point: Point3<f64>| after * point - before * point;
        let slid = horizontal(&((way(shape.sole(before, FLAT)) + way(shape.sole(after, FLAT))) / 2.0));
        if slid > SLIDES * span {
            self.slid += slid;
            self.sliding += span;
        }
    }
}

fn horizontal(way: &Vector3<f64>) -> f64 {
    libm::hypot(way.x, way.z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};
    use std::sync::Arc;

    use nalgebra::{Translation3, UnitQuaternion};

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
            placements: Arc::new([Placement { body: 0, local: Isometry3::identity(), shape }]),
        };
        motion.sliding()[0]
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    fn at(x: f64, y: f64) -> Translation3<f64> {
        Translation3::new(x, y, 0.0)
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
            let rolling = moved(shape, |t| at(0.01 * TAU * t, 0.01) * (roll(t) * turned));
            close(rolling.path, 0.02 * TAU);
            close(rolling.touching, 2.0);
            close(rolling.sliding, 0.0);
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
