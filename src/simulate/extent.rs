//! How far shapes reach.

use nalgebra::{Isometry3, Vector3};

use crate::design::assembly::Shape;

/// Height of the lowest point of a shape in a pose, m.
pub(super) fn lowest(shape: &Shape, pose: &Isometry3<f64>) -> f64 {
    let up = pose.rotation.inverse() * Vector3::y();
    let reach = match *shape {
        Shape::Box { half } => half.dot(&up.abs()),
        Shape::Ball { radius } => radius,
        Shape::Cylinder { radius, half_length } => {
            half_length * up.x.abs() + radius * (1.0 - up.x * up.x).max(0.0).sqrt()
        }
    };
    pose.translation.vector.y - reach
}

/// The longest edge, length or diameter of a shape, m.
pub(super) fn longest(shape: &Shape) -> f64 {
    let half = match *shape {
        Shape::Box { half } => half.max(),
        Shape::Ball { radius } => radius,
        Shape::Cylinder { radius, half_length } => radius.max(half_length),
    };
    2.0 * half
}
