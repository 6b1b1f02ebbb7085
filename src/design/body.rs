//! From a design to its assembly: elements and joints.

use std::collections::BTreeMap;

use grammar_lang::eval::{Made, MadeJoint};
use grammar_lang::ir::{self, Form, RuleSet};
use nalgebra::{Isometry3, Point3, UnitQuaternion, UnitVector3, Vector3};

use super::assembly::{Assembly, Control, Dof, Element, Joint, JointKind, Shape, Travel};
use super::port::{about, base, segments};
use super::row::{axes_of, cuts, side};
use super::{Design, Part, PartId, filled, lattice};

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
        if let Some(lattice) = &rules.lattice {
            return lattice::body(design, rules, lattice);
        }
        let body = Self::of_parts(design, rules);
        match rules.method() {
            ir::Method::Balls(Some(filling)) => filled::filled(design, rules, &body, filling),
            _ => body,
        }
    }

    /// Rigid elements and joints.
    fn of_parts(design: &Design, rules: &RuleSet) -> Self {
        let mut body =
            Self { assembly: Assembly::default(), parts_of_elements: Vec::new(), actuators: Vec::new() };
        let mut held: BTreeMap<PartId, Vec<(u8, PartId)>> = BTreeMap::new();
        for (id, part) in &design.parts {
            if let Some((holder, port)) = part.held_by {
                held.entry(holder).or_default().push((port, *id));
            }
        }
        // Each entry: the part, and the element that holds it.
        let mut open: Vec<(PartId, Option<usize>)> =
            design.parts.first().map(|(id, _)| (*id, None)).into_iter().collect();
        while let Some((id, holder)) = open.pop() {
            let Some(part) = design.parts.get(&id) else { continue };
            if let Some(parent) = holder {
                let child = body.assembly.elements.len();
                body.assembly.joints.push(Joint { parent, child, kind: hung(part, rules) });
            }
            let ends = body.add(rules, id, part);
            let mut held = held.remove(&id).unwrap_or_default();
            held.sort_unstable();
            // The last one in is the next one out: the lowest port comes first.
            let element = |port: u8| if port == 0 { ends.0 } else { ends.1 };
            open.extend(held.into_iter().rev().map(|(port, i)| (i, Some(element(port)))));
        }
        body.assembly.actuators = body.actuators.len();
        body
    }

    /// The elements of a part, as indices.
    pub fn elements_of(&self, part: PartId) -> impl Iterator<Item = usize> {
        self.parts_of_elements.iter().enumerate().filter(move |(_, p)| **p == part).map(|(i, _)| i)
    }

    /// Adds the elements of a part, from the end by which it is held; gives those at its
    /// port 0 and at its others (of an actuator: base and tip).
    fn add(&mut self, rules: &RuleSet, id: PartId, part: &Part) -> (usize, usize) {
        let first = self.assembly.elements.len();
        let mut push = |shape, pose, mass, friction| {
            self.assembly.elements.push(Element { shape, pose, mass, friction });
            self.parts_of_elements.push(id);
        };
        let actuator = match part.made.as_deref() {
            Some(Made::Block(block)) => {
                push(block.form.shape, part.pose * upright(block.form), block.mass, block.friction);
                return (first, first);
            }
            Some(Made::Actuator(actuator)) => actuator,
            None => return (first, first),
        };
        let Some(alike) = rules.actuators.get(&part.kind) else { return (first, first) };
        let Shape::Cylinder { radius, half_length } = actuator.segment.shape else { return (first, first) };
        let length = 2.0 * half_length;
        let count = segments(part);
        let places = cuts(length, count);
        let starts = || std::iter::once(0.0).chain(places.iter().copied());
        let ends = || places.iter().copied().chain([length * count as f64]);
        let spans: Vec<(f64, f64)> = starts().zip(ends()).collect();
        let by_tip = part.held_by.is_some() && part.holding == 1;
        // The segment that is the i-th from the holder, counted from the base.
        let segment = |i: usize| if by_tip { count - 1 - i } else { i };
        for i in 0..count {
            let (start, end) = spans[segment(i)];
            let centre = Isometry3::translation((start + end) / 2.0, 0.0, 0.0);
            let shape = Shape::Cylinder { radius, half_length: (end - start) / 2.0 };
            let mass = actuator.mass * (end - start) / length;
            push(shape, part.pose * centre, mass, actuator.friction);
        }
        let joints = places.len().max(1) as f64;
        let control = match &actuator.motor {
            None => Control::Passive { neutral: actuator.joint.neutral / joints },
            Some(_) if alike.joint.kind == ir::JointKind::Spin => {
                Control::Speed { actuator: self.actuators.len(), times: 1.0 }
            }
            Some(motor) => Control::Position {
                actuator: self.actuators.len(),
                rate: motor.speed.most() / joints,
                relaxing_rate: motor.relaxing_speed.most() / joints,
            },
        };
        let moves = Moves {
            control,
            share: 1.0 / joints,
            side: side(by_tip),
            effort: actuator.motor.as_ref().map_or(f64::INFINITY, |motor| motor.effort),
        };
        for i in 1..count {
            let place = segment(i).min(segment(i - 1));
            let anchor = part.pose * Point3::new(places[place], 0.0, 0.0);
            let kind = moves.joint((&alike.joint, &actuator.joint), anchor, part, rules);
            self.assembly.joints.push(Joint { parent: first + i - 1, child: first + i, kind });
        }
        if alike.motor.is_some() {
            self.actuators.push(id);
        }
        let last = first + count.saturating_sub(1);
        if by_tip { (last, first) } else { (first, last) }
    }
}

