//! A hash of a body that ignores how it was derived.

use grammar_lang::eval::{Made, Value};
use nalgebra::Vector3;
use sha2::{Digest, Sha256};

use super::assembly::Shape;
use super::{Design, Part, PartId};

/// Places and directions are compared on this grid (m, or parts of one).
const GRID: f64 = 1e-6;

fn snap(x: f64) -> i64 {
    libm::round(x / GRID) as i64
}

fn direction(v: Vector3<f64>) -> [i64; 3] {
    // Coarser than places: directions are products of many rotations.
    [v.x, v.y, v.z].map(|x| libm::round(x * 1e4) as i64)
}

/// A direction without its sign.
fn line(v: Vector3<f64>) -> [i64; 3] {
    let d = direction(v);
    let negative = d.iter().find(|x| **x != 0).is_some_and(|x| *x < 0);
    if negative { d.map(|x| -x) } else { d }
}

/// In which order the parameters of a part count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// By their names.
    ByName,
    /// As they are declared: as version 0.2 counted them.
    Declared,
    /// By their names; and a part that was turned onto itself is another, as its ports have changed places.
    Turned,
    /// As [`Order::Turned`]; and which part is the original and which the image counts, too.
    Driven,
}

/// What makes a part this part, apart from its joints.
fn describe(part: &Part, order: Order) -> String {
    let p = part.pose.translation.vector;
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|a| part.pose.rotation * a);
    // With ports of its own a part has a front and a back wherever they are, and with a joint it moves about an axis of its own.
    let plain = match part.made.as_ref() {
        Made::Block(block)
            if block.ports.is_empty()
                && block.joint.is_none()
                && !matches!(order, Order::Turned | Order::Driven) =>
        {
            Some(block.form.shape)
        }
        _ => None,
    };
    let turned = match plain {
        Some(Shape::Ball { .. }) => String::new(),
        Some(Shape::Box { half }) => {
            // A cube turned by a quarter is the same cube.
            let mut lines: Vec<(i64, [i64; 3])> =
                axes.iter().zip(&half).map(|(a, half)| (snap(2.0 * half), line(*a))).collect();
            lines.sort_unstable();
            format!("{lines:?}")
        }
        _ => format!("{:?}", axes.map(direction)),
    };
    // The order in which a kind declares its parameters is no matter.
    let mut own: Vec<(&String, &Value)> = part.params.iter().collect();
    if order != Order::Declared {
        own.sort_by_key(|(name, _)| (*name != "segments", *name));
    }
    let params: Vec<String> = own
        .into_iter()
        .map(|(name, value)| match value {
            Value::Pattern(pattern) => format!("{name}={pattern}"),
            other => of_body(name, other),
        })
        .collect();
    let hand = if part.is_seen_in_mirror() { " mirrored" } else { "" };
    let alone = if part.alone && matches!(order, Order::Turned | Order::Driven) { " alone" } else { "" };
    let driven = match order {
        Order::Driven => {
            let port = part.held_by.map_or(0, |(_, port)| port);
            format!(" image {} turn {} at {port}", part.image, snap(part.turn))
        }
        _ => String::new(),
    };
    format!("{} {:?} {turned} {params:?}{hand}{alone}{driven}", part.kind, [snap(p.x), snap(p.y), snap(p.z)])
}

/// The parts of a design, each with its place and with what holds it, in order: two designs
/// are the same body if all of these are the same.
pub(super) fn pieces(design: &Design) -> Vec<String> {
    let described =
        |id: PartId| design.parts.get(&id).map_or(String::new(), |part| describe(part, Order::ByName));
    let mut pieces: Vec<String> = design
        .parts
        .iter()
        .map(|(id, part)| {
            let holder = part.held_by.map_or(String::new(), |(holder, _)| described(holder));
            format!("{} held by {holder}", described(*id))
        })
        .collect();
    pieces.extend(design.values.iter().map(|(name, value)| of_body(name, value)));
    pieces.sort_unstable();
    pieces
}

/// A value of the body.
fn of_body(name: &str, value: &Value) -> String {
    match value {
        Value::Number(x) => format!("{name}={}", x.to_bits()),
        other => format!("{name}={other:?}"),
    }
}

pub(super) fn hash(design: &Design, order: Order) -> String {
    let mut described: Vec<(String, PartId)> =
        design.parts.iter().map(|(id, p)| (describe(p, order), *id)).collect();
    described.sort_unstable();
    let index = |id: PartId| described.iter().position(|(_, i)| *i == id);
    let mut joints: Vec<(Option<usize>, Option<usize>)> = design
        .parts
        .iter()
        .filter_map(|(id, p)| {
            p.held_by.map(|(holder, _)| (index(holder).min(index(*id)), index(holder).max(index(*id))))
        })
        .collect();
    joints.sort_unstable();
    let mut hasher = Sha256::new();
    for (text, _) in &described {
        hasher.update(text.as_bytes());
        hasher.update(b"\n");
    }
    hasher.update(format!("{joints:?}").as_bytes());
    // Rules and objectives read them, even where no part does.
    for (name, value) in &design.values {
        hasher.update(format!("\n{}", of_body(name, value)).as_bytes());
    }
    hex(&hasher.finalize())
}

/// Lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
