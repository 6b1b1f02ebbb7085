//! Which parts of the body touch each other.
//!
//! Elements of different bodies may collide, except the two that a joint joins: its faces meet
//! there. Of elements with one joint between them only those collide that do not overlap at rest, as
//! `no_overlap` understands it (a wheel may be drawn over the shaft of its motor), and that the limits of the
//! joint let touch. Every
//! shape is its core plus a rounding: a ball is a point, a capsule a line, boxes and cylinders
//! are shrunk by a fifth of their smallest half size, so faces stay where they
//! are and only edges are rounded. The closest points of two cores are found
//! by alternating projections (von Neumann): the closest point of a box,
//! cylinder, line or point is a closed form, and going to and fro between two convex
//! sets converges to their distance. Each step goes on from the last one's
//! points. There is one contact per pair; where two faces meet flat it lies
//! anywhere on them. Pairs that overlap at rest by more than the roundings do
//! not collide; those that overlap less may overlap as much as they did.
//!
//! Most pairs are asleep. Each body has an odometer that counts how far it can have
//! moved (as the root sees it: tumbling as one piece brings nothing closer), and a
//! pair that had a gap is looked at again when its two bodies may have used it up.
//! That is asked of every pair in every step: one sum and one comparison. (To keep
//! those asleep that were far apart, by what the two fastest bodies can have moved,
//! costs more, the more so with many lanes: a pair is woken for any of them.)

use super::ground::top_speed;
use super::kinematics::{Frame, State, Velocity, place};
use super::scalar::{Mask, Scalar};
use super::tree::{LENGTH, Tree};
use super::vector::{M3, Quat, V3};
use crate::design::assembly::{Shape, TOUCHING, Travel};
use crate::simulate::World;
use crate::simulate::lowering::{Lowered, Piece};

/// How much of the smallest half size is rounding.
const ROUNDING: f64 = 0.2;
/// Rounds of projections in each step.
const PROJECTIONS: usize = 2;
/// The same at rest, with nothing to go on from.
const FIRST_PROJECTIONS: usize = 100;
/// Gap in cm below which a pair is a contact even when all is still.
const MARGIN: f64 = 0.02;
/// What rounding can add to or take from an odometer in a step, cm: far more than it does.
const SLACK: f64 = 0.005;

/// The shrunk shape about its centre.
#[derive(Clone, Copy, Debug)]
enum Core<S> {
    Point,
    /// Half sizes.
    Box(V3<S>),
    /// Half length along x and radius.
    Cylinder(S, S),
    /// Half length along x.
    Line(S),
}

