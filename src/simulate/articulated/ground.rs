//! Which points of the body may touch the ground.
//!
//! A box has its corners, a ball its lowest point, a capsule that of each end. A cylinder has, on each
//! end, the lowest point of the rim (so that it rolls) and four points fixed
//! to the rim (so that it stands when the lowest point is anywhere). As the
//! ground is flat, only the convex hull of a body can touch it: corners inside
//! are left out.

use nalgebra::{Isometry3, Point3, Vector3};

use super::kinematics::{Frame, State};
use super::scalar::{Mask, Scalar};
use super::tree::LENGTH;
use super::vector::V3;
use crate::design::assembly::Shape;
use crate::simulate::lowering::Lowered;
use crate::simulate::{Settings, World};

/// Points of a rim that are fixed to it.
const FAN: usize = 4;
/// Slots of a cylinder: per end, the lowest point and the fixed ones.
const CYLINDER_SLOTS: usize = 2 * (1 + FAN);

/// A point whose gap is small enough in some lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<S: Scalar> {
    /// The body.
    pub(super) body: usize,
    /// The point relative to the root's centre.
    pub(super) point: V3<S>,
    /// The velocity with which it moves against the centre of the body.
    pub(super) moving: V3<S>,
    /// The lanes.
    pub(super) lanes: S::Mask,
    /// Its height above the ground; negative below.
    pub(super) gap: S,
    /// Friction coefficient with the ground.
    pub(super) friction: S,
    /// The slot that remembers its impulse.
    pub(super) slot: usize,
}

/// The part of an element that faces the ground.
#[derive(Clone, Debug)]
enum Sole<S> {
    /// Points in the body's frame.
    Corners(Vec<V3<S>>),
    /// Its radius.
    Ball(S),
    /// Axis in the body's frame, half length, rim.
    Cylinder { axis: V3<S>, half_length: S, radius: S, fan: [V3<S>; FAN] },
    /// From the centre to the middle of one end in the body's frame, radius.
    Capsule { end: V3<S>, radius: S },
}

/// One element.
#[derive(Clone, Debug)]
struct Foot<S> {
    body: usize,
    centre: V3<S>,
    /// Radius of a ball about the centre that holds all of it.
    reach: S,
    friction: S,
    slot: usize,
    sole: Sole<S>,
}

/// All candidates of an assembly.
#[derive(Clone, Debug)]
pub(super) struct Ground<S> {
    feet: Vec<Foot<S>>,
    /// How many slots they need.
    pub(super) slots: usize,
    /// The first slot of each element.
    first: Vec<usize>,
}

impl<S: Scalar> Ground<S> {
    /// From elements in SI units, in the world of each lane.
    pub(super) fn new(kit: S::Kit, lowered: &Lowered, settings: &Settings, worlds: &[World]) -> Self {
        let hulls = Hulls::new(lowered);
        let (mut feet, mut slots, mut first) = (Vec::new(), 0, Vec::new());
        for (index, piece) in lowered.pieces.iter().enumerate() {
            let local = &piece.local;
            let reach = piece.shape.reach();
            let sole = match piece.shape {
                Shape::Box { .. } => Sole::Corners(hulls.corners(kit, index)),
                Shape::Ball { radius } => Sole::Ball(S::of(kit, radius * LENGTH)),
                Shape::Cylinder { radius, half_length } => cylinder(kit, local, radius, half_length),
                Shape::Capsule { radius, half_straight } => Sole::Capsule {
                    end: V3::constant(kit, (local.rotation * Vector3::x() * half_straight * LENGTH).into()),
                    radius: S::of(kit, radius * LENGTH),
                },
            };
            let count = match &sole {
                Sole::Corners(corners) => corners.len(),
                Sole::Ball(_) => 1,
                Sole::Cylinder { .. } => CYLINDER_SLOTS,
                Sole::Capsule { .. } => 2,
            };
            feet.push(Foot {
                body: piece.body,
                centre: V3::constant(kit, (local.translation.vector * LENGTH).into()),
                reach: S::of(kit, reach * LENGTH),
                friction: S::each(kit, |lane| worlds[lane].grip(piece.friction, settings)),
                slot: slots,
                sole,
            });
            first.push(slots);
            slots += count;
        }
        feet.retain(|foot| !matches!(&foot.sole, Sole::Corners(corners) if corners.is_empty()));
        Self { feet, slots, first }
    }

