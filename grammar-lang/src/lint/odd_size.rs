//! Parts that are larger than a room or thinner than a hair: mostly a wrong unit.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::Kind;
use crate::units::{self, Dimension};

use super::instances::{made, told};
use super::known::Known;

/// Sizes beyond these (m) are told.
const LEAST: f64 = 1e-4;
const MOST: f64 = 10.0;
/// A part that is so many times as long as it is thin is told: a sheet of paper is 3000, a ruler 300.
const LONG: f64 = 500.0;
/// The same of a segment.
const LONG_OF_SEGMENT: f64 = 50.0;
/// Of a segment: an actuator is a row of them.
const MOST_OF_SEGMENT: f64 = 1.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let parts = ruleset.parts.iter().map(|(name, p)| (name, Kind::Block(p), p.span, MOST));
    let actuators =
        ruleset.actuators.iter().map(|(name, a)| (name, Kind::Actuator(a), a.span, MOST_OF_SEGMENT));
    for (name, kind, span, most) in parts.chain(actuators) {
        let odd = made(known, kind).find_map(|(given, made)| {
            let form = match made.ok()? {
                Made::Block(block) => block.form,
                Made::Actuator(actuator) => actuator.segment,
                Made::Cell(_) => return None,
            };
            let sizes = form.half_extents() * 2.0;
            let odd = sizes.iter().copied().find(|size| !(LEAST..=most).contains(size));
            let long = if most == MOST { LONG } else { LONG_OF_SEGMENT };
            let ratio = sizes.max() / sizes.min();
            (odd.is_some() || ratio > long).then_some((given, odd.unwrap_or(sizes.max()), ratio))
        });
        if let Some((given, size, ratio)) = odd {
            let than = if size > most {
                format!("longer than {most} m")
            } else if size < LEAST {
                "thinner than 0.1 mm".to_owned()
            } else {
                format!("{ratio:.0} times as large in one direction as in another")
            };
            let what = if most == MOST { "" } else { "a segment of " };
            let with = told(known, kind, &given);
            let with = if with.is_empty() { with } else { format!(" with {with}") };
            findings.push(
                Diagnostic::new(Code::ODD_SIZE, span, format!("{what}`{name}`{with} is {than}"))
                    .label(format!("one of its sizes is {}", units::shown(size, Dimension::LENGTH)))
                    .help("is the unit right?"),
            );
        }
    }
}
