//! Rows that bend and are thicker than long: mostly the radius and the length of a cylinder that were exchanged.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::JointKind;
use crate::units::{Dimension, shown};

use super::instances::usual;
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let bends = known.ruleset.actuators.iter().filter(|(_, a)| a.joint.kind == JointKind::Bend);
    for (name, actuator) in bends {
        let fewest =
            actuator.params.get("segments").and_then(|p| p.domain).map_or(2.0, |(low, _)| low.max(2.0));
        let Some(made) = usual(known, actuator) else { continue };
        // A strip may be wider than long.
        let half = made.segment.half_extents();
        let (length, thickness) = (2.0 * half.x * fewest, 2.0 * half.y.min(half.z));
        if length < thickness {
            let shown = |x: f64| shown(x, Dimension::LENGTH);
            findings.push(
                Diagnostic::new(Code::UNUSUAL, actuator.span, format!("`{name}` may be thicker than it is long"))
                    .label(format!("{fewest} segments are {} long and {} thick", shown(length), shown(thickness)))
                    .help("a cylinder is written with its radius first, and then its length: `cylinder(9 mm, 2 cm)`"),
            );
        }
    }
}
