//! Joints in the frame of their part: where those of a row are, and about which axes joints move.

use grammar_lang::ir::{JointKind, RuleSet};
use nalgebra::Vector3;

use super::{Part, symmetry};

/// Held by its tip a row does the same: each segment nearer to the base moves against its parent.
pub(super) fn side(by_tip: bool) -> f64 {
    if by_tip { -1.0 } else { 1.0 }
}

/// The axes of a joint in the frame of its part, where of a row what is nearer to the tip moves. A socket has three, which it
/// turns about one after the other: from side to side, up and down, and about itself.
pub(super) fn axes_of(kind: JointKind, axis: [f64; 3], part: &Part, rules: &RuleSet) -> Vec<Vector3<f64>> {
    let axes = if kind == JointKind::Socket {
        vec![Vector3::y(), Vector3::z(), Vector3::x()]
    } else {
        vec![axis.into()]
    };
    axes.into_iter().map(|axis| seen(kind, axis, part, rules)).collect()
}

/// An axis as the image of a part has it: the frame of a mirror image has the opposite of the mirrored z axis.
fn seen(kind: JointKind, axis: Vector3<f64>, part: &Part, rules: &RuleSet) -> Vector3<f64> {
    if symmetry::is_reflected(rules, part.image) { kind.axis_in_mirror(axis.into()).into() } else { axis }
}

/// Where an actuator of so many segments, of a length in the mean, has its joints: distances from its base.
///
/// Each stands for an equal share of the length, in the middle of it, so that the row bends as an elastic
/// rod does, with an error of second order in the number of hinges. The segments at both ends are
/// therefore half as long as those between hinges.
pub(super) fn cuts(length: f64, count: usize) -> Vec<f64> {
    let hinges = count.saturating_sub(1);
    let share = length * count as f64 / hinges.max(1) as f64;
    (0..hinges).map(|hinge| share * (hinge as f64 + 0.5)).collect()
}
