//! Which parts of the body touch each other.
//!
//! Elements whose bodies are at least two hinges apart may collide. Every
//! shape is its core plus a rounding: a ball is a point, boxes and cylinders
//! are shrunk by a fifth of their smallest half size, so faces stay where they
//! are and only edges are rounded. The closest points of two cores are found
//! by alternating projections (von Neumann): the closest point of a box,
//! cylinder or point is a closed form, and going to and fro between two convex
//! sets converges to their distance. Each step goes on from the last one's
//! points. There is one contact per pair; where two faces meet flat it lies
//! anywhere on them. Pairs that overlap at rest by more than the roundings do
//! not collide; those that overlap less may overlap as much as they did.
//!
//! Most pairs are asleep: an odometer counts how far any two bodies can have
//! moved towards each other, and a pair that had a gap is looked at again when
//! half of it may be used up.

use super::ground::top_speed;
use super::kinematics::{Frame, Velocity};
use super::scalar::Scalar;
use super::tree::LENGTH;
use super::vector::{M3, V3, add, apply, apply_transposed, cross, dot, length, product, scale, sub};
use crate::design::assembly::Shape;
use crate::simulate::lowering::{Lowered, Piece};

/// How much of the smallest half size is rounding.
const ROUNDING: f64 = 0.2;
/// Rounds of projections in each step.
const PROJECTIONS: usize = 2;
/// The same at rest, with nothing to go on from.
const FIRST_PROJECTIONS: usize = 100;
/// Gap in cm below which a pair is a contact even when all is still.
const MARGIN: f64 = 0.02;

/// The shrunk shape about its centre.
#[derive(Clone, Copy, Debug)]
enum Core<S> {
    Point,
    Box(V3<S>),
    /// Half length along x and radius.
    Cylinder(S, S),
}

impl<S: Scalar> Core<S> {
    #[inline(always)]
    fn closest(&self, p: V3<S>) -> V3<S> {
        let clamp = |value: S, most: S| value.min(most).max(-most);
        match *self {
            Self::Point => [S::ZERO; 3],
            Self::Box(half) => [clamp(p[0], half[0]), clamp(p[1], half[1]), clamp(p[2], half[2])],
            Self::Cylinder(half_length, radius) => {
                let square = p[1] * p[1] + p[2] * p[2];
                let k = if square > radius * radius { radius / square.sqrt() } else { S::ONE };
                [clamp(p[0], half_length), p[1] * k, p[2] * k]
            }
        }
    }
}

/// An element as the collision sees it.
#[derive(Clone, Copy, Debug)]
struct Hull<S> {
    body: usize,
    centre: V3<S>,
    /// Element axes in the body's frame.
    rotation: M3<S>,
    core: Core<S>,
    rounding: S,
    /// Radius of a ball that holds all of it.
    reach: S,
}

/// Where a hull is now.
#[derive(Clone, Copy)]
struct Placed<'a, S> {
    hull: &'a Hull<S>,
    centre: V3<S>,
    rotation: M3<S>,
}

impl<'a, S: Scalar> Placed<'a, S> {
    fn new(hull: &'a Hull<S>, frame: &Frame<S>, centre: V3<S>) -> Self {
        Self { hull, centre, rotation: product(&frame.rotation, &hull.rotation) }
    }

    #[inline(always)]
    fn closest(&self, p: V3<S>) -> V3<S> {
        let local = apply_transposed(&self.rotation, sub(p, self.centre));
        add(self.centre, apply(&self.rotation, self.hull.core.closest(local)))
    }
}

/// Two elements that may collide.
#[derive(Clone, Copy, Debug)]
struct Pair<S> {
    first: usize,
    second: usize,
    friction: S,
    /// How deep they overlap at rest.
    overlap: S,
    /// Where the last closest point was on the second, in its body's frame.
    witness: V3<S>,
    /// The last normal.
    normal: V3<S>,
}

/// A contact between two bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting<S> {
    /// The two bodies.
    pub(super) bodies: (usize, usize),
    /// From the second to the first.
    pub(super) normal: V3<S>,
    /// Half way between the surfaces, relative to the root's centre.
    pub(super) point: V3<S>,
    /// Distance of the surfaces; negative where they overlap.
    pub(super) gap: S,
    /// Friction coefficient.
    pub(super) friction: S,
    /// Number of the pair.
    pub(super) slot: usize,
}

/// All pairs of an assembly.
#[derive(Clone, Debug)]
pub(super) struct Collisions<S> {
    hulls: Vec<Hull<S>>,
    pairs: Vec<Pair<S>>,
    at_rest: Vec<Pair<S>>,
    /// Odometer reading at which each pair wakes up.
    wake: Vec<S>,
    odometer: S,
    /// For each body, how far its elements reach from its centre.
    reach: Vec<S>,
}

