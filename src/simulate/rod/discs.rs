//! An assembly whose bending rows are beams: each row of segments is cut into discs with an elastic link between two of them.
//!
//! Each hinge of a row stands for a share of its length. These shares are cut, not the segments: those at the ends of a row are half as long
//! as the others.

use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

use super::section::Section;
use crate::design::assembly::{Assembly, Control, Dof, Element, Joint, JointKind, Shape, Travel};
use crate::simulate::Unfit;

/// Directions that differ by more than this are not along one line.
const ASKEW: f64 = 1e-6;

/// What a segment and a disc have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// The element of the refined assembly.
    pub(super) disc: usize,
    /// From the middle of the disc to that of the part, at rest, m.
    pub(super) off: Vector3<f64>,
    /// Which share of the segment it is.
    pub(super) of_segment: f64,
    /// Which share of the disc it is.
    pub(super) of_disc: f64,
}

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
    /// How far from its beginning each segment begins, and the last one ends, m.
    bounds: Vec<f64>,
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

    /// From where to where a disc goes, m from the beginning.
    fn span(&self, disc: usize) -> (f64, f64) {
        let each = self.length() / self.links() as f64;
        let (from, to) = (each * (disc as f64 - 0.5), each * (disc as f64 + 0.5));
        (from.max(0.0), to.min(self.length()))
    }

    /// The discs of which a segment has a part.
    pub(super) fn parts(&self, segment: usize) -> Vec<Part> {
        let (begin, end) = (self.bounds[segment], self.bounds[segment + 1]);
        let part = |(number, disc): (usize, &usize)| {
            let (from, to) = self.span(number);
            let (first, last) = (from.max(begin), to.min(end));
            let (off, length) = (0.5 * (first + last - from - to), last - first);
            // Where two segments meet, rounding may leave next to nothing.
            (length > 1e-9 * (end - begin)).then(|| Part {
                disc: *disc,
                off: self.way().into_inner() * off,
                of_segment: length / (end - begin),
                of_disc: length / (to - from),
            })
        };
        self.discs.iter().enumerate().filter_map(part).collect()
    }

    /// The disc in the middle of a segment; of one that has none there, that nearer to the end of the beam.
    pub(super) fn middle(&self, segment: usize) -> usize {
        let middle = 0.5 * (self.bounds[segment] + self.bounds[segment + 1]);
        let place = middle / self.length() * self.links() as f64;
        let half = 0.5 - 1e-9;
        let place = if 2.0 * middle < self.length() { (place - half).ceil() } else { (place + half).floor() };
        self.discs[(place.max(0.0) as usize).min(self.links())]
    }
}

/// What joins an element of the refined assembly to the one that it hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// A piece of a beam.
    Elastic { beam: usize },
    /// A joint of the assembly.
    Joint,
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
    /// Cuts the share of each hinge of each bending row into so many pieces.
    ///
    /// # Errors
    ///
    /// [`Unfit`] where a body has what beams cannot be made of.
    pub(super) fn new(assembly: &Assembly, per_hinge: usize) -> Result<Self, Unfit> {
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
            own.cut(assembly, beam, per_hinge);
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
            own.join(from, to, kind, Link::Joint);
            if let Some((beam, _)) = child {
                own.join_discs(beam);
            }
        }
        Ok(own)
    }

    /// The refined assembly with a hinge in the place of each elastic link, as stiff together as the row is.
    #[cfg(test)]
    pub(super) fn into_hinges(mut self) -> Assembly {
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
        self.assembly
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
    fn cut(&mut self, assembly: &Assembly, beam: usize, per_hinge: usize) {
        let own = &self.beams[beam];
        let links = own.hinges.len() * per_hinge;
        let (base, way) = (own.ends[0], own.way().into_inner());
        let (length, segments) = (own.length(), own.segments.clone());
        let like = assembly.elements[segments[0]].clone();
        let mass: f64 = segments.iter().map(|segment| assembly.elements[*segment].mass).sum();
        let along = like.pose.rotation.inverse() * way;
        // A disc is known by its place among them.
        self.beams[beam].discs = vec![0; links + 1];
        for disc in 0..=links {
            let (from, to) = self.beams[beam].span(disc);
            let place = base + way * (0.5 * (from + to));
            self.beams[beam].discs[disc] = self.add(Element {
                shape: cut(&like.shape, &along, 0.5 * (to - from)),
                pose: Isometry3::from_parts(place.into(), like.pose.rotation),
                mass: mass * (to - from) / length,
                friction: like.friction,
            });
        }
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

/// The shape of a slice across a direction of its own frame, which has half a length along that, m.
fn cut(shape: &Shape, along: &Vector3<f64>, half: f64) -> Shape {
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
pub(super) fn beams(assembly: &Assembly) -> Result<Vec<Beam>, Unfit> {
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
        return Err(unfit("the joints of an actuator do not form a row; rods are rows of segments"));
    }
    let reach = |segment: usize| {
        let pose = &element(segment).pose;
        element(segment).shape.extent(&(pose.rotation.inverse() * way.into_inner()))
    };
    // The first hinge turns the second segment against the first, or the first one against what the row hangs on.
    let section = |segment: usize| Section::new(element(segment), &way, &first.axis);
    let is_segment = section(joint.parent) == section(joint.child)
        && reach(joint.parent) <= (1.0 + ASKEW) * reach(joint.child)
        && (centre(joint.parent) + way.into_inner() * reach(joint.parent) - first.anchor.coords).norm()
            < ASKEW;
    let segments: Vec<usize> = is_segment
        .then_some(joint.parent)
        .into_iter()
        .chain(hinges.iter().map(|(_, joint, _)| joint.child))
        .collect();
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
        (dof.stiffness, dof.sideways, dof.torsion, dof.damping, dof.effort, dof.share)
            == (first.stiffness, first.sideways, first.torsion, first.damping, first.effort, first.share)
            && dof.axis.dot(&first.axis) > 1.0 - ASKEW
    };
    if !hinges.iter().all(|(_, _, dof)| alike(dof)) {
        return Err(unfit("the joints of a row differ; rods are the same along their length"));
    }
    if first.stiffness <= 0.0 {
        return Err(unfit("a row has no stiffness; rods need a stiffness"));
    }
    let Some(section) = section(segments[0]) else { return Ok(None) };
    let along = |place: Vector3<f64>| (place - ends[0].coords).dot(&way);
    let between = hinges.iter().skip(usize::from(!is_segment)).map(|(_, _, dof)| along(dof.anchor.coords));
    let bounds = std::iter::once(0.0).chain(between).chain([length]).collect();
    Ok(Some(Beam {
        hinges: hinges.iter().map(|(number, _, _)| *number).collect(),
        segments,
        discs: Vec::new(),
        ends,
        bounds,
        hinge: (*first).clone(),
        section,
    }))
}
