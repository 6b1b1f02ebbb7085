//! Cells that do not bear their own weight.

use crate::diagnostics::{Code, Diagnostic};
use crate::units::{Dimension, shown};

use super::known::Known;

/// A spring that the weight of a single ball shortens by this share of its length bears no body.
const MOST: f64 = 0.2;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
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
