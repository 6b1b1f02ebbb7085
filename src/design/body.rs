//! From a design to its assembly: elements and joints.

use std::collections::BTreeMap;

use grammar_lang::eval::{Made, MadeJoint};
use grammar_lang::ir::{self, Form, RuleSet};
use nalgebra::{Isometry3, Point3, UnitQuaternion, UnitVector3, Vector3};

use super::assembly::{Assembly, Control, Dof, Element, Joint, JointKind, Shape, Travel};
use super::port::{about, base, segments};
use super::row::{axes_of, cuts, side};
use super::{Design, Part, PartId, filled, lattice, symmetry};

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
    pub(super) fn of_parts(design: &Design, rules: &RuleSet) -> Self {
        let mut body =
            Self { assembly: Assembly::default(), parts_of_elements: Vec::new(), actuators: Vec::new() };
        let mut held: BTreeMap<PartId, Vec<(u8, PartId)>> = BTreeMap::new();
        for (id, part) in &design.parts {
            if let Some((holder, port)) = part.held_by {
                held.entry(holder).or_default().push((port, *id));
            }
        }
        // Each entry: the part, and the element that holds it.
        let mut open: Vec<(PartId, Option<End>)> =
            design.parts.first().map(|(id, _)| (*id, None)).into_iter().collect();
        while let Some((id, holder)) = open.pop() {
            let Some(part) = design.parts.get(&id) else { continue };
            let mut moved = Moved::default();
            if let Some(holder) = holder {
                let child = body.assembly.elements.len();
                let kind;
                (kind, moved) = hung(part, rules, holder.moved);
                body.assembly.joints.push(Joint { parent: holder.element, child, kind });
            }
            let ends = body.add(rules, (id, part), moved);
            let mut held = held.remove(&id).unwrap_or_default();
            held.sort_unstable();
            // The last one in is the next one out: the lowest port comes first.
            let end = |port: u8| if port == 0 { ends.0 } else { ends.1 };
            open.extend(held.into_iter().rev().map(|(port, i)| (i, Some(end(port)))));
        }
        body.assembly.actuators = body.actuators.len();
        body
    }

    /// The elements of a part, as indices.
    pub fn elements_of(&self, part: PartId) -> impl Iterator<Item = usize> {
        self.parts_of_elements.iter().enumerate().filter(move |(_, p)| **p == part).map(|(i, _)| i)
    }

    /// The frame of a part as a motion begins, which is that of its end with this port: joints nearer to the core, and its own, are then
    /// where their springs rest.
    pub(super) fn frame_at_rest(&self, id: PartId, part: &Part, port: u8) -> Option<Isometry3<f64>> {
        let elements: Vec<usize> = self.elements_of(id).collect();
        let pose = |element: Option<&usize>| Some(self.assembly.elements.get(*element?)?.pose);
        match part.made.as_ref() {
            Made::Block(block) => Some(pose(elements.first())? * upright(block.form).inverse()),
            Made::Actuator(actuator) => {
                let length = 2.0 * actuator.segment.half_extents().x;
                let count = segments(part);
                let spans = spans(length, count, &cuts(length, count));
                let by_tip = part.held_by.is_some() && part.holding == 1;
                let at_base = port == 0;
                let (start, end) = if at_base { spans.first() } else { spans.last() }?;
                // The first element is the one at the holder.
                let element = if at_base == by_tip { elements.last() } else { elements.first() };
                Some(pose(element)? * Isometry3::translation(-(start + end) / 2.0, 0.0, 0.0))
            }
            Made::Cell(_) => pose(elements.first()),
        }
    }

    /// Adds the elements of a part that what holds it has moved, from the end by which it is held; gives those at its
    /// port 0 and at its others (of an actuator: base and tip).
    fn add(&mut self, rules: &RuleSet, (id, part): (PartId, &Part), moved: Moved) -> (End, End) {
        let first = self.assembly.elements.len();
        let whole = End { element: first, moved };
        let mut push = |shape, pose, mass, friction| {
            self.assembly.elements.push(Element { shape, pose, mass, friction });
            self.parts_of_elements.push(id);
        };
        let actuator = match part.made.as_ref() {
            Made::Block(block) => {
                let pose = moved.pose(part.pose * upright(block.form));
                push(block.form.shape, pose, block.mass, block.friction);
                return (whole, whole);
            }
            Made::Actuator(actuator) => actuator,
            Made::Cell(_) => return (whole, whole),
        };
        let Some(alike) = rules.actuators.get(&part.kind) else { return (whole, whole) };
        let length = 2.0 * actuator.segment.half_extents().x;
        let count = segments(part);
        let places = cuts(length, count);
        let spans = spans(length, count, &places);
        let by_tip = part.held_by.is_some() && part.holding == 1;
        // The segment that is the i-th from the holder, counted from the base.
        let segment = |i: usize| if by_tip { count - 1 - i } else { i };
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
                rest: actuator.joint.start() / joints,
            },
        };
        let moves = Moves {
            control,
            share: 1.0 / joints,
            side: side(by_tip),
            effort: actuator.motor.as_ref().map_or(f64::INFINITY, |motor| motor.effort),
        };
        let mut moved = moved;
        for i in 0..count {
            if i > 0 {
                let place = segment(i).min(segment(i - 1));
                let anchor = part.pose * Point3::new(places[place], 0.0, 0.0);
                let kind;
                (kind, moved) = moves.joint(&actuator.joint, anchor, (part, moved), rules);
                self.assembly.joints.push(Joint { parent: first + i - 1, child: first + i, kind });
            }
            let (start, end) = spans[segment(i)];
            let centre = Isometry3::translation((start + end) / 2.0, 0.0, 0.0);
            let shape = cut(actuator.segment.shape, (end - start) / 2.0);
            let mass = actuator.mass * (end - start) / length;
            push(shape, moved.pose(part.pose * centre), mass, actuator.friction);
        }
        if alike.motor.is_some() {
            self.actuators.push(id);
        }
        let last = End { element: first + count.saturating_sub(1), moved };
        if by_tip { (last, whole) } else { (whole, last) }
    }
}

