//! Whether parts overlap.

use grammar_lang::ir::RuleSet;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use parry3d_f64::math::Pose;
use parry3d_f64::query;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder};

use super::assembly::{Shape, TOUCHING};
use super::{Body, Design, PartId};

enum Solid {
    Ball(Ball),
    Box(Cuboid),
    Cylinder(Cylinder),
    Capsule(Capsule),
}

impl Solid {
    fn new(shape: &Shape) -> Self {
        match shape {
            Shape::Ball { radius } => Self::Ball(Ball::new(radius * TOUCHING)),
            Shape::Box { half } => {
                let half = half * TOUCHING;
                Self::Box(Cuboid::new(parry3d_f64::math::Vector::new(half.x, half.y, half.z)))
            }
            Shape::Cylinder { radius, half_length } => {
                Self::Cylinder(Cylinder::new(half_length * TOUCHING, radius * TOUCHING))
            }
            Shape::Capsule { radius, half_straight } => {
                Self::Capsule(Capsule::new_x(half_straight * TOUCHING, radius * TOUCHING))
            }
        }
    }

    fn shape(&self) -> &dyn parry3d_f64::shape::Shape {
        match self {
            Self::Ball(s) => s,
            Self::Box(s) => s,
            Self::Cylinder(s) => s,
            Self::Capsule(s) => s,
        }
    }
}

/// The same pose for the geometry library, whose cylinders stand along y.
fn pose(pose: &Isometry3<f64>, shape: &Shape) -> Pose {
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

/// Two parts of a design that overlap, if any do.
pub(super) fn first(design: &Design, rules: &RuleSet) -> Option<(PartId, PartId)> {
    let body = Body::new(design, rules);
    let solids: Vec<_> = body
        .assembly
        .elements
        .iter()
        .zip(&body.parts_of_elements)
        .map(|(e, part)| {
            (Solid::new(&e.shape), pose(&e.pose, &e.shape), e.shape.reach(), e.pose.translation.vector, *part)
        })
        .collect();
    for (i, (a, pose_a, reach_a, centre_a, part_a)) in solids.iter().enumerate() {
        for (b, pose_b, reach_b, centre_b, part_b) in solids.iter().skip(i + 1) {
            if part_a == part_b || (centre_a - centre_b).norm() > reach_a + reach_b {
                continue;
            }
            // A pair that the library cannot judge counts as overlapping.
            if query::intersection_test(pose_a, a.shape(), pose_b, b.shape()).map_or(true, |s| s.intersecting)
            {
                return Some((*part_a, *part_b));
            }
        }
    }
    None
}
