//! Fields that read parameters, and are far from what robots have for some of them. Fields that read none are looked at where they
//! are declared.

use nalgebra::Point3;

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{Actuator, Form, JointKind, Kind, Prototype, Speed};
use crate::source::Span;
use crate::types::{USUAL, Usual};
use crate::units;

use super::instances::{Given, made, told};
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    let parts = rules.parts.iter().map(|(name, part)| (name, Kind::Block(part)));
    let actuators = rules.actuators.iter().map(|(name, actuator)| (name, Kind::Actuator(actuator)));
    for (name, kind) in parts.chain(actuators) {
        let weight = match kind {
            Kind::Block(part) => Some(&part.mass),
            Kind::Actuator(actuator) => Some(&actuator.mass),
            Kind::Cell(_) => None,
        };
        let one_mass = weight.is_some_and(|own| own.field() == "mass" && own.varies().is_none());
        for (field, expr) in kind.varying() {
            // What weighs the same in every size is told where its size varies.
            if !one_mass && matches!(field, "shape" | "segment") {
                continue;
            }
            let odd = made(known, kind).find_map(|(given, made)| {
                let (value, usual) = unusual(field, &made.ok()?, joint_of(kind))?;
                Some((given, value, usual))
            });
            if let Some((given, value, usual)) = odd {
                findings.push(report(known, (name, kind, &given), expr.span, value, usual));
            }
        }
        if let Some(stray) = stray(known, name, kind) {
            findings.push(stray);
        }
    }
    findings.extend(rules.actuators.iter().filter_map(|(name, actuator)| short_table(known, name, actuator)));
    findings.extend(rules.prototypes.iter().filter_map(|(name, prototype)| far_apart(name, prototype)));
}

/// A table of speeds that covers less than this share of what an actuator bends has the wrong unit.
const COVERED: f64 = 0.25;

/// A table of speeds by bend that covers hardly any of the bend.
fn short_table(known: &Known<'_>, name: &str, actuator: &Actuator) -> Option<Diagnostic> {
    let joint = actuator.joint.kind;
    let (covered, range) = made(known, Kind::Actuator(actuator)).find_map(|(_, made)| {
        let Ok(Made::Actuator(own)) = made else { return None };
        let (low, high) = own.joint.range?;
        let Speed::ByBend(table) = &own.motor.as_ref()?.speed else { return None };
        let (first, last) = table.domain();
        let covered = (last.min(high) - first.max(low)).max(0.0);
        (covered < COVERED * (high - low)).then_some(((first, last), (low, high)))
    })?;
    let shown = |(low, high)| {
        let end = |x: f64| units::shown(x, joint.driven());
        format!("{} .. {}", end(low), end(high))
    };
    Some(
        Diagnostic::new(
            Code::UNUSUAL,
            actuator.span,
            format!("the table `{}` of `{name}` covers little of its range", joint.speed_field()),
        )
        .label(format!(
            "the table goes from {}, the range is {}",
            shown(covered).replace(" .. ", " to "),
            shown(range)
        ))
        .help("outside the table the speed stays what it is at its end: is the unit of the table right?"),
    )
}

/// A robot is no more than this many times as fast as it was simulated, and no slower than this share of it.
const FASTER: f64 = 10.0;
const SLOWER: f64 = 1e-3;

/// A prototype whose two speeds are so far apart that one of them has another unit.
fn far_apart(name: &str, prototype: &Prototype) -> Option<Diagnostic> {
    let ratio = prototype.measured / prototype.simulated;
    let speed =
        |x: f64| units::shown(x, units::Dimension::LENGTH.over(units::Dimension::TIME).unwrap_or_default());
    (!(SLOWER..=FASTER).contains(&ratio)).then(|| {
        Diagnostic::new(
            Code::UNUSUAL,
            prototype.span,
            format!("the speeds of the prototype `{name}` are far apart"),
        )
        .label(format!("{} simulated, {} measured", speed(prototype.simulated), speed(prototype.measured)))
        .help("are both units right?")
    })
}