/// The joint of a part with what holds it.
fn hung(part: &Part, rules: &RuleSet) -> JointKind {
    let Some(Made::Block(made)) = part.made.as_deref() else { return JointKind::Rigid };
    let alike = rules.parts.get(&part.kind).and_then(|kind| kind.joint.as_ref());
    let (Some(alike), Some(own)) = (alike, &made.joint) else { return JointKind::Rigid };
    let moves = Moves {
        control: Control::Passive { neutral: own.neutral },
        share: 1.0,
        side: 1.0,
        effort: f64::INFINITY,
    };
    moves.joint((alike, own), base(part, &part.pose), part, rules)
}

/// How the joints of a part move.
struct Moves {
    control: Control,
    /// Of what the part does, each joint does so much.
    share: f64,
    side: f64,
    effort: f64,
}

impl Moves {
    /// One joint, of the kind of part and of this one, at a place in the world.
    fn joint(
        &self,
        (alike, own): (&ir::Joint, &MadeJoint),
        anchor: Point3<f64>,
        part: &Part,
        rules: &RuleSet,
    ) -> JointKind {
        let (low, high) = own.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let dof = |axis: Vector3<f64>| Dof {
            anchor,
            axis: UnitVector3::new_normalize(part.pose.rotation * (axis * self.side)),
            travel: match alike.kind {
                ir::JointKind::Bend | ir::JointKind::Twist | ir::JointKind::Spin | ir::JointKind::Socket => {
                    Travel::Turn
                }
                ir::JointKind::Slide => Travel::Slide,
            },
            control: self.control,
            share: self.share,
            limits: (low * self.share, high * self.share),
            stiffness: own.stiffness,
            damping: own.damping,
            effort: self.effort,
        };
        let dofs: Vec<Dof> = axes_of(alike.kind, own.axis, part, rules).into_iter().map(dof).collect();
        match <[Dof; 3]>::try_from(dofs) {
            Ok(three) => JointKind::Socket(Box::new(three)),
            Err(other) => other.into_iter().next().map_or(JointKind::Rigid, JointKind::Dof),
        }
    }
}

impl Part {
    /// How the element of a block lies in the frame of the part; what stands is turned.
    #[must_use]
    pub fn rotation_of_element(&self) -> UnitQuaternion<f64> {
        match self.made.as_deref() {
            Some(Made::Block(block)) => upright(block.form).rotation,
            Some(Made::Actuator(_)) | None => UnitQuaternion::identity(),
        }
    }
}

/// How an element lies in its part.
fn upright(form: Form) -> Isometry3<f64> {
    if form.stands {
        Isometry3::from_parts(Vector3::zeros().into(), about(2, std::f64::consts::FRAC_PI_2))
    } else {
        Isometry3::identity()
    }
}
