//! Rotations as vectors, with the same bits on every platform.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The rotation by a vector, whose length is the angle in rad.
pub(super) fn by(vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = vector.norm();
    let (sin, cos) = libm::sincos(0.5 * angle);
    // Half of the vector times sin(x) / x.
    let scale = if angle > 1e-8 { sin / angle } else { 0.5 };
    UnitQuaternion::new_normalize(Quaternion::from_parts(cos, vector * scale))
}

/// The vector of a rotation: its length is the angle in rad, at most half a turn.
pub(super) fn vector(turn: &UnitQuaternion<f64>) -> Vector3<f64> {
    let near = if turn.w < 0.0 { -1.0 } else { 1.0 };
    let (sin, cos) = (turn.imag() * near, turn.w * near);
    let length = sin.norm();
    if length > 1e-8 { sin * (2.0 * libm::atan2(length, cos) / length) } else { sin * 2.0 }
}

/// How far a rotation turns about an axis, rad, as near as can be to another such angle; and the rest of it as a vector, which is
/// small where little else turns.
pub(super) fn about(turn: &UnitQuaternion<f64>, axis: &Vector3<f64>, near: f64) -> (f64, Vector3<f64>) {
    let along = turn.imag().dot(axis);
    let angle = 2.0 * libm::atan2(along, turn.w);
    let twist = by(&(axis * angle));
    let turns = libm::round((angle - near) / std::f64::consts::TAU);
    (angle - turns * std::f64::consts::TAU, vector(&(turn * twist.inverse())))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::{about, by, vector};

    #[test]
    fn vectors_and_rotations_are_inverse() {
        for each in [
            Vector3::new(0.3, -1.0, 2.0),
            Vector3::zeros(),
            Vector3::new(1e-9, 0.0, 2e-9),
            Vector3::x() * 3.1,
        ] {
            assert!((vector(&by(&each)) - each).norm() < 1e-12, "{each}");
        }
    }

    #[test]
    fn a_turn_about_an_axis_is_found_beside_another() {
        let (axis, small) = (Vector3::y(), Vector3::new(1e-3, 0.0, -2e-3));
        for angle in [0.4, 3.0, 7.0, -20.0] {
            let (found, rest) = about(&(by(&small) * by(&(axis * angle))), &axis, angle + 0.3);
            assert!((found - angle).abs() < 1e-5, "{angle}: {found}");
            assert!((rest - small).norm() < 1e-4, "{angle}: {rest}");
        }
    }
}
