//! From a design to its assembly: elements and joints.

use grammar_lang::ir::{self, RuleSet};
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

use super::assembly::{Assembly, Element, Hinge, Joint, JointKind, Shape};
use super::port::segments;
use super::{Design, Part, PartId};

/// The assembly of a design, and what its elements and actuators are.
///
/// Elements stand in the order of the tree from the core, ports in order: the
/// order of derivation leaves no trace.
#[derive(Clone, Debug)]
pub struct Body {
    /// Elements and joints.
    pub assembly: Assembly,
    /// The part that each element belongs to.
    pub parts_of_elements: Vec<PartId>,
    /// The part that each actuator of the assembly is.
    pub actuators: Vec<PartId>,
}

impl Body {
    /// Lowers a design.
    #[must_use]
    pub fn new(design: &Design, rules: &RuleSet) -> Self {
        let mut body =
            Self { assembly: Assembly::default(), parts_of_elements: Vec::new(), actuators: Vec::new() };
        // Each entry: the part, and the element that holds it.
        let mut open: Vec<(PartId, Option<usize>)> =
            design.parts.first().map(|(id, _)| (*id, None)).into_iter().collect();
        while let Some((id, holder)) = open.pop() {
            let Some(part) = design.parts.get(&id) else { continue };
            if let Some(parent) = holder {
                let child = body.assembly.elements.len();
                body.assembly.joints.push(Joint { parent, child, kind: JointKind::Rigid });
            }
            let last = body.add(rules, id, part);
            let mut held: Vec<(u8, PartId)> = design
                .parts
                .iter()
                .filter_map(|(i, p)| p.held_by.filter(|(h, _)| *h == id).map(|(_, port)| (port, *i)))
                .collect();
            held.sort_unstable();
            // The last one in is the next one out: the lowest port comes first.
            open.extend(held.into_iter().rev().map(|(_, i)| (i, Some(last))));
        }
        body.assembly.actuators = body.actuators.len();
        body
    }

    /// Adds the elements of a part; gives the last, which holds what hangs on it.
    fn add(&mut self, rules: &RuleSet, id: PartId, part: &Part) -> usize {
        let first = self.assembly.elements.len();
        let mut push = |shape, pose, mass, friction| {
            self.assembly.elements.push(Element { shape, pose, mass, friction });
            self.parts_of_elements.push(id);
        };
        if let Some(block) = rules.parts.get(&part.kind) {
            push(shape_of(block.shape), part.pose, block.mass, block.friction);
            return first;
        }
        let Some(actuator) = rules.actuators.get(&part.kind) else { return first };
        let ir::Shape::Cylinder(_, length) = actuator.segment else { return first };
        let count = segments(part);
        for i in 0..count {
            let centre = Isometry3::translation(length * (i as f64 + 0.5), 0.0, 0.0);
            push(shape_of(actuator.segment), part.pose * centre, actuator.mass, actuator.friction);
        }
        let hinges = count.saturating_sub(1).max(1) as f64;
        let axis = UnitVector3::new_normalize(part.pose.rotation * Vector3::z());
        for i in 1..count {
            let hinge = Hinge {
                anchor: part.pose * Point3::new(length * i as f64, 0.0, 0.0),
                axis,
                actuator: self.actuators.len(),
                share: 1.0 / hinges,
                limits: (actuator.bend.0 / hinges, actuator.bend.1 / hinges),
                stiffness: actuator.stiffness,
                damping: actuator.damping,
                torque: actuator.torque,
                bending_rate: actuator.bending_speed / hinges,
                relaxing_rate: actuator.relaxing_speed / hinges,
            };
            self.assembly.joints.push(Joint {
                parent: first + i - 1,
                child: first + i,
                kind: JointKind::Hinge(hinge),
            });
        }
        self.actuators.push(id);
        first + count.saturating_sub(1)
    }
}

fn shape_of(shape: ir::Shape) -> Shape {
    match shape {
        ir::Shape::Box(edges) => Shape::Box { half: Vector3::from(edges) / 2.0 },
        ir::Shape::Sphere(radius) => Shape::Ball { radius },
        ir::Shape::Cylinder(radius, length) => Shape::Cylinder { radius, half_length: length / 2.0 },
    }
}
