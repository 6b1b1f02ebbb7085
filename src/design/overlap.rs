//! Whether parts overlap.

use grammar_lang::eval::Made;
use grammar_lang::ir::{Form, RuleSet};
use nalgebra::Vector3;
use parry3d_f64::query;

use super::assembly::solid::{Solid, pose};
use super::assembly::{Shape, TOUCHING};
use super::port::ports;
use super::{Body, Design, PartId};

/// Two parts of a design that overlap, if any do.
pub(super) fn first(design: &Design, rules: &RuleSet) -> Option<(PartId, PartId)> {
    let body = Body::new(design, rules);
    let solids: Vec<_> = body
        .assembly
        .elements
        .iter()
        .zip(&body.parts_of_elements)
        .map(|(e, part)| {
            (
                Solid::new(&e.shape, TOUCHING),
                pose(&e.pose, &e.shape),
                e.shape.reach(),
                e.pose.translation.vector,
                *part,
            )
        })
        .collect();
    for (i, (a, pose_a, reach_a, centre_a, part_a)) in solids.iter().enumerate() {
        for (b, pose_b, reach_b, centre_b, part_b) in solids.iter().skip(i + 1) {
            if part_a == part_b || (centre_a - centre_b).norm() > reach_a + reach_b {
                continue;
            }
            let (mut pose_a, mut pose_b) = (*pose_a, *pose_b);
            if let Some(room) = dug_in(design, *part_a, *part_b) {
                pose_b.translation += room;
            } else if let Some(room) = dug_in(design, *part_b, *part_a) {
                pose_a.translation += room;
            }
            // A pair that the library cannot judge counts as overlapping.
            let judged = query::intersection_test(&pose_a, a.shape(), &pose_b, b.shape());
            if judged.map_or(true, |s| s.intersecting) {
                return Some((*part_a, *part_b));
            }
        }
    }
    None
}

/// At ports that are tilted further than this against the face that they are on, what hangs there must have room of its own.
const MOST_TILT: f64 = std::f64::consts::FRAC_PI_3;

/// How far a part reaches into the flat face that holds it, because the port is tilted: as a way along the port, m. A workshop cuts such
/// an end to fit. Nothing where one does not hold the other, or the port stands square on its face.
fn dug_in(design: &Design, holder: PartId, held: PartId) -> Option<parry3d_f64::math::Vector> {
    let part = design.parts.get(&held)?;
    let (_, port) = part.held_by.filter(|(id, _)| *id == holder)?;
    let holder = design.parts.get(&holder)?;
    let Made::Block(block) = holder.made.as_deref()? else { return None };
    let frame = ports(holder).into_iter().nth(port as usize)?.frame;
    let facing = frame.rotation * Vector3::x();
    let normal = face(block.form, &frame.translation.vector, &facing)?;
    let cos = facing.dot(&normal);
    if cos > 1.0 - 1e-6 || cos < libm::cos(MOST_TILT) {
        return None;
    }
    let own = ports(part).into_iter().nth(part.holding as usize)?.frame.rotation * Vector3::x();
    let half = match part.made.as_deref()? {
        Made::Block(block) => block.form.half_extents(),
        Made::Actuator(row) => row.segment.half_extents(),
    };
    // Across the port at most: of what is round its radius, of a box its corner.
    let across = half - half.component_mul(&own.abs());
    let across = if is_round(part) { across.max() } else { across.norm() };
    let way = holder.pose.rotation * facing * (across * libm::sqrt(1.0 - cos * cos) / cos);
    Some(parry3d_f64::math::Vector::new(way.x, way.y, way.z))
}

fn is_round(part: &super::Part) -> bool {
    match part.made.as_deref() {
        Some(Made::Block(block)) => block.form.shape.is_round(),
        Some(Made::Actuator(row)) => row.segment.shape.is_round(),
        None => false,
    }
}

/// The normal of the flat face of a part that a port lies on, in the frame of the part; of several, that in which the port faces most.
fn face(form: Form, at: &Vector3<f64>, facing: &Vector3<f64>) -> Option<Vector3<f64>> {
    let half = form.half_extents();
    let flat: &[usize] = match form.shape {
        Shape::Box { .. } => &[0, 1, 2],
        Shape::Cylinder { .. } if form.stands => &[1],
        Shape::Cylinder { .. } => &[0],
        Shape::Ball { .. } | Shape::Capsule { .. } => &[],
    };
    let slack = 0.05 * form.shape.longest() + 1e-3;
    let on = flat.iter().filter(|axis| (at[**axis].abs() - half[**axis]).abs() <= slack);
    let normals = on.map(|axis| {
        let mut normal = Vector3::zeros();
        normal[*axis] = at[*axis].signum();
        normal
    });
    normals.max_by(|a, b| a.dot(facing).total_cmp(&b.dot(facing)))
}
