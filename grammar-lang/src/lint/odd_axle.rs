//! Wheels that turn about their diameter: a disk whose axle is not its own axis.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{JointKind, Kind};
use crate::shape::Shape;

use super::instances::made;
use super::known::Known;

/// An axle is across a disk if the cosine of the angle to its axis is less.
const ACROSS: f64 = 0.1;
/// The radius of a disk is so many times as large as half of its height, or more.
const FLAT: f64 = 1.5;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, part) in &known.ruleset.parts {
        let across = made(known, Kind::Block(part)).any(|(_, made)| {
            let Ok(Made::Block(block)) = made else { return false };
            let Some(joint) = block.joint.filter(|joint| joint.kind == JointKind::Spin) else { return false };
            let Shape::Cylinder { radius, half_length } = block.form.shape else { return false };
            // The axis of a disk is the y axis of the part.
            let own = if block.form.stands { 1 } else { 0 };
            radius > FLAT * half_length && joint.axis[own].abs() < ACROSS
        });
        if across {
            findings.push(
                Diagnostic::new(
                    Code::POINTLESS,
                    part.span,
                    format!("the disk `{name}` turns about its diameter"),
                )
                .label("it flaps like a coin on its edge, and does not roll")
                .help("a wheel turns about its own axis: write `joint = spin about y passive` for a `disk`"),
            );
        }
    }
}
