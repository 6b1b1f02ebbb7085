//! An assembly whose bending rows are beams: each row of segments is cut into discs with an elastic link between two of them.

use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

use super::section::Section;
use crate::design::assembly::{Assembly, Control, Dof, Element, Joint, JointKind, Shape, Travel};
use crate::simulate::Unfit;

/// Directions that differ by more than this are not along one line.
const ASKEW: f64 = 1e-6;

/// A row of segments that bends.
#[derive(Clone, Debug)]
pub(super) struct Beam {
    /// The joints of the row, from its base on.
    pub(super) hinges: Vec<usize>,
    /// Its elements, from its base on.
    pub(super) segments: Vec<usize>,
    /// The elements of the refined assembly that it is cut into, one more than links. The first and the last are half as long
    /// as the others, and rigidly joined to what the beam hangs on and to what hangs on it.
    pub(super) discs: Vec<usize>,
    /// Where it begins and ends at rest, m.
    ends: [Point3<f64>; 2],
    /// What each hinge is like. All are alike.
    pub(super) hinge: Dof,
    /// The section of its segments.
    pub(super) section: Section,
}

impl Beam {
    /// How long it is, m.
    pub(super) fn length(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm()
    }

    /// From its base to its tip.
    pub(super) fn way(&self) -> UnitVector3<f64> {
        UnitVector3::new_normalize(self.ends[1] - self.ends[0])
    }

    /// How many elastic links it has.
    pub(super) fn links(&self) -> usize {
        self.discs.len() - 1
    }

    /// What a segment is made of: discs, how far from the middle of each its part is, m, and how much of the segment that is.
    pub(super) fn parts(&self, segment: usize) -> Vec<(usize, Vector3<f64>, f64)> {
        let each = self.links() / self.segments.len();
        let (first, last) = (segment * each, (segment + 1) * each);
        let quarter = self.way().into_inner() * (self.length() / self.links() as f64 / 4.0);
        let share = 1.0 / (2 * each) as f64;
        (first..=last)
            .map(|disc| {
                // The discs at the ends of the beam are halves already.
                let is_whole = disc > 0 && disc < self.links();
                let (off, weight) = match disc {
                    _ if disc == first => (if is_whole { quarter } else { Vector3::zeros() }, share),
                    _ if disc == last => (if is_whole { -quarter } else { Vector3::zeros() }, share),
                    _ => (Vector3::zeros(), 2.0 * share),
                };
                (self.discs[disc], off, weight)
            })
            .collect()
    }

    /// The disc in the middle of a segment.
    pub(super) fn middle(&self, segment: usize) -> usize {
        let each = self.links() / self.segments.len();
        self.discs[segment * each + each / 2]
    }
}

/// What joins an element of the refined assembly to the one that it hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// A piece of a beam.
    Elastic { beam: usize },
    /// A joint of the assembly.
    Joint { joint: usize },
}

/// The assembly, refined.
#[derive(Clone, Debug)]
pub(super) struct Discs {
    /// Discs in the place of segments.
    pub(super) assembly: Assembly,
    /// What joins each element to the one it hangs on, where that may move.
    pub(super) links: Vec<(usize, Link)>,
    /// The element of the refined assembly that is, or stands for, each element.
    pub(super) of_element: Vec<usize>,
    /// The beams.
    pub(super) beams: Vec<Beam>,
}

impl Discs {
    /// Cuts each segment of each bending row into so many discs.
    ///
    /// # Errors
    ///
    /// [`Unfit`] where a body has what beams cannot be made of.
    pub(super) fn new(assembly: &Assembly, per_segment: usize) -> Result<Self, Unfit> {
        let beams = beams(assembly)?;
        let of_segment: Vec<Option<(usize, usize)>> = (0..assembly.elements.len())
            .map(|element| {
                beams.iter().enumerate().find_map(|(beam, own)| {
                    Some((beam, own.segments.iter().position(|segment| *segment == element)?))
                })
            })
            .collect();
        if of_segment.first().is_some_and(Option::is_some) {
            return Err(unfit("the core is a segment of an actuator; rods begin with a rigid part"));
        }
        let mut own = Self {
            assembly: Assembly { actuators: assembly.actuators, ..Assembly::default() },
            links: Vec::new(),
            of_element: vec![0; assembly.elements.len()],
            beams,
        };
        for (element, segment) in of_segment.iter().enumerate() {
            if segment.is_none() {
                own.of_element[element] = own.add(assembly.elements[element].clone());
            }
        }
        for beam in 0..own.beams.len() {
            own.cut(assembly, beam, per_segment);
        }
        for (number, joint) in assembly.joints.iter().enumerate() {
            let hinge = own.beams.iter().any(|beam| beam.hinges.contains(&number));
            let (parent, child) = (of_segment[joint.parent], of_segment[joint.child]);
            // Within a row only its first hinge says what the row hangs on, if that is no segment of it.
            if hinge && parent.map(|(beam, _)| beam) == child.map(|(beam, _)| beam) {
                continue;
            }
            let kind = if hinge { JointKind::Rigid } else { joint.kind.clone() };
            let from = match parent {
                Some((beam, segment)) if segment + 1 == own.beams[beam].segments.len() => {
                    own.beams[beam].discs[own.beams[beam].links()]
                }
                _ => own.of_element[joint.parent],
            };
            let to = match child {
                Some((beam, _)) => own.beams[beam].discs[0],
                None => own.of_element[joint.child],
            };
            own.join(from, to, kind, Link::Joint { joint: number });
            if let Some((beam, _)) = child {
                own.join_discs(beam);
            }
        }
        Ok(own)
    }

