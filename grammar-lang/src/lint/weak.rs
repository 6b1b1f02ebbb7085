//! Actuators that cannot hold their own segments, even if they have as few as they may, or whose hinges never push with all of their
//! torque, and cores that no actuator moves.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{Actuator, ExprKind, JointKind, Kind};
use crate::units::{Dimension, shown};

use super::instances::{made, usual};
use super::known::Known;

/// Actuators whose force is less than this share of what the core weighs do not move it, even if there are dozens of them.
const MOVES: f64 = 0.02;
/// A torque of which a hinge reaches less than this share is not that of the actuator.
const REACHED: f64 = 0.9;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    too_weak(known, findings);
    never_reached(known, findings);
    findings.extend(too_heavy(known));
}

fn too_weak(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let gravity = ruleset.tasks.values().map(|task| task.model.gravity).fold(0.0, f64::max);
    // A twist need not hold what hangs on it, and the weight does not load it with a torque.
    let bends = |actuator: &&Actuator| actuator.joint.kind == JointKind::Bend;
    for (name, actuator) in ruleset.actuators.iter().filter(|(_, actuator)| bends(actuator)) {
        // Most of all it loads a hinge that lies level; one that stands upright need not hold it.
        if actuator.joint.axis.fixed().is_some_and(|axis| axis[2].abs() < axis[1].abs()) {
            continue;
        }
        let fewest =
            actuator.params.get("segments").and_then(|p| p.domain).map_or(2.0, |(low, _)| low.max(2.0));
        // What is beyond the first hinge: each stands in the middle of its share of the row. Weak is what is so whatever its
        // other parameters are.
        let beyond = 1.0 - 0.5 / (fewest - 1.0);
        let kind = Kind::Actuator(actuator);
        let margins = made(known, kind).filter_map(|(_, made)| match made {
            Ok(Made::Actuator(made)) => {
                let arm = made.segment.half_extents().x;
                let row = fewest * beyond;
                Some((made.motor.as_ref()?.effort, made.mass * gravity * arm * row * row))
            }
            _ => None,
        });
        let strongest = margins.max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
        if let Some((held, weight)) = strongest
            && held < weight
        {
            let torque = |x: f64| shown(x, Dimension::TORQUE);
            findings.push(
                Diagnostic::new(
                    Code::WEAK,
                    actuator.span,
                    format!("`{name}` is too weak to hold its own segments"),
                )
                .label(format!(
                    "`torque` is {}; a level row of {fewest} segments loads its first hinge with {}",
                    torque(held),
                    torque(weight)
                ))
                .help("check the units of `torque`, `mass` and `segment`"),
            );
        }
    }
}

/// Actuators whose hinges are so soft that they do not push with their torque even where the row is held straight and driven to the
/// end of its bend: what was measured of them does not go together.
fn never_reached(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for (name, actuator) in ruleset.actuators.iter().filter(|(_, a)| a.joint.kind == JointKind::Bend) {
        // As its parameters are where no rule says otherwise: with fewer segments each hinge bends more.
        let number = || known.value(actuator.params.get("segments")?.default.as_ref()?).ok()?.as_number();
        let Some((made, segments)) = usual(known, actuator).zip(number()) else { continue };
        let Some(torque) = made.motor.as_ref().map(|motor| motor.effort) else { continue };
        let (low, high) = made.driven_range();
        let pushes = made.joint.stiffness * (high - low) / (segments - 1.0).max(1.0);
        if pushes < REACHED * torque {
            let shown = |x: f64| shown(x, Dimension::TORQUE);
            findings.push(
                Diagnostic::new(Code::WEAK, actuator.span, format!("`{name}` never reaches its `torque`"))
                    .label(format!(
                        "`torque` is {}; with {segments} segments that are held at one end of the bend and driven to the other, a hinge pushes with {}",
                        shown(torque),
                        shown(pushes)
                    ))
                    .help("a hinge pushes with `stiffness` times its distance to the target: if torque and bend were measured, write `stiffness = torque / (bend / (segments - 1))`"),
            );
        }
    }
}

/// The core, if it is so heavy that none of the actuators moves it.
fn too_heavy(known: &Known<'_>) -> Option<Diagnostic> {
    let ruleset = known.ruleset;
    let gravity = ruleset.tasks.values().map(|task| task.model.gravity).fold(f64::INFINITY, f64::min);
    let core = ruleset.begin.first().filter(|placed| placed.on.is_none())?;
    let ExprKind::Kind(name, _) = &core.what.kind else { return None };
    let part = ruleset.parts.get(name)?;
    let masses = made(known, Kind::Block(part)).map(|(_, made)| match made {
        Ok(Made::Block(block)) => Some(block.mass),
        _ => None,
    });
    let lightest = masses.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::min)?;
    let mut strongest: f64 = 0.0;
    for actuator in ruleset.actuators.values().filter(|actuator| actuator.motor.is_some()) {
        // A wheel is as strong as it is small, and a row of few segments as it is short.
        if actuator.joint.kind == JointKind::Spin {
            return None;
        }
        for (_, made) in made(known, Kind::Actuator(actuator)) {
            let Ok(Made::Actuator(made)) = made else { return None };
            let effort = made.motor.as_ref()?.effort;
            let length = 2.0 * made.segment.half_extents().x;
            strongest =
                strongest.max(if actuator.joint.kind == JointKind::Slide { effort } else { effort / length });
        }
    }
    let weight = lightest * gravity;
    (strongest > 0.0 && strongest < MOVES * weight).then(|| {
        let force = |x: f64| shown((x * 1e3).round() / 1e3, Dimension::FORCE);
        Diagnostic::new(Code::WEAK, core.span, format!("no actuator is strong enough to move the core, `{name}`"))
            .label(format!("it weighs {}", force(weight)))
            .help(format!(
                "the strongest actuator pushes with {} at the end of its first segment: check the units of `mass`, `density`, `shape` and `torque`",
                force(strongest)
            ))
    })
}