    /// The slots of the points of an element.
    pub(super) fn slots_of(&self, element: usize) -> std::ops::Range<usize> {
        let first = |element: usize| self.first.get(element).copied().unwrap_or(self.slots);
        first(element)..first(element + 1)
    }

    /// Hands over every point that is lower than the margin of its body.
    #[inline(always)]
    pub(super) fn find(
        &self,
        state: &State<S>,
        frames: &[Frame<S>],
        margin: impl Fn(usize) -> S,
        mut found: impl FnMut(Candidate<S>),
    ) {
        for foot in &self.feet {
            let frame = &frames[foot.body];
            let centre = frame.centre + frame.rotation * foot.centre;
            let height = state.position[1] + centre[1];
            let margin = margin(foot.body);
            let low = (height - foot.reach).less(margin);
            if low.any() {
                foot.find(frame, centre, height, margin, low, &mut found);
            }
        }
    }
}

impl<S: Scalar> Foot<S> {
    /// Looks only at the lanes where the foot is `low`.
    #[inline(always)]
    fn find(
        &self,
        frame: &Frame<S>,
        centre: V3<S>,
        height: S,
        margin: S,
        low: S::Mask,
        found: &mut impl FnMut(Candidate<S>),
    ) {
        let moving = frame.spin.cross(centre - frame.centre);
        let mut offers = Offers { foot: self, centre, moving, height, margin, found };
        let fixed = |way| (way, frame.spin.cross(way));
        match &self.sole {
            Sole::Ball(radius) => {
                let zero = radius.like(0.0);
                offers.add(0, (V3([zero, -*radius, zero]), V3([zero; 3])), low);
            }
            Sole::Capsule { end, radius } => {
                let end = frame.rotation * *end;
                for (slot, middle) in [end, end * height.like(-1.0)].into_iter().enumerate() {
                    // Below the middle of the end, wherever that goes.
                    let point = V3([middle[0], middle[1] - *radius, middle[2]]);
                    offers.add(slot, (point, frame.spin.cross(middle)), low);
                }
            }
            Sole::Corners(corners) => {
                for (slot, &corner) in corners.iter().enumerate() {
                    offers.add(slot, fixed(frame.rotation * corner), low);
                }
            }
            Sole::Cylinder { axis, half_length, radius, fan } => {
                offers.cylinder(frame, frame.rotation * *axis, *half_length, *radius, fan, low);
            }
        }
    }
}

/// Passes on the points of one foot that are low enough.
struct Offers<'a, S, F> {
    foot: &'a Foot<S>,
    centre: V3<S>,
    /// The velocity with which the centre of the foot moves against that of the body.
    moving: V3<S>,
    height: S,
    margin: S,
    found: &'a mut F,
}

impl<S: Scalar, F: FnMut(Candidate<S>)> Offers<'_, S, F> {
    /// The lowest points of a cylinder, by its axis, half its length and its radius; and those of its rims, by the way to each from
    /// the middle of its end, where it stands.
    #[inline(always)]
    fn cylinder(
        &mut self,
        frame: &Frame<S>,
        axis: V3<S>,
        half_length: S,
        radius: S,
        fan: &[V3<S>],
        low: S::Mask,
    ) {
        let k = |value: f64| radius.like(value);
        let level = (k(1.0) - axis[1] * axis[1]).max(k(0.0));
        let across = level.sqrt();
        let low = low & (self.height - axis[1].abs() * half_length - radius * across).less(self.margin);
        if !low.any() {
            return;
        }
        // Upright, the lowest point is nowhere in particular, and the
        // fixed ones carry.
        let tilted = low & k(1e-3).less(across);
        let upright = low & k(0.9).less(axis[1].abs());
        for end in 0..2 {
            let side = if end == 0 { half_length } else { -half_length };
            let middle = axis * side;
            if tilted.any() {
                let k = radius / across;
                let down = V3([axis[1] * axis[0] * k, -(level * k), axis[1] * axis[2] * k]);
                // The point follows the axis, not the rim.
                let nods = frame.spin.cross(axis);
                let swing = axis * nods[1] + nods * axis[1];
                let sinks = down * (axis[1] * nods[1] / level);
                let moving = nods * side + (swing * k + sinks);
                self.add(end, (middle + down, moving), tilted);
            }
            if upright.any() {
                for (place, &rim) in fan.iter().enumerate() {
                    let way = middle + frame.rotation * rim;
                    self.add(2 + end * FAN + place, (way, frame.spin.cross(way)), upright);
                }
            }
        }
    }

    /// A point that lies some way from the centre, against which it moves, if it is low enough in
    /// some of the lanes.
    #[inline(always)]
    fn add(&mut self, slot: usize, (way, moving): (V3<S>, V3<S>), lanes: S::Mask) {
        let gap = self.height + way[1];
        let lanes = lanes & gap.less(self.margin);
        if lanes.any() {
            let Foot { body, friction, slot: first, .. } = *self.foot;
            let point = self.centre + way;
            let moving = self.moving + moving;
            (self.found)(Candidate { body, point, moving, lanes, gap, friction, slot: first + slot });
        }
    }
}

