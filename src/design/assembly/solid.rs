//! Shapes as the geometry library knows them.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use parry3d_f64::math::Pose;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder};

use super::Shape;

/// A shape, ready to be asked for distances.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    Ball(Ball),
    Box(Cuboid),
    Cylinder(Cylinder),
    Capsule(Capsule),
}

impl Solid {
    /// A shape, so many times as large.
    pub(crate) fn new(shape: &Shape, times: f64) -> Self {
        match shape {
            Shape::Ball { radius } => Self::Ball(Ball::new(radius * times)),
            Shape::Box { half } => {
                let half = half * times;
                Self::Box(Cuboid::new(parry3d_f64::math::Vector::new(half.x, half.y, half.z)))
            }
            Shape::Cylinder { radius, half_length } => {
                Self::Cylinder(Cylinder::new(half_length * times, radius * times))
            }
            Shape::Capsule { radius, half_straight } => {
                Self::Capsule(Capsule::new_x(half_straight * times, radius * times))
            }
        }
    }

    /// As the library takes it.
    pub(crate) fn shape(&self) -> &dyn parry3d_f64::shape::Shape {
        match self {
            Self::Ball(s) => s,
            Self::Box(s) => s,
            Self::Cylinder(s) => s,
            Self::Capsule(s) => s,
        }
    }
}

/// The same pose for the geometry library, whose cylinders stand along y.
pub(crate) fn pose(pose: &Isometry3<f64>, shape: &Shape) -> Pose {
    let pose = if matches!(shape, Shape::Cylinder { .. }) {
        // x of the element is y of the library's cylinder.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(half, 0.0, 0.0, -half));
        pose * Isometry3::from_parts(Vector3::zeros().into(), turn)
    } else {
        *pose
    };
    let (t, r) = (pose.translation.vector, pose.rotation.into_inner());
    Pose::from_parts(
        parry3d_f64::math::Vector::new(t.x, t.y, t.z),
        parry3d_f64::math::Rotation::from_xyzw(r.i, r.j, r.k, r.w),
    )
}
