//! Ports: where parts hold each other.
//!
//! A part's frame has x forward, y up, z right. A block has six ports and is
//! held by its `back`; an actuator reaches from its `base`, where it is held,
//! along x to its `tip`.

use grammar_lang::eval::Value;
use grammar_lang::ir::{RuleSet, Shape};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::Part;

/// A port in its part's frame.
#[derive(Clone, Debug)]
pub struct PortFrame {
    /// What grammars call it.
    pub name: &'static str,
    /// Its place, with x pointing outwards.
    pub frame: Isometry3<f64>,
}

/// Names and axes (x outwards, y, z as columns) of a block's ports.
const BLOCK: [(&str, [[f64; 3]; 3]); 6] = [
    ("front", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    ("back", [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]),
    ("left", [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    ("right", [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
    ("top", [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    ("bottom", [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
];

/// The rotation whose columns are the given axes.
fn rotation(axes: [[f64; 3]; 3]) -> UnitQuaternion<f64> {
    let matrix = Matrix3::from_columns(&axes.map(Vector3::from));
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// A rotation about the x axis, without the platform's trigonometry.
pub(super) fn about_x(angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = libm::sincos(angle / 2.0);
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(cos, sin, 0.0, 0.0))
}

/// How many segments an actuator has.
pub(super) fn segments(part: &Part) -> usize {
    match part.params.get("segments") {
        Some(Value::Number(n)) => *n as usize,
        _ => 0,
    }
}

/// The ports of a part.
#[must_use]
pub fn ports(rules: &RuleSet, part: &Part) -> Vec<PortFrame> {
    if let Some(block) = rules.parts.get(&part.kind) {
        return BLOCK
            .iter()
            .map(|(name, axes)| {
                let out = Vector3::from(axes[0]);
                let reach = match block.shape {
                    Shape::Box(edges) => Vector3::from(edges).component_mul(&out).norm() / 2.0,
                    Shape::Sphere(radius) | Shape::Cylinder(radius, _) => radius,
                };
                PortFrame { name, frame: Isometry3::from_parts((out * reach).into(), rotation(*axes)) }
            })
            .collect();
    }
    let length = match rules.actuators.get(&part.kind).map(|a| a.segment) {
        Some(Shape::Cylinder(_, length)) => length * segments(part) as f64,
        _ => 0.0,
    };
    let back = rotation(BLOCK[1].1);
    vec![
        PortFrame { name: "base", frame: Isometry3::from_parts(Translation3::identity(), back) },
        PortFrame { name: "tip", frame: Isometry3::translation(length, 0.0, 0.0) },
    ]
}

/// The port that a part is held by.
pub(super) fn holding(rules: &RuleSet, part: &Part) -> u8 {
    u8::from(!rules.is_actuator(&part.kind))
}

/// How far a part's frame lies in front of the port that holds it.
fn depth(rules: &RuleSet, part: &Part) -> f64 {
    match rules.parts.get(&part.kind).map(|p| p.shape) {
        Some(Shape::Box([x, ..])) => x / 2.0,
        Some(Shape::Sphere(radius)) => radius,
        _ => 0.0,
    }
}

/// The pose of a part held by a port of another.
pub(super) fn pose_at(rules: &RuleSet, holder: &Part, port: u8, part: &Part) -> Option<Isometry3<f64>> {
    let frame = ports(rules, holder).get(port as usize)?.frame;
    let turned = Isometry3::from_parts(Translation3::identity(), about_x(part.turn));
    let mut pose = holder.pose * frame * turned * Isometry3::translation(depth(rules, part), 0.0, 0.0);
    // Long chains of products must not drift from unit length.
    pose.rotation = UnitQuaternion::new_normalize(pose.rotation.into_inner());
    Some(pose)
}

/// Where a part with this pose is held, in the world.
pub(super) fn base(rules: &RuleSet, part: &Part, pose: &Isometry3<f64>) -> Point3<f64> {
    pose * Point3::new(-depth(rules, part), 0.0, 0.0)
}
