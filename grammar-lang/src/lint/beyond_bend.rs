//! Drives that ask an actuator for more than it bends.
//!
//! A drive is tried in the middle of what it varies, and at the ends of it, over two periods or
//! the whole motion, whichever is shorter: what is told certainly happens.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{Allowance, PartId, Reference, Scope, Value};
use crate::ir::{Actuation, Actuator, Attribute, JointKind, PartAttribute, Ty, Word};

use super::instances::usual;
use super::known::{Actuated, Known};

/// How far beyond its bend a drive may go, as a share of the bend: what is written in other units is rounded.
const CLOSE: f64 = 0.02;
/// The same at the ends of what it varies: a search may well try more than serves.
const FAR: f64 = 1.05;
/// A drive that takes more operations than this is not tried: a check must come to its end.
const MOST_OPERATIONS: u64 = 2_000_000;
/// At so many moments.
const MOMENTS: usize = 32;

/// An actuator that is driven at a time.
struct Driven<'k> {
    known: &'k Known<'k>,
    actuator: &'k Actuator,
    /// What the drive can ask of it.
    range: (f64, f64),
    time: f64,
}

impl Scope for Driven<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.known.ruleset)
    }
    fn word(&self, word: Word) -> Option<Value> {
        (word == Word::Time).then_some(Value::Number(self.time))
    }
    fn attribute(&self, _: Reference, attribute: &Attribute) -> Option<Value> {
        match attribute {
            Attribute::Part(PartAttribute::Image | PartAttribute::Turn) => Some(Value::Number(0.0)),
            Attribute::Part(PartAttribute::Depth) => Some(Value::Number(1.0)),
            Attribute::Part(PartAttribute::OwnImage) => Some(Value::Bool(false)),
            Attribute::Part(PartAttribute::LeastBend | PartAttribute::LeastDistance) => {
                Some(Value::Number(self.range.0))
            }
            Attribute::Part(PartAttribute::GreatestBend | PartAttribute::GreatestDistance) => {
                Some(Value::Number(self.range.1))
            }
            Attribute::Part(PartAttribute::GreatestSpeed) => Some(Value::Number(self.range.1)),
            Attribute::Param(name) => {
                let default = self.actuator.params.get(name)?.default.as_ref()?;
                self.known.value(default).ok()
            }
            _ => None,
        }
    }
}

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for actuated in known.actuated() {
        let Actuated { kind, actuator, actuation, .. } = actuated;
        let joint = actuator.joint.kind;
        // What a closed loop asks for depends on what happens to the body.
        if actuation.is_closed_loop() {
            continue;
        }
        if actuation.drive.ty != Ty::Quantity(joint.driven()) {
            continue;
        }
        let Some((low, high)) = usual(known, actuator).map(|made| made.driven_range()) else { continue };
        let beyond = |(share, slack): (f64, f64)| {
            let slack = slack * (high - low);
            let (least, most) = range(known, &actuated, (low, high), share)?;
            let farthest = if most - high >= low - least { most } else { least };
            (least < low - slack || most > high + slack).then_some((share, farthest))
        };
        if let Some((share, beyond)) = [(0.5, CLOSE), (0.0, FAR), (1.0, FAR)].into_iter().find_map(beyond)
            && told.insert(actuation.drive.span)
        {
            let tenths = |x: f64| (x * 10.0).round() / 10.0;
            let shown = |x: f64| match joint {
                JointKind::Bend | JointKind::Twist | JointKind::Socket => {
                    format!("{} deg", tenths(x.to_degrees()))
                }
                JointKind::Spin => format!("{} deg/s", tenths(x.to_degrees())),
                JointKind::Slide => format!("{} mm", tenths(x * 1e3)),
            };
            let field = if joint == JointKind::Spin { joint.speed_field() } else { joint.range() };
            findings.push(
                Diagnostic::new(
                    Code::BEYOND_BEND,
                    actuation.drive.span,
                    format!("this drive asks `{kind}` to {} to {}", verb(joint), shown(beyond)),
                )
                .label(format!(
                    "beyond its {field} of {} .. {}{}",
                    shown(low),
                    shown(high),
                    tried(actuation, share)
                ))
                .also(actuator.span, format!("it stops at the ends of `{field}`"))
                .help(format!("narrow what the drive varies, or widen `{field}` if the actuator can do it")),
            );
        }
    }
}

/// Where in their domains the variables of an actuation were tried.
fn tried(actuation: &Actuation, share: f64) -> &'static str {
    match share {
        _ if actuation.variables.is_empty() => "",
        0.0 => ", with all varied values at the low ends of their domains",
        1.0 => ", with all varied values at the high ends of their domains",
        _ => ", with all varied values in the middle of their domains",
    }
}

/// What a joint is asked to do, before how far.
fn verb(joint: JointKind) -> &'static str {
    match joint {
        JointKind::Spin => "speed up",
        JointKind::Bend | JointKind::Twist | JointKind::Slide | JointKind::Socket => joint.text(),
    }
}

/// The least and the greatest that a drive asks for, where all that it varies is at this share of its domain.
fn range(known: &Known<'_>, actuated: &Actuated<'_>, able: (f64, f64), share: f64) -> Option<(f64, f64)> {
    let &Actuated { task, actuator, actuation, .. } = actuated;
    let allowance = Allowance::of(MOST_OPERATIONS);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut locals = vec![Value::Reference(Reference::Part(PartId::from_number(1)))];
    let mut period = None;
    for variable in &actuation.variables {
        let (low, high) = variable.domain;
        let number = low + share * (high - low);
        let one = match &variable.ty {
            Ty::Bool => Value::Bool(number > 0.5),
            Ty::Count => Value::Number(libm::round(number)),
            _ => Value::Number(number),
        };
        if variable.name == "period" {
            period = Some(number);
        }
        locals.push(match variable.size {
            Some(n) => Value::List(vec![one; n].into()),
            None => one,
        });
    }
    let still = locals.len();
    for moment in 0..MOMENTS {
        locals.truncate(still);
        let span = (2.0 * period.unwrap_or(4.0)).min(task.model.duration);
        let time = span * moment as f64 / MOMENTS as f64;
        let driven = Driven { known, actuator, range: able, time };
        for (_, value) in actuation.lets.iter().chain(&actuation.moving) {
            let value = allowance.evaluate(value, &driven, &mut locals).ok()?;
            locals.push(value);
        }
        let angle = allowance.evaluate(&actuation.drive, &driven, &mut locals).ok()?.as_number()?;
        least = least.min(angle);
        most = most.max(angle);
    }
    Some((least, most))
}