/// The value of a field of one part, in SI units, and what is usual, where it is not.
fn unusual(field: &str, made: &Made, joint: JointKind) -> Option<(f64, &'static Usual)> {
    let density = |mass: f64, form: &Form| mass / form.shape.volume();
    let (of, field, value) = match (made, field) {
        (Made::Block(block), "shape" | "mass" | "density") => {
            ("a part", "density", density(block.mass, &block.form))
        }
        (Made::Block(block), "friction") => ("a part", "friction", block.friction),
        (Made::Actuator(own), "segment" | "mass" | "density") => {
            ("an actuator", "density", density(own.mass, &own.segment))
        }
        (Made::Actuator(own), "friction") => ("an actuator", "friction", own.friction),
        (Made::Actuator(own), "torque" | "effort") => {
            (row(joint), joint.effort_field(), own.motor.as_ref()?.effort)
        }
        (Made::Actuator(own), "relaxing_speed") => {
            (row(joint), "relaxing_speed", own.motor.as_ref()?.relaxing_speed.most())
        }
        (Made::Actuator(own), _) if field == joint.speed_field() => {
            (row(joint), joint.speed_field(), own.motor.as_ref()?.speed.most())
        }
        (Made::Actuator(own), _) if field == joint.range() => {
            let (low, high) = own.joint.range?;
            (row(joint), joint.range(), if high >= -low { high } else { low })
        }
        (Made::Actuator(own), "stiffness") => (row(joint), "stiffness", own.joint.stiffness),
        _ => return None,
    };
    let usual = USUAL.iter().find(|usual| (usual.of, usual.field) == (of, field))?;
    let factor = factor(usual);
    let slack = 1e-9;
    let within = usual.least * factor * (1.0 - slack)..=usual.most * factor * (1.0 + slack);
    (!within.contains(&value) && !usual.is_meant(value)).then_some((value, usual))
}

/// How the joints of a kind move; a part that hangs on none is as if it bent.
fn joint_of(kind: Kind<'_>) -> JointKind {
    match kind {
        Kind::Actuator(actuator) => actuator.joint.kind,
        Kind::Block(part) => part.joint.as_ref().map_or(JointKind::Bend, |joint| joint.kind),
        Kind::Cell(_) => JointKind::Bend,
    }
}

/// What a row with such joints is called in the table.
fn row(joint: JointKind) -> &'static str {
    match joint {
        JointKind::Bend | JointKind::Socket => "an actuator",
        JointKind::Twist => "an actuator that twists",
        JointKind::Slide => "an actuator that slides",
        JointKind::Spin => "an actuator that spins",
    }
}

/// How many SI units the unit of a row is.
fn factor(usual: &Usual) -> f64 {
    units::parse(usual.unit).map_or(1.0, |unit| unit.factor)
}

fn report(
    known: &Known<'_>,
    (name, kind, given): (&str, Kind<'_>, &Given),
    place: Span,
    value: f64,
    usual: &Usual,
) -> Diagnostic {
    let field = usual.field;
    let unit = if usual.unit.is_empty() { String::new() } else { format!(" {}", usual.unit) };
    let shown = units::shown(((value / factor(usual)) * 1e4).round() / 1e4, units::Dimension::NUMBER);
    let with = told(known, kind, given);
    Diagnostic::new(
        Code::UNUSUAL,
        place,
        format!("the {field} of a `{name}` with {with} is {shown}{unit}, outside the usual range for robots"),
    )
    .label(format!("usual: {} .. {}{unit}, between {}", usual.least, usual.most, usual.ends))
    .help("narrow the domain of the parameter, or check the unit")
}

/// A port that lies off its part for some parameters.
fn stray(known: &Known<'_>, name: &str, kind: Kind<'_>) -> Option<Diagnostic> {
    let Kind::Block(declared) = kind else { return None };
    let (given, port) = made(known, kind).find_map(|(given, made)| {
        let Ok(Made::Block(block)) = made else { return None };
        let slack = 0.05 * block.form.shape.longest() + 1e-3;
        let off = block.ports.iter().position(|port| {
            let at = Point3::from(port.at);
            let own = if block.form.stands { Point3::new(at.y, at.x, at.z) } else { at };
            !block.form.shape.holds(&own, slack)
        })?;
        Some((given, off))
    })?;
    let port = declared.ports.get(port)?;
    // Where neither reads a parameter it has been reported.
    let place = port.at.varies().or_else(|| declared.shape.varies())?.span;
    let with = told(known, kind, &given);
    let finding = Diagnostic::new(
        Code::STRAY_PORT,
        place,
        format!("the port `{}` of a `{name}` with {with} lies off its part", port.name),
    );
    Some(finding.label("outside of the shape").help(
        "let the place of the port follow from the same parameters as the shape, or narrow their domains",
    ))
}