impl<S: Scalar> Collisions<S> {
    /// From elements in SI units and the frames at rest.
    pub(super) fn new(lowered: &Lowered, frames: &[Frame<S>]) -> Self {
        let hulls: Vec<Hull<S>> = lowered.pieces.iter().map(hull).collect();
        let mut pairs = Vec::new();
        for first in 0..hulls.len() {
            for second in 0..first {
                if lowered.distance(hulls[first].body, hulls[second].body) >= 2 {
                    let friction = (lowered.pieces[first].friction * lowered.pieces[second].friction).sqrt();
                    pairs.extend(at_rest(&hulls, frames, (first, second), friction));
                }
            }
        }
        let wake = vec![S::ZERO; pairs.len()];
        let reach = reaches(lowered);
        Self { hulls, at_rest: pairs.clone(), pairs, wake, odometer: S::ZERO, reach }
    }

    /// Number of pairs.
    pub(super) fn slots(&self) -> usize {
        self.pairs.len()
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        self.pairs.copy_from_slice(&self.at_rest);
        self.wake.fill(S::ZERO);
        self.odometer = S::ZERO;
    }

    /// Hands over every pair that may touch within a step; `ahead` is how the
    /// bodies would move in it without contacts.
    pub(super) fn find(
        &mut self,
        frames: &[Frame<S>],
        ahead: &[Velocity<S>],
        step: S,
        mut found: impl FnMut(Meeting<S>),
    ) {
        let now = frames.iter().map(|frame| Velocity { spin: frame.spin, velocity: frame.velocity });
        let moved = self.travel(frames, now, step);
        let travel = moved.max(self.travel(frames, ahead.iter().copied(), step));
        // The present speeds are those of the step just made.
        self.odometer += moved;
        let margin = travel + S::of(MARGIN);
        for place in 0..self.pairs.len() {
            if self.wake[place] > self.odometer + margin {
                continue;
            }
            let (gap, meeting) = self.look(frames, place, margin);
            if let Some(meeting) = meeting {
                found(meeting);
            }
            self.wake[place] = self.odometer + gap;
        }
    }

    /// How far two bodies can approach each other in a step. Speeds are taken
    /// as the root sees them: tumbling as one piece brings nothing closer.
    fn travel(&self, frames: &[Frame<S>], moves: impl Iterator<Item = Velocity<S>>, step: S) -> S {
        let mut root = Velocity::default();
        let mut most = S::ZERO;
        for (body, own) in moves.enumerate() {
            if body == 0 {
                root = own;
                continue;
            }
            let carried = add(root.velocity, cross(root.spin, frames[body].centre));
            let velocity = sub(own.velocity, carried);
            most = most.max(top_speed(sub(own.spin, root.spin), velocity, self.reach[body]));
        }
        most * step * S::of(2.0)
    }

    /// A lower bound of the gap of a pair, and the contact if it is small.
    fn look(&mut self, frames: &[Frame<S>], place: usize, margin: S) -> (S, Option<Meeting<S>>) {
        let pair = &mut self.pairs[place];
        let (a, b) = (&self.hulls[pair.first], &self.hulls[pair.second]);
        let (frame_a, frame_b) = (&frames[a.body], &frames[b.body]);
        let centre_a = add(frame_a.centre, apply(&frame_a.rotation, a.centre));
        let centre_b = add(frame_b.centre, apply(&frame_b.rotation, b.centre));
        let apart = length(sub(centre_a, centre_b)) - a.reach - b.reach;
        if apart > margin {
            return (apart, None);
        }
        let (a, b) = (Placed::new(a, frame_a, centre_a), Placed::new(b, frame_b, centre_b));
        let start = add(frame_b.centre, apply(&frame_b.rotation, pair.witness));
        let (on_a, on_b) = project(&a, &b, start, PROJECTIONS);
        pair.witness = apply_transposed(&frame_b.rotation, sub(on_b, frame_b.centre));
        let way = sub(on_a, on_b);
        let distance = length(way);
        // Inside each other there is no direction: keep the last one.
        if distance > S::of(1e-5) {
            pair.normal = scale(way, S::ONE / distance);
        }
        let gap = distance - a.hull.rounding - b.hull.rounding + pair.overlap;
        if gap > margin {
            // The projections come from above: trust half of the gap.
            return (gap * S::of(0.5), None);
        }
        let half = S::of(0.5);
        let middle = scale(add(on_a, on_b), half);
        let offset = (b.hull.rounding - a.hull.rounding) * half;
        let meeting = Meeting {
            bodies: (a.hull.body, b.hull.body),
            normal: pair.normal,
            point: add(middle, scale(pair.normal, offset)),
            gap,
            friction: pair.friction,
            slot: place,
        };
        (gap, Some(meeting))
    }
}

