//! Cells that do not bear their own weight, and fillings that are too coarse to bend.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{JointKind, Method};
use crate::units::{Dimension, shown};

use super::instances::usual;
use super::known::Known;

/// A spring that the weight of a single ball shortens by this share of its length bears no body.
const MOST: f64 = 0.2;

/// So many balls must fit across an actuator.
const FEWEST: f64 = 2.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    too_coarse(known, findings);
    let Some(lattice) = &known.ruleset.lattice else { return };
    let cell = &lattice.cell;
    let number = |e| known.value(e).ok()?.as_number();
    let Some((mass, stiffness)) = number(&cell.mass).zip(number(&cell.stiffness)) else { return };
    let gravity = known.ruleset.tasks.values().map(|task| task.model.gravity).fold(0.0, f64::max);
    let way = mass * gravity / stiffness;
    if way > MOST * cell.spacing {
        let length = |x: f64| shown(x, Dimension::LENGTH);
        findings.push(
            Diagnostic::new(
                Code::UNUSUAL,
                cell.stiffness.span,
                format!("the springs of `{}` are too soft for its own mass", lattice.kind),
            )
            .label(format!(
                "the weight of one ball, {}, shortens a spring of {} by {}",
                shown(mass * gravity, Dimension::FORCE),
                length(cell.spacing),
                length(way)
            ))
            .help("is the unit right? A body of silicone has some N/mm"),
        );
    }
}

/// Fillings of which fewer than two balls fit across an actuator: a single row of balls does not bend by strain.
fn too_coarse(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut fillings = ruleset.tasks.values().filter_map(|task| match task.model.method {
        Method::Balls(filling) => filling,
        _ => None,
    });
    let Some(filling) = fillings.next() else { return };
    for (name, actuator) in ruleset.actuators.iter().filter(|(_, a)| a.joint.kind == JointKind::Bend) {
        let Some(made) = usual(known, actuator) else { continue };
        let half = made.segment.half_extents();
        let across = 2.0 * half.y.min(half.z);
        if across < FEWEST * filling.spacing {
            let length = |x: f64| shown(x, Dimension::LENGTH);
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    actuator.span,
                    format!("the balls of the filling are too large for `{name}`"),
                )
                .label(format!(
                    "{} across, and the balls are {} apart",
                    length(across),
                    length(filling.spacing)
                ))
                .help(format!(
                    "a row bends if two balls or more fit across it: `spacing = {}`",
                    length(across / 3.0)
                )),
            );
        }
    }
}
