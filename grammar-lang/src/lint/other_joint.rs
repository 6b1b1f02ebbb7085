//! Actuations and sensors that ask for what joints of another kind have: a slide has no bend, and a ball in its socket no angle.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Expr, ExprKind, JointKind, PartAttribute, Track};

use super::known::{Actuated, Known};

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for Actuated { kind, actuator, actuation, .. } in known.actuated() {
        for value in actuation.values() {
            value.any(&mut |asked| {
                if let Some(help) = lacks(asked, actuator.joint.kind)
                    && !actuator.params.contains_key(attribute(asked).map_or("", PartAttribute::text))
                    && told.insert((asked.span.file, asked.span.start))
                {
                    let attribute = attribute(asked).map_or("", PartAttribute::text);
                    findings.push(
                        Diagnostic::new(
                            Code::NO_VALUE,
                            asked.span,
                            format!("`{kind}` {}, so it has no `{attribute}`", actuator.joint.kind.does()),
                        )
                        .label("has no value")
                        .also(actuator.span, "this actuator")
                        .help(help),
                    );
                }
                false
            });
        }
    }
    sensors(known, findings);
}

/// Sensors of parts of which none has what is measured.
fn sensors(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for (name, sensor) in &ruleset.sensors {
        let Some(of) = &sensor.of else { continue };
        let parts = ruleset.parts.iter().map(|(kind, part)| (kind, part.joint.as_ref(), part.span));
        let rows = ruleset.actuators.iter().map(|(kind, row)| (kind, Some(&row.joint), row.span));
        let kinds: Vec<_> = parts.chain(rows).filter(|(kind, ..)| known.facts.belongs(kind, of)).collect();
        // What has a joint of another kind is told first: it is more likely to be meant.
        let Some((kind, joint, span)) = kinds.iter().find(|(_, joint, _)| joint.is_some()).or(kinds.first())
        else {
            continue;
        };
        sensor.value.any(&mut |asked| {
            let Some(track) = track(asked) else { return false };
            if kinds.iter().any(|(_, joint, _)| joint.is_some_and(|joint| track.is_of(joint.kind))) {
                return false;
            }
            let track = track.text();
            let (message, help) = match joint.map(|joint| joint.kind) {
                None => (
                    format!("`{kind}` has no joint, so it has no `{track}`"),
                    "measure a part that has a joint, or the motion of this part, as in `p.velocity at now`"
                        .to_owned(),
                ),
                Some(JointKind::Socket) => (
                    format!("`{kind}` turns about three axes, so it has no `{track}`"),
                    "measure the orientation of the part, as in `p.rotation at now`".to_owned(),
                ),
                Some(joint) => {
                    let have = match joint {
                        JointKind::Slide => "`distance` and `distance_rate`",
                        JointKind::Spin => "`speed`",
                        _ => "`angle` and `angle_rate`",
                    };
                    let does = joint.does();
                    (
                        format!("`{kind}` {does}, so it has no `{track}`"),
                        format!("a joint that {does} has {have}"),
                    )
                }
            };
            findings.push(
                Diagnostic::new(Code::NO_VALUE, asked.span, message)
                    .label(format!("`{name}` never has a value"))
                    .also(*span, "this kind")
                    .help(help),
            );
            true
        });
    }
}

/// What a sensor asks of the part itself that only some joints have.
fn track(expr: &Expr) -> Option<Track> {
    match &expr.kind {
        ExprKind::Attribute(of, Attribute::Track(track))
            if matches!(of.kind, ExprKind::Local(0)) && track.is_of_joints() =>
        {
            Some(*track)
        }
        _ => None,
    }
}

fn attribute(expr: &Expr) -> Option<PartAttribute> {
    match &expr.kind {
        ExprKind::Attribute(of, Attribute::Part(attribute)) if matches!(of.kind, ExprKind::Local(0)) => {
            Some(*attribute)
        }
        _ => None,
    }
}

/// What to ask instead, where an attribute of the actuator itself is one that its joint does not have.
fn lacks(expr: &Expr, joint: JointKind) -> Option<String> {
    let (turns, slides) = (
        ["least_bend", "greatest_bend", "neutral_bend"],
        ["least_distance", "greatest_distance", "neutral_distance"],
    );
    let have: &[&str] = match joint {
        JointKind::Bend | JointKind::Twist | JointKind::Socket => &turns,
        JointKind::Slide => &slides,
        JointKind::Spin => &["greatest_speed"],
    };
    let asked = attribute(expr)?;
    let of_joints = matches!(
        asked,
        PartAttribute::LeastBend
            | PartAttribute::GreatestBend
            | PartAttribute::LeastDistance
            | PartAttribute::GreatestDistance
            | PartAttribute::NeutralBend
            | PartAttribute::NeutralDistance
            | PartAttribute::GreatestSpeed
    );
    let names = have.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    (of_joints && !have.contains(&asked.text())).then(|| format!("a joint that {} has {names}", joint.does()))
}
