//! Wheels that never touch the ground, and wheels that do not turn about their own axis.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::source::Span;

use super::{Trial, Trials, odd};
use crate::design::assembly::{Dof, JointKind, Shape};

/// So many wheels are looked at, at least.
const ENOUGH: usize = 4;
/// The radius of a wheel is so many times as large as half of its height, or more; that of a flat disk is larger.
const SHORT: f64 = 0.75;
const FLAT: f64 = 1.5;
/// An axle is across a disk if the cosine of the angle to its axis is less.
const ACROSS: f64 = 0.1;
/// A disk turns about a point that is further from its middle than this share of its radius: it limps.
const BESIDE: f64 = 0.25;

/// What was seen of a kind of wheel.
#[derive(Default)]
struct Seen {
    wheels: usize,
    touched: usize,
    across: usize,
    beside: usize,
}

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let mut kinds: BTreeMap<(String, Span), Seen> = BTreeMap::new();
    for (trial, _, motion) in trials.motions() {
        let slid = motion.sliding();
        let elements = &trial.drive.candidate().body.assembly.elements;
        for (element, dof) in wheels(trial) {
            let (Some((kind, span)), Some(slid)) = (trial.kind_of(element), slid.get(element)) else {
                continue;
            };
            let Shape::Cylinder { radius, .. } = elements[element].shape else { continue };
            let pose = &elements[element].pose;
            let own = pose.rotation * nalgebra::Vector3::x();
            let arm = pose.translation.vector - dof.anchor.coords;
            let beside = (arm - dof.axis.into_inner() * arm.dot(&dof.axis)).norm();
            let seen = kinds.entry((kind.to_owned(), span)).or_default();
            let is_across = is_flat(elements[element].shape, FLAT) && own.dot(&dof.axis).abs() < ACROSS;
            seen.wheels += 1;
            seen.touched += usize::from(slid.touching > 0.0);
            seen.across += usize::from(is_across);
            seen.beside += usize::from(!is_across && beside > BESIDE * radius);
        }
    }
    let told = |((kind, span), seen): (&(String, Span), &Seen)| {
        if seen.wheels < ENOUGH {
            None
        } else if seen.across == seen.wheels {
            Some(
                odd(*span, format!("the disk `{kind}` turns about its diameter"))
                    .label("it flaps like a coin on its edge, and does not roll")
                    .help("hold the disk at a port in the middle of its flat side, by a joint that turns about the axis of this port (`spin about x`)"),
            )
        } else if seen.beside == seen.wheels {
            Some(
                odd(*span, format!("the disk `{kind}` does not turn about its middle"))
                    .label("a wheel held there goes up and down with each turn")
                    .help("hold the disk at a port in the middle of its flat side"),
            )
        } else if seen.touched == 0 {
            Some(
                odd(*span, format!("no wheel `{kind}` ever touches the ground"))
                    .label(format!("{} wheels in short motions", seen.wheels))
                    .help("make the wheel larger, or hold it lower; for a flywheel, write `allow W0746 because \"...\"`"),
            )
        } else {
            None
        }
    };
    kinds.iter().filter_map(told).collect()
}

/// The disks that something turns without end, each with the joint about which it turns: they are moved by it, or sit firmly on what is.
fn wheels<'a>(trial: &'a Trial<'_>) -> Vec<(usize, &'a Dof)> {
    let assembly = &trial.drive.candidate().body.assembly;
    // Joints come after those of what they hang on.
    let mut turned_by: Vec<Option<&Dof>> = vec![None; assembly.elements.len()];
    for joint in &assembly.joints {
        turned_by[joint.child] = match &joint.kind {
            JointKind::Dof(dof) => Some(dof).filter(|dof| dof.is_spun()),
            JointKind::Rigid => turned_by[joint.parent],
            JointKind::Socket(_) => None,
        };
    }
    // The segments of a motor are no wheels.
    let candidate = trial.drive.candidate();
    let is_row = |element: usize| {
        let part = candidate.body.parts_of_elements.get(element);
        part.is_some_and(|part| candidate.body.actuators.contains(part))
    };
    let is_disk = |element: usize| is_flat(assembly.elements[element].shape, SHORT) && !is_row(element);
    turned_by
        .iter()
        .enumerate()
        .filter_map(|(element, dof)| Some((element, (*dof)?)))
        .filter(|(e, _)| is_disk(*e))
        .collect()
}

fn is_flat(shape: Shape, times: f64) -> bool {
    matches!(shape, Shape::Cylinder { radius, half_length } if radius > times * half_length)
}
