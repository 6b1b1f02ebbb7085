//! Ports: where parts hold each other.
//!
//! A part's frame has x forward, y up, z right. A block has six ports unless it
//! declares its own, and is held by its `back` if nothing else is said; an
//! actuator reaches from its `base`, where it is held, along x to its `tip`.

use grammar_lang::eval::{Made, MadePort, Value};
use grammar_lang::ir::{ACTUATOR_PORTS, BLOCK_PORTS, Kind, RuleSet};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::Part;

/// A port in its part's frame.
#[derive(Clone, Debug)]
pub struct PortFrame {
    /// What grammars call it.
    pub name: String,
    /// Its number among those of the same name.
    pub number: f64,
    /// Its place, with x pointing outwards.
    pub frame: Isometry3<f64>,
}

/// Axes (x outwards, y, z as columns) of a block's ports, in the order of their names.
const BLOCK: [[[f64; 3]; 3]; 6] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
    [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
];

/// The rotation whose columns are the given axes.
fn rotation(axes: [[f64; 3]; 3]) -> UnitQuaternion<f64> {
    let matrix = Matrix3::from_columns(&axes.map(Vector3::from));
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// A rotation about the x, y or z axis (0, 1, 2), without the platform's trigonometry.
pub(super) fn about(axis: usize, angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = libm::sincos(angle / 2.0);
    let part = |i| if axis == i { sin } else { 0.0 };
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(cos, part(0), part(1), part(2)))
}

/// How many segments an actuator has: two, with one joint between them, if its kind does not say.
pub(super) fn segments(part: &Part) -> usize {
    match part.params.get("segments") {
        Some(Value::Number(n)) => *n as usize,
        _ => 2,
    }
}

/// The frame of a port that a part declares: y as near to the part's own up as can be.
fn declared(port: &MadePort) -> PortFrame {
    let x = Vector3::from(port.facing);
    let side = x.cross(&Vector3::y());
    let axes = if side.norm() > 1e-6 {
        let z = side.normalize();
        [x, z.cross(&x), z]
    } else {
        // Straight up or down: as the top and bottom of a block.
        let z = Vector3::z();
        [x, z.cross(&x), z]
    };
    let rotation = rotation(axes.map(|a| [a.x, a.y, a.z]));
    let frame = Isometry3::from_parts(Vector3::from(port.at).into(), rotation);
    PortFrame { name: port.name.clone(), number: port.index, frame }
}

/// The ports of a part; a cell has none, as cells grow into their neighbours' places.
#[must_use]
pub fn ports(part: &Part) -> Vec<PortFrame> {
    match part.made.as_ref() {
        Made::Block(block) if !block.ports.is_empty() => block.ports.iter().map(declared).collect(),
        Made::Block(block) => (BLOCK_PORTS.iter().zip(BLOCK))
            .map(|(name, axes)| {
                let out = Vector3::from(axes[0]);
                let reach = block.form.half_extents().component_mul(&out).norm();
                let frame = Isometry3::from_parts((out * reach).into(), rotation(axes));
                PortFrame { name: (*name).to_owned(), number: 0.0, frame }
            })
            .collect(),
        Made::Actuator(actuator) => {
            let length = 2.0 * actuator.segment.half_extents().x * segments(part) as f64;
            let base = Isometry3::from_parts(Translation3::identity(), rotation(BLOCK[1]));
            let tip = Isometry3::translation(length, 0.0, 0.0);
            let ends = ACTUATOR_PORTS.iter().zip([base, tip]);
            ends.map(|(name, frame)| PortFrame { name: (*name).to_owned(), number: 0.0, frame }).collect()
        }
        Made::Cell(_) => Vec::new(),
    }
}

/// How many ports a part has.
pub(super) fn count(part: &Part) -> usize {
    match part.made.as_ref() {
        Made::Block(block) if !block.ports.is_empty() => block.ports.len(),
        Made::Block(_) => BLOCK_PORTS.len(),
        Made::Actuator(_) => ACTUATOR_PORTS.len(),
        Made::Cell(_) => 0,
    }
}

/// The ports by which a kind of part is held, and at its other end: `back` and
/// `front`, `base` and `tip`; the first port stands for a missing `back`, `tip` for a missing `front`.
pub(crate) fn ends(rules: &RuleSet, kind: &str) -> (u8, Option<u8>) {
    match rules.kind(kind) {
        Some(Kind::Block(block)) if !block.ports.is_empty() => {
            let find = |name: &str| block.ports.iter().position(|p| p.name == name).map(|i| i as u8);
            (find("back").unwrap_or(0), find("front").or_else(|| find("tip")))
        }
        Some(Kind::Actuator(_)) => (0, Some(1)),
        Some(Kind::Block(_) | Kind::Cell(_)) | None => (1, Some(0)),
    }
}

/// The pose of a part held by a port of another: the two ports meet face to face.
pub(crate) fn pose_at(holder: &Part, port: u8, part: &Part) -> Option<Isometry3<f64>> {
    let frame = ports(holder).get(port as usize)?.frame;
    let own = ports(part).get(part.holding as usize)?.frame;
    let half_turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(0.0, 0.0, 1.0, 0.0));
    let turned = Isometry3::from_parts(Translation3::identity(), about(0, part.turn) * half_turn);
    let mut pose = holder.pose * frame * turned * own.inverse();
    // Long chains of products must not drift from unit length.
    pose.rotation = UnitQuaternion::new_normalize(pose.rotation.into_inner());
    Some(pose)
}

/// Where a part with this pose is held, in the world.
pub(super) fn base(part: &Part, pose: &Isometry3<f64>) -> Point3<f64> {
    let own = ports(part).get(part.holding as usize).map(|p| p.frame).unwrap_or_default();
    pose * Point3::from(own.translation.vector)
}