impl<S: Scalar> Core<S> {
    #[inline(always)]
    fn closest(&self, p: V3<S>) -> V3<S> {
        let clamp = |value: S, most: S| value.min(most).max(-most);
        match *self {
            Self::Point => V3::null(p.kit()),
            Self::Box(half) => V3([clamp(p[0], half[0]), clamp(p[1], half[1]), clamp(p[2], half[2])]),
            Self::Cylinder(half_length, radius) => {
                let square = p[1] * p[1] + p[2] * p[2];
                let outside = (radius * radius).less(square);
                let k = S::pick(outside, radius / square.sqrt(), radius.like(1.0));
                V3([clamp(p[0], half_length), p[1] * k, p[2] * k])
            }
            Self::Line(half_length) => {
                let zero = p[0].like(0.0);
                V3([clamp(p[0], half_length), zero, zero])
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
    #[inline(always)]
    fn new(hull: &'a Hull<S>, frame: &Frame<S>, centre: V3<S>) -> Self {
        Self { hull, centre, rotation: frame.rotation * hull.rotation }
    }

    #[inline(always)]
    fn closest(&self, p: V3<S>) -> V3<S> {
        let local = self.rotation.transposed(p - self.centre);
        self.centre + self.rotation * self.hull.core.closest(local)
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

/// A contact between two bodies in some lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting<S: Scalar> {
    /// The lanes.
    pub(super) lanes: S::Mask,
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
    /// The two bodies of each pair.
    bodies: Vec<[u32; 2]>,
    /// Sum of its bodies' odometers at which each pair may touch.
    due: Vec<S>,
    /// How far each body can have moved.
    odometers: Vec<S>,
    /// How far each body can move in this step.
    travels: Vec<S>,
    /// The reading of each odometer after this step, and half of a margin.
    marks: Vec<S>,
    /// For each body, how far its elements reach from its centre.
    reach: Vec<S>,
}

impl<S: Scalar> Collisions<S> {
    /// From elements in SI units. What holds at rest is found in one lane, of the nominal world, and
    /// copied to all.
    pub(super) fn new(kit: S::Kit, lowered: &Lowered, worlds: &[World]) -> Self {
        let pairs: Vec<_> =
            pairs_at_rest(lowered).iter().map(|pair| pair.in_all_lanes(kit, worlds)).collect();
        Self {
            hulls: lowered.pieces.iter().map(|piece| hull(kit, piece)).collect(),
            bodies: pairs
                .iter()
                .map(|pair| [pair.first, pair.second].map(|piece| lowered.pieces[piece].body as u32))
                .collect(),
            due: vec![S::zero(kit); pairs.len()],
            odometers: vec![S::zero(kit); lowered.bodies.len()],
            travels: vec![S::zero(kit); lowered.bodies.len()],
            marks: vec![S::zero(kit); lowered.bodies.len()],
            at_rest: pairs.clone(),
            pairs,
            reach: reaches(kit, lowered),
        }
    }

    /// Number of pairs.
    pub(super) fn slots(&self) -> usize {
        self.pairs.len()
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        self.pairs.copy_from_slice(&self.at_rest);
        let zero = self.marks[0].like(0.0);
        self.due.fill(zero);
        self.odometers.fill(zero);
    }

    /// Hands over every pair that may touch within a step; `ahead` is how the
    /// bodies would move in it without contacts.
    #[inline(always)]
    pub(super) fn find(
        &mut self,
        frames: &[Frame<S>],
        ahead: &[Velocity<S>],
        step: S,
        mut found: impl FnMut(Meeting<S>),
    ) {
        self.travel(frames, ahead, step);
        let margin = step.like(MARGIN);
        for place in 0..self.pairs.len() {
            let [a, b] = self.bodies[place].map(|body| body as usize);
            if !self.due[place].at_most(self.marks[a] + self.marks[b]).any() {
                continue;
            }
            let moved = self.odometers[a] + self.odometers[b];
            let margin = self.travels[a] + self.travels[b] + margin;
            let due = (self.due[place] - moved).at_most(margin);
            if !due.any() {
                continue;
            }
            let (gap, meeting) = self.look(frames, place, margin, due);
            meeting.into_iter().for_each(&mut found);
            self.due[place] = S::pick(due, moved + gap, self.due[place]);
        }
    }

    /// Moves the odometers on by the step just made, whose speeds are the present
    /// ones, and says how far the bodies can move in the next.
    #[inline(always)]
    fn travel(&mut self, frames: &[Frame<S>], ahead: &[Velocity<S>], step: S) {
        let root = (Velocity::of(&frames[0]), ahead[0]);
        let half = step.like(MARGIN / 2.0 + SLACK);
        self.marks[0] = half;
        for (body, (frame, ahead)) in frames.iter().zip(ahead).enumerate().skip(1) {
            let past = self.relative_speed(body, frame, Velocity::of(frame), root.0) * step;
            let next = past.max(self.relative_speed(body, frame, *ahead, root.1) * step);
            self.odometers[body] += past;
            self.travels[body] = next;
            self.marks[body] = self.odometers[body] + next + half;
        }
    }

    /// The greatest speed of any point of a body as the root sees it.
    #[inline(always)]
    fn relative_speed(&self, body: usize, frame: &Frame<S>, own: Velocity<S>, root: Velocity<S>) -> S {
        let carried = root.velocity + root.spin.cross(frame.centre);
        top_speed(own.spin - root.spin, own.velocity - carried, self.reach[body])
    }

    /// A lower bound of the gap of a pair, and the contact where it is small, in
    /// the lanes that are awake.
    #[inline(always)]
    fn look(
        &mut self,
        frames: &[Frame<S>],
        place: usize,
        margin: S,
        awake: S::Mask,
    ) -> (S, Option<Meeting<S>>) {
        let pair = &mut self.pairs[place];
        let (a, b) = (&self.hulls[pair.first], &self.hulls[pair.second]);
        let (frame_a, frame_b) = (&frames[a.body], &frames[b.body]);
        let centre_a = frame_a.centre + frame_a.rotation * a.centre;
        let centre_b = frame_b.centre + frame_b.rotation * b.centre;
        let apart = (centre_a - centre_b).length() - a.reach - b.reach;
        let near = awake & apart.at_most(margin);
        if !near.any() {
            return (apart, None);
        }
        let (a, b) = (Placed::new(a, frame_a, centre_a), Placed::new(b, frame_b, centre_b));
        let start = frame_b.centre + frame_b.rotation * pair.witness;
        let (on_a, on_b) = project(&a, &b, start, PROJECTIONS);
        let witness = frame_b.rotation.transposed(on_b - frame_b.centre);
        pair.witness = V3::pick(near, witness, pair.witness);
        let way = on_a - on_b;
        let distance = way.length();
        // Inside each other there is no direction: keep the last one.
        let apart_enough = near & distance.like(1e-5).less(distance);
        pair.normal = V3::pick(apart_enough, way * (distance.like(1.0) / distance), pair.normal);
        let gap = distance - a.hull.rounding - b.hull.rounding + pair.overlap;
        let lanes = near & gap.at_most(margin);
        let half = gap.like(0.5);
        // The projections come from above: trust half of the gap.
        let bound = S::pick(near, S::pick(lanes, gap, gap * half), apart);
        if !lanes.any() {
            return (bound, None);
        }
        let middle = (on_a + on_b) * half;
        let offset = (b.hull.rounding - a.hull.rounding) * half;
        let meeting = Meeting {
            lanes,
            bodies: (a.hull.body, b.hull.body),
            normal: pair.normal,
            point: middle + pair.normal * offset,
            gap,
            friction: pair.friction,
            slot: place,
        };
        (bound, Some(meeting))
    }
}

impl Pair<f32> {
    /// The same in every lane.
    fn in_all_lanes<S: Scalar>(&self, kit: S::Kit, worlds: &[World]) -> Pair<S> {
        let normals: Vec<_> =
            worlds.iter().map(|world| world.turned(self.normal.0.map(f64::from).into())).collect();
        Pair {
            first: self.first,
            second: self.second,
            friction: S::each(kit, |lane| f64::from(self.friction) * worlds[lane].friction),
            overlap: S::of(kit, self.overlap.into()),
            witness: V3::constant(kit, self.witness.0.map(f64::from)),
            normal: V3([0, 1, 2].map(|axis| S::each(kit, |lane| normals[lane][axis]))),
        }
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
        let (before, after) = (first - on_b, second - first);
        (on_a, on_b) = (a.closest(second), second);
        let k = |value: f64| start[0].like(value);
        let ratio = before.dot(after) / (before.square() + k(1e-12));
        let ratio = ratio.max(k(0.0)).min(k(0.98));
        let jump = b.closest(second + after * (ratio / (k(1.0) - ratio)));
        let there = a.closest(jump);
        let (way, other) = (on_a - on_b, there - jump);
        let closer = other.square().less(way.square());
        (on_a, on_b) = (V3::pick(closer, there, on_a), V3::pick(closer, jump, on_b));
    }
    (on_a, b.closest(on_a))
}

/// The elements that may touch each other, the later one first.
pub(in crate::simulate) fn colliding(lowered: &Lowered) -> Vec<(usize, usize)> {
    pairs_at_rest(lowered).iter().map(|pair| (pair.first, pair.second)).collect()
}

/// All pairs that may collide, as they are before anything moves.
fn pairs_at_rest(lowered: &Lowered) -> Vec<Pair<f32>> {
    let tree = Tree::<f32>::new((), lowered, &[World::NOMINAL]);
    let mut frames = vec![Frame::null(()); lowered.bodies.len()];
    place(&tree, &State::new(&tree, V3::null(()), Quat::still(())), &mut frames);
    let hulls: Vec<Hull<f32>> = lowered.pieces.iter().map(|piece| hull((), piece)).collect();
    let mut pairs = Vec::new();
    for first in 0..hulls.len() {
        for second in 0..first {
            let joints = lowered.distance(hulls[first].body, hulls[second].body);
            if joints == 0 || (joints == 1 && lowered.are_joined(first, second)) {
                continue;
            }
            let friction = (lowered.pieces[first].friction * lowered.pieces[second].friction).sqrt();
            let Some((pair, gap)) = at_rest(&hulls, &frames, (first, second), friction) else { continue };
            let gap = f64::from(gap);
            let forgiven = (1.0 - TOUCHING) * f64::from(hulls[first].reach + hulls[second].reach);
            let may_touch = || gap < SLACK + approach(lowered, first, second) * LENGTH;
            if joints > 1 || (gap > -forgiven && may_touch()) {
                pairs.push(pair);
            }
        }
    }
    pairs
}

/// By how much two elements with one joint between them, one of which that joint carries, can come nearer to each other within its limits, m, at most.
fn approach(lowered: &Lowered, first: usize, second: usize) -> f64 {
    let (first, second) = (&lowered.pieces[first], &lowered.pieces[second]);
    let last = first.body.max(second.body);
    let other = first.body.min(second.body);
    let centre = |piece: &Piece| lowered.bodies[piece.body].centre + piece.local.translation.vector;
    let mut most = 0.0;
    let mut body = last;
    while body != other {
        let own = &lowered.bodies[body];
        body = own.parent;
        let Some(dof) = &own.dof else { continue };
        let far = dof.limits.0.abs().max(dof.limits.1.abs());
        most += match dof.travel {
            Travel::Slide => far,
            // Seen from the one, the other moves on arcs about the joint, and the other way round.
            Travel::Turn => {
                let arm = |piece: &Piece| (centre(piece) - dof.anchor.coords).norm() + piece.shape.reach();
                2.0 * arm(first).min(arm(second)) * libm::sin(far.min(std::f64::consts::PI) / 2.0)
            }
        };
    }
    most
}

/// What a pair is like before anything moves, and its gap; none if it overlaps too much to collide.
fn at_rest(
    hulls: &[Hull<f32>],
    frames: &[Frame<f32>],
    (first, second): (usize, usize),
    friction: f64,
) -> Option<(Pair<f32>, f32)> {
    let placed = |hull: &'_ Hull<f32>| {
        let frame = &frames[hull.body];
        frame.centre + frame.rotation * hull.centre
    };
    let (a, b) = (&hulls[first], &hulls[second]);
    let (frame_a, frame_b) = (&frames[a.body], &frames[b.body]);
    let (a, b) = (Placed::new(a, frame_a, placed(a)), Placed::new(b, frame_b, placed(b)));
    let (on_a, on_b) = project(&a, &b, b.centre, FIRST_PROJECTIONS);
    let way = on_a - on_b;
    let distance = way.length();
    if distance <= 1e-4 {
        return None;
    }
    let gap = distance - a.hull.rounding - b.hull.rounding;
    let pair = Pair {
        first,
        second,
        friction: friction as f32,
        overlap: (-gap).max(0.0),
        witness: frame_b.rotation.transposed(on_b - frame_b.centre),
        normal: way * (1.0 / distance),
    };
    Some((pair, gap))
}

fn hull<S: Scalar>(kit: S::Kit, piece: &Piece) -> Hull<S> {
    let of = |metres: f64| S::of(kit, metres * LENGTH);
    let turn = piece.local.rotation.to_rotation_matrix();
    let m = turn.matrix();
    let (core, rounding) = match piece.shape {
        Shape::Box { half } => {
            let rounding = half.min() * ROUNDING;
            (Core::Box(V3([0, 1, 2].map(|axis| of(half[axis] - rounding)))), rounding)
        }
        Shape::Ball { radius } => (Core::Point, radius),
        Shape::Cylinder { radius, half_length } => {
            let rounding = radius.min(half_length) * ROUNDING;
            (Core::Cylinder(of(half_length - rounding), of(radius - rounding)), rounding)
        }
        Shape::Capsule { radius, half_straight } => (Core::Line(of(half_straight)), radius),
    };
    Hull {
        body: piece.body,
        centre: V3::constant(kit, (piece.local.translation.vector * LENGTH).into()),
        rotation: M3([0, 1, 2].map(|row| V3::constant(kit, [m[(row, 0)], m[(row, 1)], m[(row, 2)]]))),
        core,
        rounding: of(rounding),
        reach: of(piece.shape.reach()),
    }
}

/// How far the elements of each body reach from its centre, cm.
pub(super) fn reaches<S: Scalar>(kit: S::Kit, lowered: &Lowered) -> Vec<S> {
    let mut reach = vec![0.0_f64; lowered.bodies.len()];
    for piece in &lowered.pieces {
        let own = &mut reach[piece.body];
        *own = own.max(piece.local.translation.vector.norm() + piece.shape.reach());
    }
    reach.into_iter().map(|own| S::of(kit, own * LENGTH)).collect()
}