fn cylinder<S: Scalar>(kit: S::Kit, local: &Isometry3<f64>, radius: f64, half_length: f64) -> Sole<S> {
    let vector = |v: Vector3<f64>| V3::constant(kit, v.into());
    let (up, side) = (local.rotation * Vector3::y(), local.rotation * Vector3::z());
    Sole::Cylinder {
        axis: vector(local.rotation * Vector3::x()),
        half_length: S::of(kit, half_length * LENGTH),
        radius: S::of(kit, radius * LENGTH),
        fan: [up, side, -up, -side].map(|way| vector(way * radius * LENGTH)),
    }
}

/// The corners of all boxes, to tell which of them are inside.
struct Hulls {
    /// Element, corner relative to the element's centre, corner in the body.
    corners: Vec<(usize, Vector3<f64>, Point3<f64>)>,
    keep: Vec<bool>,
}

impl Hulls {
    fn new(lowered: &Lowered) -> Self {
        let mut corners = Vec::new();
        for (index, piece) in lowered.pieces.iter().enumerate() {
            let Shape::Box { half } = piece.shape else { continue };
            for corner in 0..8 {
                let sign = |bit: usize| if corner >> bit & 1 == 0 { 1.0 } else { -1.0 };
                let way = half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
                corners.push((index, piece.local.rotation * way, piece.local * Point3::from(way)));
            }
        }
        let mut hulls = Self { keep: vec![true; corners.len()], corners };
        for corner in 0..hulls.keep.len() {
            hulls.keep[corner] = !hulls.inside(lowered, corner);
        }
        hulls
    }

    /// Whether a corner coincides with another that is kept, or lies on the
    /// line between two others; they must be of one body and one friction, or
    /// it would rub differently.
    fn inside(&self, lowered: &Lowered, corner: usize) -> bool {
        let (element, way, point) = &self.corners[corner];
        let own = &lowered.pieces[*element];
        let close = 1e-6 * way.norm();
        let others: Vec<_> = (0..self.corners.len())
            .filter(|&other| other != corner && self.keep[other])
            .filter(|&other| {
                let piece = &lowered.pieces[self.corners[other].0];
                piece.body == own.body && piece.friction == own.friction
            })
            .map(|other| self.corners[other].2 - point)
            .collect();
        others.iter().enumerate().any(|(place, a)| {
            a.norm() < close
                || others[..place]
                    .iter()
                    .any(|b| a.dot(b) < 0.0 && a.cross(b).norm() <= close * a.norm().max(b.norm()))
        })
    }

    fn corners<S: Scalar>(&self, kit: S::Kit, element: usize) -> Vec<V3<S>> {
        let own =
            self.corners.iter().zip(&self.keep).filter(|((owner, ..), keep)| *owner == element && **keep);
        own.map(|((_, way, _), _)| V3::constant(kit, (way * LENGTH).into())).collect()
    }
}

/// An upper bound of the speed of any point of a body with a reach.
#[inline(always)]
pub(super) fn top_speed<S: Scalar>(spin: V3<S>, velocity: V3<S>, reach: S) -> S {
    velocity.length() + spin.length() * reach
}