/// The closest points of two cores, starting from a point of the second.
///
/// Where faces meet at a small angle the alternation creeps along them in a
/// geometric series. Each round therefore ends with a jump to the limit of that
/// series (Aitken), taken back where the cores are further apart there.
#[inline(always)]
fn project<S: Scalar>(a: &Placed<'_, S>, b: &Placed<'_, S>, start: V3<S>, rounds: usize) -> (V3<S>, V3<S>) {
    let mut on_b = start;
    let mut on_a = a.closest(on_b);
    for _ in 0..rounds {
        let first = b.closest(on_a);
        let second = b.closest(a.closest(first));
        let (before, after) = (sub(first, on_b), sub(second, first));
        (on_a, on_b) = (a.closest(second), second);
        let ratio = dot(before, after) / (dot(before, before) + S::of(1e-12));
        let ratio = ratio.max(S::ZERO).min(S::of(0.98));
        let jump = b.closest(add(second, scale(after, ratio / (S::ONE - ratio))));
        let there = a.closest(jump);
        let (way, other) = (sub(on_a, on_b), sub(there, jump));
        if dot(other, other) < dot(way, way) {
            (on_a, on_b) = (there, jump);
        }
    }
    (on_a, b.closest(on_a))
}

fn at_rest<S: Scalar>(
    hulls: &[Hull<S>],
    frames: &[Frame<S>],
    (first, second): (usize, usize),
    friction: f64,
) -> Option<Pair<S>> {
    let placed = |hull: &'_ Hull<S>| {
        let frame = &frames[hull.body];
        add(frame.centre, apply(&frame.rotation, hull.centre))
    };
    let (a, b) = (&hulls[first], &hulls[second]);
    let (frame_a, frame_b) = (&frames[a.body], &frames[b.body]);
    let (a, b) = (Placed::new(a, frame_a, placed(a)), Placed::new(b, frame_b, placed(b)));
    let (on_a, on_b) = project(&a, &b, b.centre, FIRST_PROJECTIONS);
    let way = sub(on_a, on_b);
    let distance = length(way);
    if distance <= S::of(1e-4) {
        return None;
    }
    let gap = distance - a.hull.rounding - b.hull.rounding;
    Some(Pair {
        first,
        second,
        friction: S::of(friction),
        overlap: (-gap).max(S::ZERO),
        witness: apply_transposed(&frame_b.rotation, sub(on_b, frame_b.centre)),
        normal: scale(way, S::ONE / distance),
    })
}

fn hull<S: Scalar>(piece: &Piece) -> Hull<S> {
    let turn = piece.local.rotation.to_rotation_matrix();
    let m = turn.matrix();
    let centre = piece.local.translation.vector * LENGTH;
    let (core, rounding) = match piece.shape {
        Shape::Box { half } => {
            let rounding = half.min() * ROUNDING;
            let core = half.map(|size| (size - rounding) * LENGTH);
            (Core::Box([S::of(core.x), S::of(core.y), S::of(core.z)]), rounding)
        }
        Shape::Ball { radius } => (Core::Point, radius),
        Shape::Cylinder { radius, half_length } => {
            let rounding = radius.min(half_length) * ROUNDING;
            let shrunk = |size: f64| S::of((size - rounding) * LENGTH);
            (Core::Cylinder(shrunk(half_length), shrunk(radius)), rounding)
        }
    };
    Hull {
        body: piece.body,
        centre: [S::of(centre.x), S::of(centre.y), S::of(centre.z)],
        rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| S::of(m[(row, column)]))),
        core,
        rounding: S::of(rounding * LENGTH),
        reach: S::of(radius_of(piece) * LENGTH),
    }
}

/// Radius of the ball about an element's centre that holds it, m.
fn radius_of(piece: &Piece) -> f64 {
    match piece.shape {
        Shape::Box { half } => half.norm(),
        Shape::Ball { radius } => radius,
        Shape::Cylinder { radius, half_length } => radius.hypot(half_length),
    }
}

/// How far the elements of each body reach from its centre, cm.
pub(super) fn reaches<S: Scalar>(lowered: &Lowered) -> Vec<S> {
    let mut reach = vec![0.0_f64; lowered.bodies.len()];
    for piece in &lowered.pieces {
        let own = &mut reach[piece.body];
        *own = own.max(piece.local.translation.vector.norm() + radius_of(piece));
    }
    reach.into_iter().map(|own| S::of(own * LENGTH)).collect()
}