    /// The pieces of each beam, and the refined assembly with a hinge in the place of each elastic link, as stiff together as the row is.
    #[cfg(test)]
    pub(super) fn into_hinges(mut self) -> (Vec<Vec<usize>>, Assembly) {
        let links = self.links.clone();
        for joint in &mut self.assembly.joints {
            let Some((_, Link::Elastic { beam })) = links.iter().find(|(child, _)| *child == joint.child)
            else {
                continue;
            };
            let beam = &self.beams[*beam];
            let times = beam.links() as f64 / beam.hinges.len() as f64;
            for dof in joint.kind.dofs_mut() {
                dof.stiffness *= times;
                dof.damping *= times;
                dof.share /= times;
                dof.control = match dof.control {
                    Control::Position { actuator, rate, relaxing_rate, rest } => Control::Position {
                        actuator,
                        rate: rate / times,
                        relaxing_rate: relaxing_rate / times,
                        rest,
                    },
                    other => other,
                };
            }
        }
        (self.beams.into_iter().map(|beam| beam.discs).collect(), self.assembly)
    }

    fn add(&mut self, element: Element) -> usize {
        self.assembly.elements.push(element);
        self.assembly.elements.len() - 1
    }

    fn join(&mut self, parent: usize, child: usize, kind: JointKind, link: Link) {
        if !matches!(kind, JointKind::Rigid) {
            self.links.push((child, link));
        }
        self.assembly.joints.push(Joint { parent, child, kind });
    }

    /// Makes the discs of a beam.
    fn cut(&mut self, assembly: &Assembly, beam: usize, per_segment: usize) {
        let own = &self.beams[beam];
        let links = own.segments.len() * per_segment;
        let (base, way) = (own.ends[0], own.ends[1] - own.ends[0]);
        let segments = own.segments.clone();
        let mass: f64 = segments.iter().map(|segment| assembly.elements[*segment].mass).sum();
        let mut discs = Vec::with_capacity(links + 1);
        for disc in 0..=links {
            let from = (disc as f64 - 0.5).max(0.0) / links as f64;
            let to = (disc as f64 + 0.5).min(links as f64) / links as f64;
            let place = base + way * (0.5 * (from + to));
            let segment = (disc / per_segment).min(segments.len() - 1);
            let like = &assembly.elements[segments[segment]];
            let along = like.pose.rotation.inverse() * way;
            discs.push(self.add(Element {
                shape: cut(&like.shape, &along, 0.5 * (to - from)),
                pose: Isometry3::from_parts(place.into(), like.pose.rotation),
                mass: mass * (to - from),
                friction: like.friction,
            }));
        }
        self.beams[beam].discs = discs;
        for (number, segment) in segments.into_iter().enumerate() {
            self.of_element[segment] = self.beams[beam].middle(number);
        }
    }

    fn join_discs(&mut self, beam: usize) {
        let own = self.beams[beam].clone();
        let way = own.ends[1] - own.ends[0];
        for (number, pair) in own.discs.windows(2).enumerate() {
            let anchor = own.ends[0] + way * ((number as f64 + 0.5) / own.links() as f64);
            let dof = Dof { anchor, ..own.hinge.clone() };
            self.join(pair[0], pair[1], JointKind::Dof(dof), Link::Elastic { beam });
        }
    }
}

fn unfit(reason: &str) -> Unfit {
    Unfit { reason: reason.to_owned() }
}

