//! How far bodies turn about the vertical.
//!
//! The vertical part of the angular velocity does not add up to that: what sways in circles without turning gains a part of a full
//! turn in each circle (the solid angle that its axis goes round). So it is measured by a direction that is fixed in the body
//! and stays level as well as any: by how far that goes round. A wheel has its axle, and a body that tips over the axis that it
//! tips about. What tumbles about all axes has none; there the vertical part is all that there is.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::Motion;
use super::sliding::rotation_vector;

/// A direction is level enough whose level part is never shorter than this share of it: one that rises by 60 degrees.
const LEVEL: f64 = 0.5;

impl Motion {
    /// By how much each element turned about the vertical, rad: to the left, as seen from above, is positive, and full turns count.
    #[must_use]
    pub fn turned(&self) -> Vec<f64> {
        let bodies: Vec<f64> = (0..self.bodies)
            .map(|body| {
                let own = self.poses.iter().skip(body).step_by(self.bodies.max(1));
                turned(&own.map(|pose| pose.rotation).collect::<Vec<_>>())
            })
            .collect();
        self.placements.iter().map(|p| bodies.get(p.body).copied().unwrap_or(0.0)).collect()
    }
}

/// The same of one body with these rotations, one after the other.
fn turned(rotations: &[UnitQuaternion<f64>]) -> f64 {
    let direction = most_level(rotations);
    let (mut round, mut vertical, mut least) = (0.0, 0.0, f64::INFINITY);
    for pair in rotations.windows(2) {
        let turn = rotation_vector(&(pair[1] * pair[0].inverse())).y;
        let (before, after) = (pair[0] * direction, pair[1] * direction);
        let across = before.z * after.x - before.x * after.z;
        let along = before.x * after.x + before.z * after.z;
        // Of all angles that lead there, the one that is nearest to how far the body turned.
        let angle = libm::atan2(across, along);
        round += angle + TAU * ((turn - angle) / TAU).round();
        vertical += turn;
        least = least.min(libm::hypot(before.x, before.z)).min(libm::hypot(after.x, after.z));
    }
    if least < LEVEL { vertical } else { round }
}

/// The direction in a body whose height has the least sum of squares over these rotations.
fn most_level(rotations: &[UnitQuaternion<f64>]) -> Vector3<f64> {
    let ups = rotations.iter().map(|rotation| rotation.inverse() * Vector3::y());
    let squares = ups.fold(Matrix3::zeros(), |sum, up| sum + up * up.transpose());
    let eigen = squares.symmetric_eigen();
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a body with these rotations in two seconds, 30 in each, turns by.
    fn over(rotation: impl Fn(f64) -> UnitQuaternion<f64>) -> f64 {
        turned(&(0..=60).map(|frame| rotation(f64::from(frame) / 30.0)).collect::<Vec<_>>())
    }

    fn about(axis: Vector3<f64>, angle: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(axis.normalize() * angle)
    }

    /// The vertical part of how such a body turns, summed up.
    fn vertical(rotation: impl Fn(f64) -> UnitQuaternion<f64>) -> f64 {
        let at = |frame: i32| rotation(f64::from(frame) / 30.0);
        (0..60).map(|frame| rotation_vector(&(at(frame + 1) * at(frame).inverse())).y).sum()
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    /// Full turns count, slow and fast ones, to the left and to the right.
    #[test]
    fn full_turns_count() {
        close(over(|t| about(Vector3::y(), 5.0 * t)), 10.0);
        close(over(|t| about(Vector3::y(), -80.0 * t)), -160.0);
    }

    /// What rolls straight on does not turn, whatever the direction that it rolls in.
    #[test]
    fn what_rolls_does_not_turn() {
        close(over(|t| about(Vector3::new(0.3, 0.0, 0.8), 20.0 * t)), 0.0);
        // On an axle that is not quite level it goes round its axle's mean direction.
        assert!(over(|t| about(Vector3::new(0.3, 0.05, 0.8), TAU * t)).abs() < 1e-9);
    }

    /// A mast that leans by 20 degrees to one side after the other, in circles, does not turn; with a turn of its own, it turns by that.
    #[test]
    fn what_sways_in_circles_does_not_turn() {
        let lean = |t: f64| about(Vector3::new(libm::sin(TAU * t), 0.0, libm::cos(TAU * t)), 0.35);
        close(over(lean), 0.0);
        close(over(|t| about(Vector3::y(), 1.5 * t) * lean(t)), 3.0);
        let vertical = vertical(lean);
        assert!(vertical.abs() > 0.5, "the vertical part comes to {vertical} rad");
    }

    /// What has no direction that stays level is measured by the vertical part of how it turns.
    #[test]
    fn what_tumbles_has_the_vertical_part() {
        let tumbling = |t: f64| {
            about(Vector3::y(), 2.0 * t) * about(Vector3::x(), 7.0 * t) * about(Vector3::z(), 9.0 * t)
        };
        close(over(tumbling), vertical(tumbling));
    }
}
