//! The row of segments that an actuator is: where its joints are, and about which axis they move.

use grammar_lang::ir::{self, RuleSet};
use nalgebra::Vector3;

use super::Part;

/// Held by its tip a row does the same: each segment nearer to the base moves against its parent.
pub(super) fn side(by_tip: bool) -> f64 {
    if by_tip { -1.0 } else { 1.0 }
}

/// The axis of a row's joints in its own frame, where what is nearer to the tip moves.
pub(super) fn axis_of(joint: ir::Joint, part: &Part, rules: &RuleSet) -> Vector3<f64> {
    let mut axis = Vector3::from(joint.axis);
    // The frame of a mirror image has the opposite of the mirrored z axis. A turn there is the mirror image of this one if it
    // goes the same way about z and the other way about x and y; a slide, if it goes the same way along x and y.
    if part.image > 0 && matches!(rules.symmetry, ir::Symmetry::Mirror(_)) {
        axis = match joint.kind {
            ir::JointKind::Slide => Vector3::new(axis.x, axis.y, -axis.z),
            ir::JointKind::Bend | ir::JointKind::Twist | ir::JointKind::Spin => {
                Vector3::new(-axis.x, -axis.y, axis.z)
            }
        };
    }
    axis
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