/// From where to where the segments of a row with joints at these places go, along its axis from the base, m.
fn spans(length: f64, count: usize, places: &[f64]) -> Vec<(f64, f64)> {
    let starts = std::iter::once(0.0).chain(places.iter().copied());
    starts.zip(places.iter().copied().chain([length * count as f64])).collect()
}

/// A segment of another half length.
fn cut(segment: Shape, half_length: f64) -> Shape {
    match segment {
        Shape::Cylinder { radius, .. } => Shape::Cylinder { radius, half_length },
        Shape::Box { half } => Shape::Box { half: Vector3::new(half_length, half.y, half.z) },
        // The checker refuses them.
        Shape::Ball { .. } | Shape::Capsule { .. } => segment,
    }
}

/// An end of a part, which may hold others.
#[derive(Clone, Copy)]
struct End {
    element: usize,
    /// How it has been moved from where the design has it.
    moved: Moved,
}

/// How something has been moved from where the design has it, as joints nearer to the core begin where their springs rest. Nothing
/// where none does: poses then stay what they are, to the bit.
#[derive(Clone, Copy, Default)]
struct Moved(Option<Isometry3<f64>>);

impl Moved {
    fn pose(self, pose: Isometry3<f64>) -> Isometry3<f64> {
        self.0.map_or(pose, |moved| moved * pose)
    }

    fn point(self, point: Point3<f64>) -> Point3<f64> {
        self.0.map_or(point, |moved| moved * point)
    }

    fn direction(self, direction: Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(direction, |moved| moved * direction)
    }

    /// The same behind a degree of freedom that begins elsewhere than at 0.
    fn behind(self, dof: &Dof, start: f64) -> Self {
        if start == 0.0 {
            return self;
        }
        let step = match dof.travel {
            Travel::Slide => {
                Isometry3::from_parts((dof.axis.into_inner() * start).into(), UnitQuaternion::identity())
            }
            Travel::Turn => Isometry3::rotation_wrt_point(turned(dof.axis, start), dof.anchor),
        };
        Self(Some(self.0.map_or(step, |moved| step * moved)))
    }
}

/// A turn about an axis, with the same bits on every machine.
fn turned(axis: UnitVector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    let half = axis.into_inner() * libm::sin(0.5 * angle);
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(libm::cos(0.5 * angle), half.x, half.y, half.z))
}

/// The joint of a part with what holds it, and how the part has been moved then.
fn hung(part: &Part, rules: &RuleSet, moved: Moved) -> (JointKind, Moved) {
    let Made::Block(made) = part.made.as_ref() else { return (JointKind::Rigid, moved) };
    let Some(own) = &made.joint else { return (JointKind::Rigid, moved) };
    let moves = Moves {
        control: Control::Passive { neutral: own.neutral },
        share: 1.0,
        side: 1.0,
        effort: f64::INFINITY,
    };
    let place = match own.pivot {
        Some([x, y, z]) => {
            let side = if symmetry::is_reflected(rules, part.image) { -1.0 } else { 1.0 };
            part.pose * Point3::new(x, y, side * z)
        }
        None => base(part, &part.pose),
    };
    moves.joint(own, place, (part, moved), rules)
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
    /// One joint of a part that what holds it has moved, at a place in the world as the design has it, and how what is behind the
    /// joint has been moved. Positions are counted from where it begins.
    fn joint(
        &self,
        own: &MadeJoint,
        anchor: Point3<f64>,
        (part, moved): (&Part, Moved),
        rules: &RuleSet,
    ) -> (JointKind, Moved) {
        let (low, high) = own.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let start = match self.control {
            Control::Passive { .. } => own.start() * self.share,
            Control::Position { rest, .. } => rest,
            Control::Speed { .. } => 0.0,
        };
        let control = match self.control {
            Control::Passive { neutral } => Control::Passive { neutral: neutral - start },
            driven => driven,
        };
        let anchor = moved.point(anchor);
        let dof = |axis: Vector3<f64>| Dof {
            anchor,
            axis: UnitVector3::new_normalize(moved.direction(part.pose.rotation * (axis * self.side))),
            travel: match own.kind {
                ir::JointKind::Bend | ir::JointKind::Twist | ir::JointKind::Spin | ir::JointKind::Socket => {
                    Travel::Turn
                }
                ir::JointKind::Slide => Travel::Slide,
            },
            control,
            share: self.share,
            limits: (low * self.share - start, high * self.share - start),
            stiffness: own.stiffness,
            sideways: own.sideways,
            torsion: own.torsion,
            damping: own.damping,
            effort: self.effort,
        };
        let dofs: Vec<Dof> = axes_of(own.kind, own.axis, part, rules).into_iter().map(dof).collect();
        match <[Dof; 3]>::try_from(dofs) {
            Ok(three) => (JointKind::Socket(Box::new(three)), moved),
            Err(other) => match other.into_iter().next() {
                Some(dof) => {
                    let behind = moved.behind(&dof, start);
                    (JointKind::Dof(dof), behind)
                }
                None => (JointKind::Rigid, moved),
            },
        }
    }
}

impl Part {
    /// How the element of a block lies in the frame of the part; what stands is turned.
    #[must_use]
    pub fn rotation_of_element(&self) -> UnitQuaternion<f64> {
        match self.made.as_ref() {
            Made::Block(block) => upright(block.form).rotation,
            Made::Actuator(_) | Made::Cell(_) => UnitQuaternion::identity(),
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
