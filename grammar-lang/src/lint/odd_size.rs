//! Parts that are larger than a room or thinner than a hair: mostly a wrong unit.

use crate::diagnostics::{Code, Diagnostic};
use crate::units::{self, Dimension};

use super::known::Known;

/// Sizes beyond these (m) are told.
const LEAST: f64 = 1e-4;
const MOST: f64 = 10.0;
/// Of a segment: an actuator is a row of them.
const MOST_OF_SEGMENT: f64 = 1.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let parts = ruleset.parts.iter().map(|(name, p)| (name, p.shape, p.span, MOST));
    let actuators = ruleset.actuators.iter().map(|(name, a)| (name, a.segment, a.span, MOST_OF_SEGMENT));
    for (name, shape, span, most) in parts.chain(actuators) {
        let sizes = shape.half_extents() * 2.0;
        let odd = sizes.iter().copied().find(|size| !(LEAST..=most).contains(size));
        if let Some(size) = odd {
            let than =
                if size > most { format!("longer than {most} m") } else { "thinner than 0.1 mm".to_owned() };
            let what = if most == MOST { "" } else { "a segment of " };
            findings.push(
                Diagnostic::new(Code::ODD_SIZE, span, format!("{what}`{name}` is {than}"))
                    .label(format!("one of its sizes is {}", units::shown(size, Dimension::LENGTH)))
                    .help("is the unit right?"),
            );
        }
    }
}