/// The shape of a slice across a direction of its own frame, whose length along that is a share of it.
fn cut(shape: &Shape, along: &Vector3<f64>, share: f64) -> Shape {
    let half = along.norm() * share;
    match *shape {
        Shape::Box { half: mut sides } => {
            sides[along.abs().imax()] = half;
            Shape::Box { half: sides }
        }
        Shape::Cylinder { radius, .. } | Shape::Capsule { radius, .. } => {
            Shape::Cylinder { radius, half_length: half }
        }
        Shape::Ball { radius } => Shape::Ball { radius },
    }
}

/// The rows of an assembly that bend, actuator by actuator.
fn beams(assembly: &Assembly) -> Result<Vec<Beam>, Unfit> {
    let mut found = Vec::new();
    for actuator in 0..assembly.actuators {
        let hinges: Vec<(usize, &Joint, &Dof)> = assembly
            .joints
            .iter()
            .enumerate()
            .filter_map(|(number, joint)| match &joint.kind {
                JointKind::Dof(dof) if dof.actuator() == Some(actuator) => Some((number, joint, dof)),
                _ => None,
            })
            .collect();
        let bends =
            |dof: &Dof| matches!(dof.control, Control::Position { .. }) && matches!(dof.travel, Travel::Turn);
        if hinges.is_empty() || !hinges.iter().all(|(_, _, dof)| bends(dof)) {
            continue;
        }
        if let Some(beam) = beam(assembly, &hinges)? {
            found.push(beam);
        }
    }
    Ok(found)
}

/// A beam, unless the row turns about its own axis or is made of balls.
fn beam(assembly: &Assembly, hinges: &[(usize, &Joint, &Dof)]) -> Result<Option<Beam>, Unfit> {
    let Some((_, joint, first)) = hinges.first() else { return Ok(None) };
    let element = |element: usize| &assembly.elements[element];
    let centre = |segment: usize| element(segment).pose.translation.vector;
    let way = centre(joint.child) - first.anchor.coords;
    let Some(way) = UnitVector3::try_new(way, 1e-9) else { return Ok(None) };
    if first.axis.dot(&way).abs() > 0.5 {
        return Ok(None);
    }
    if first.axis.dot(&way).abs() > ASKEW {
        return Err(unfit("a row bends about an axis that is askew to it; rods bend about axes across them"));
    }
    if !hinges.windows(2).all(|pair| pair[0].1.child == pair[1].1.parent) {
        return Err(unfit("the joints of an actuator are no row; rods are rows of segments"));
    }
    let is_segment = element(joint.parent).shape == element(joint.child).shape;
    let segments: Vec<usize> = is_segment
        .then_some(joint.parent)
        .into_iter()
        .chain(hinges.iter().map(|(_, joint, _)| joint.child))
        .collect();
    let reach = |segment: usize| {
        let pose = &element(segment).pose;
        element(segment).shape.extent(&(pose.rotation.inverse() * way.into_inner()))
    };
    let (base, tip) = (segments[0], segments[segments.len() - 1]);
    let ends = [
        Point3::from(centre(base) - way.into_inner() * reach(base)),
        Point3::from(centre(tip) + way.into_inner() * reach(tip)),
    ];
    let length = (ends[1] - ends[0]).norm();
    let off = |place: Vector3<f64>| (place - ends[0].coords).cross(&way).norm();
    let rests = |dof: &Dof| matches!(dof.control, Control::Position { rest, .. } if rest != 0.0);
    if segments.iter().any(|segment| off(centre(*segment)) > ASKEW * length.max(1.0))
        || hinges.iter().any(|(_, _, dof)| rests(dof))
    {
        return Err(unfit("a row rests bent; rods are straight at rest"));
    }
    let alike = |dof: &Dof| {
        (dof.stiffness, dof.damping, dof.effort, dof.share)
            == (first.stiffness, first.damping, first.effort, first.share)
            && dof.axis.dot(&first.axis) > 1.0 - ASKEW
    };
    if !hinges.iter().all(|(_, _, dof)| alike(dof)) {
        return Err(unfit("the joints of a row differ; rods are the same along their length"));
    }
    if first.stiffness <= 0.0 {
        return Err(unfit("a row has no stiffness; rods need some"));
    }
    let like = element(segments[0]);
    let Some(section) = Section::new(like, &way, &first.axis) else { return Ok(None) };
    Ok(Some(Beam {
        hinges: hinges.iter().map(|(number, _, _)| *number).collect(),
        segments,
        discs: Vec::new(),
        ends,
        hinge: (*first).clone(),
        section,
    }))
}
