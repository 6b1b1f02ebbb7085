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
    // Balls lie on one grid, and never overlap: what counts are the shapes that they fill.
    let body = if rules.lattice.is_some() { Body::new(design, rules) } else { Body::of_parts(design, rules) };
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

/// How far a part and the flat face that holds it reach into each other, because the port of either is tilted: as a way along the port
/// of the holder, m. A workshop cuts such an end to fit. Nothing where one does not hold the other, or both ports stand square on
/// their faces.
fn dug_in(design: &Design, holder: PartId, held: PartId) -> Option<parry3d_f64::math::Vector> {
    let part = design.parts.get(&held)?;
    let (_, port) = part.held_by.filter(|(id, _)| *id == holder)?;
    let holder = design.parts.get(&holder)?;
    let (facing, normal) = on_face(holder, port);
    let (own, end) = on_face(part, part.holding);
    let (facing, own) = (facing?, own?);
    let cosine = |facing: &Vector3<f64>, normal: Option<Vector3<f64>>| {
        let cos = normal.map_or(1.0, |normal| facing.dot(&normal));
        (cos >= libm::cos(MOST_TILT)).then_some(cos)
    };
    let (cos, own_cos) = (cosine(&facing, normal)?, cosine(&own, end)?);
    let sine = |cos: f64| if cos > 1.0 - 1e-6 { 0.0 } else { libm::sqrt(1.0 - cos * cos) };
    let half = match part.made.as_ref() {
        Made::Block(block) => block.form.half_extents(),
        Made::Actuator(row) => row.segment.half_extents(),
        Made::Cell(_) => return None,
    };
    // Across an axis at most: of what is round its radius, of a box its corner.
    let across = |axis: Vector3<f64>| {
        let across = half - half.component_mul(&axis.abs());
        if is_round(part) { across.max() } else { across.norm() }
    };
    // The end of the part meets an inclined face, or an edge of the part's own inclined end goes ahead.
    let way = across(own) * sine(cos) / cos + end.map_or(0.0, |end| across(end) * sine(own_cos));
    let along = holder.pose.rotation * facing * way;
    (way > 0.0).then(|| parry3d_f64::math::Vector::new(along.x, along.y, along.z))
}

/// Where a port of a part faces, and the normal of the flat face that it is on, if it is on one: in the frame of the part.
fn on_face(part: &super::Part, port: u8) -> (Option<Vector3<f64>>, Option<Vector3<f64>>) {
    let Some(frame) = ports(part).into_iter().nth(port as usize).map(|port| port.frame) else {
        return (None, None);
    };
    let facing = frame.rotation * Vector3::x();
    let normal = match part.made.as_ref() {
        Made::Block(block) => face(block.form, &frame.translation.vector, &facing),
        // The ends of a row are square.
        _ => None,
    };
    (Some(facing), normal)
}

fn is_round(part: &super::Part) -> bool {
    match part.made.as_ref() {
        Made::Block(block) => block.form.shape.is_round(),
        Made::Actuator(row) => row.segment.shape.is_round(),
        Made::Cell(_) => false,
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
    // What is in the middle of a thin part is on none of its two broad faces.
    let slack = |axis: usize| slack.min(0.5 * half[axis]);
    let on = flat.iter().filter(|axis| (at[**axis].abs() - half[**axis]).abs() <= slack(**axis));
    let normals = on.map(|axis| {
        let mut normal = Vector3::zeros();
        normal[*axis] = at[*axis].signum();
        normal
    });
    normals.max_by(|a, b| a.dot(facing).total_cmp(&b.dot(facing)))
}
