//! A body made of parts as balls and springs: its shapes filled with balls on one grid.
//!
//! The grid is aligned with the world at rest and has a point in the centre of the core, so that what is symmetric
//! stays so. Balls are joined as the cells of a lattice are, within a part and between parts that hold each other.
//! What a hinge does is done by strain: material of an actuator that bends by an angle over its length becomes longer
//! on one side of its axis and shorter on the other, in proportion to the distance from it.

use std::collections::BTreeMap;

use grammar_lang::eval::Made;
use grammar_lang::ir::{self, Filling, JOINED, RuleSet};
use nalgebra::{Point3, Vector3};

use super::assembly::{Assembly, Element, Shape, Spring, Swelling};
use super::port::segments;
use super::row::axes_of;
use super::{Body, Design, Part, PartId};

/// Points this near to a surface (m) are inside.
const CLOSE: f64 = 1e-9;

/// A point of the grid.
type Node = [i64; 3];

/// The same body of balls. A part that no point of the grid lies in has none.
pub(super) fn filled(design: &Design, rules: &RuleSet, body: &Body, filling: Filling) -> Body {
    let mut own = Body {
        assembly: Assembly { actuators: body.assembly.actuators, ..Assembly::default() },
        parts_of_elements: Vec::new(),
        actuators: body.actuators.clone(),
    };
    let mut nodes: BTreeMap<Node, usize> = BTreeMap::new();
    for (element, id) in body.assembly.elements.iter().zip(&body.parts_of_elements) {
        let inside = nodes_in(element, filling.spacing);
        let open: Vec<Node> = inside.into_iter().filter(|node| !nodes.contains_key(node)).collect();
        let mass = element.mass / open.len().max(1) as f64;
        for node in open {
            let index = own.assembly.elements.len();
            nodes.insert(node, index);
            own.assembly.elements.push(Element {
                shape: Shape::Ball { radius: filling.spacing / 2.0 },
                pose: point(node, filling.spacing).into(),
                mass,
                friction: element.friction,
            });
            own.parts_of_elements.push(*id);
            let gain = gain(design, rules, *id, &point(node, filling.spacing));
            let actuator = body.actuators.iter().position(|actuator| actuator == id);
            if let (Some(actuator), Some(gain)) = (actuator, gain) {
                own.assembly.swellings.push(Swelling { element: index, actuator, gain });
            }
        }
    }
    let joined = |a: PartId, b: PartId| a == b || design.neighbours(a).contains(&b);
    for (node, from) in &nodes {
        for offset in JOINED {
            let mut other = *node;
            other.iter_mut().zip(offset).for_each(|(at, by)| *at += i64::from(by));
            // Each pair once.
            let Some(to) = nodes.get(&other).filter(|to| *to > from) else { continue };
            let parts = (own.parts_of_elements.get(*from), own.parts_of_elements.get(*to));
            if let (Some(a), Some(b)) = parts
                && joined(*a, *b)
            {
                let Filling { stiffness, damping, .. } = filling;
                own.assembly.springs.push(Spring { from: *from, to: *to, stiffness, damping });
            }
        }
    }
    own.assembly.springs.sort_unstable_by_key(|spring| (spring.from, spring.to));
    own
}

/// A design of more balls than this is not worked with.
pub(crate) const MOST_BALLS: f64 = 10_000.0;

/// About how many balls a filling makes of a design.
pub(crate) fn balls(design: &Design, filling: &Filling) -> f64 {
    let volume = |part: &Part| match part.made.as_ref() {
        Made::Block(block) => block.form.shape.volume(),
        Made::Actuator(actuator) => actuator.segment.shape.volume() * segments(part) as f64,
        Made::Cell(_) => 0.0,
    };
    let all: f64 = design.parts.values().map(volume).sum();
    all / (filling.spacing * filling.spacing * filling.spacing)
}

fn point(node: Node, spacing: f64) -> Point3<f64> {
    Point3::from(node.map(|at| at as f64 * spacing))
}

/// The points of the grid within an element.
fn nodes_in(element: &Element, spacing: f64) -> Vec<Node> {
    let reach = element.shape.reach();
    let centre = element.pose.translation.vector;
    let range =
        |at: f64| libm::ceil((at - reach) / spacing) as i64..=libm::floor((at + reach) / spacing) as i64;
    let mut nodes = Vec::new();
    for z in range(centre.z) {
        for y in range(centre.y) {
            let row = range(centre.x).map(|x| [x, y, z]);
            nodes.extend(row.filter(|node| is_inside(element, &point(*node, spacing))));
        }
    }
    nodes
}

fn is_inside(element: &Element, point: &Point3<f64>) -> bool {
    element.shape.holds(&(element.pose.inverse() * point), CLOSE)
}

/// The strain of a point of an actuator for each radian that the whole actuator bends; none of a passive part.
fn gain(design: &Design, rules: &RuleSet, id: PartId, point: &Point3<f64>) -> Option<f64> {
    let part = design.parts.get(&id)?;
    let Made::Actuator(actuator) = part.made.as_ref() else { return None };
    let segment = 2.0 * actuator.segment.half_extents().x;
    let local = part.pose.inverse() * point;
    let kind = rules.actuators.get(&part.kind)?.joint.kind;
    let axis = *axes_of(kind, actuator.joint.axis, part, rules).first()?;
    let length = segment * segments(part) as f64;
    // What lies towards the inside of a bend becomes shorter: about z, what is above the axis of the row.
    match kind {
        ir::JointKind::Bend => Some(-local.coords.dot(&axis.cross(&Vector3::x())) / length),
        ir::JointKind::Slide => Some(axis.x / length),
        // Strain alone can do neither: the checker refuses them.
        ir::JointKind::Twist | ir::JointKind::Spin | ir::JointKind::Socket => None,
    }
}
