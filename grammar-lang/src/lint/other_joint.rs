//! Actuations that ask their actuators for what joints of another kind have: a slide has no bend.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Expr, ExprKind, JointKind, PartAttribute};

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
                            format!("`{kind}` {} and has no `{attribute}`", actuator.joint.kind.does()),
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
    let (turns, slides) = (["least_bend", "greatest_bend"], ["least_distance", "greatest_distance"]);
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
            | PartAttribute::GreatestSpeed
    );
    let names = have.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" and ");
    (of_joints && !have.contains(&asked.text())).then(|| format!("what {} has {names}", joint.does()))
}
