//! Which parts of the body touch each other.
//!
//! Elements of different bodies may collide, except the two that a joint joins: its faces meet
//! there. Of elements with one joint between them only those collide that do not overlap at rest, as
//! `no_overlap` understands it (a wheel may be drawn over the shaft of its motor), and that the limits of the
//! joint let touch.
//!
//! The closest points of two hulls (`hull`) go on from the last step's. Where they touch there is a contact, and more where
//! the rim of the smaller one's face meets the other: on a single one, which jumps from one end of the faces to the other in
//! a step, faces would rock for ever, and be pushed apart again where they overlap by then. Pairs that
//! overlap at rest by more than the roundings do
//! not collide; those that overlap less may overlap as much as they did.
//!
//! Most pairs are asleep. Each body has an odometer that counts how far it can have
//! moved (as the root sees it: tumbling as one piece brings nothing closer), and a
//! pair that had a gap is looked at again when its two bodies may have used it up.
//! That is asked of every pair in every step: one sum and one comparison. (To keep
//! those asleep that were far apart, by what the two fastest bodies can have moved,
//! costs more, the more so with many lanes: a pair is woken for any of them.)

use super::ground::top_speed;
use super::hull::{Hull, Placed, project};
use super::kinematics::{Frame, State, Velocity, place};
use super::scalar::{Mask, Scalar};
use super::tree::{LENGTH, Tree};
use super::vector::{Quat, V3};
use crate::design::assembly::{TOUCHING, Travel};
use crate::simulate::World;
use crate::simulate::lowering::{Lowered, Piece};

/// Rounds of projections in each step.
const PROJECTIONS: usize = 2;
/// The same at rest, with nothing to go on from.
const FIRST_PROJECTIONS: usize = 100;
/// Gap in cm below which a pair is a contact even when all is still.
const MARGIN: f64 = 0.02;
/// What rounding can add to or take from an odometer in a step, cm: far more than it does.
const SLACK: f64 = 0.005;
/// Contacts of a pair at most: at the closest points, and at the rim of a face.
const CONTACTS: usize = 5;
/// A point of the rim that is nearer to the closest one than this share of the reach is no other contact.
const SAME: f64 = 0.02;

/// Two elements that may collide.
#[derive(Clone, Copy, Debug)]
struct Pair<S> {
    first: usize,
    second: usize,
    /// Whether the rim of the first is looked at, and of how many points it is.
    rim: (bool, usize),
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
    /// Number of the contact, the same from step to step.
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
            hulls: lowered.pieces.iter().map(|piece| Hull::new(kit, piece)).collect(),
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

    /// Number of contacts that there can be.
    pub(super) fn slots(&self) -> usize {
        self.pairs.len() * CONTACTS
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
            let gap = self.look(frames, place, margin, due, &mut found);
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

    /// A lower bound of the gap of a pair; hands over its contacts where it is small, in
    /// the lanes that are awake.
    #[inline(always)]
    fn look(
        &mut self,
        frames: &[Frame<S>],
        place: usize,
        margin: S,
        awake: S::Mask,
        mut found: impl FnMut(Meeting<S>),
    ) -> S {
        let pair = &mut self.pairs[place];
        let (a, b) = (&self.hulls[pair.first], &self.hulls[pair.second]);
        let frame_b = &frames[b.body];
        let (a, b) = (Placed::new(a, &frames[a.body]), Placed::new(b, frame_b));
        let apart = (a.centre - b.centre).length() - a.hull.reach - b.hull.reach;
        let near = awake & apart.at_most(margin);
        if !near.any() {
            return apart;
        }
        let start = frame_b.centre + frame_b.rotation * pair.witness;
        let closest = project(&a, &b, start, PROJECTIONS);
        let witness = frame_b.rotation.transposed(closest.1 - frame_b.centre);
        pair.witness = V3::pick(near, witness, pair.witness);
        let (gap, mut meeting) = pair.meet(&a, &b, closest, near);
        pair.normal = meeting.normal;
        meeting.lanes = near & gap.at_most(margin);
        meeting.slot = place * CONTACTS;
        // The projections come from above: trust half of the gap.
        let bound = S::pick(near, S::pick(meeting.lanes, gap, gap * gap.like(0.5)), apart);
        if !meeting.lanes.any() {
            return bound;
        }
        found(meeting);
        let (inner, outer) = if pair.rim.0 { (&a, &b) } else { (&b, &a) };
        let towards = pair.normal * gap.like(if pair.rim.0 { -1.0 } else { 1.0 });
        let same = inner.hull.reach * gap.like(SAME);
        for number in 0..pair.rim.1 {
            let over = outer.closest(inner.rim(towards, number));
            let under = inner.closest(over);
            let points = if pair.rim.0 { (under, over) } else { (over, under) };
            let (gap, mut further) = pair.meet(&a, &b, points, near);
            let is_other = (same * same).less((points.0 - closest.0).square());
            further.lanes = meeting.lanes & gap.at_most(margin) & is_other;
            further.slot = meeting.slot + 1 + number;
            if further.lanes.any() {
                found(further);
            }
        }
        bound
    }
}

impl<S: Scalar> Pair<S> {
    /// The gap and the contact of a point of the first core and one of the second.
    #[inline(always)]
    fn meet(
        &self,
        a: &Placed<'_, S>,
        b: &Placed<'_, S>,
        (on_a, on_b): (V3<S>, V3<S>),
        lanes: S::Mask,
    ) -> (S, Meeting<S>) {
        let way = on_a - on_b;
        let distance = way.length();
        let half = distance.like(0.5);
        // Inside each other there is no direction: keep the last one.
        let is_apart = lanes & distance.like(1e-5).less(distance);
        let normal = V3::pick(is_apart, way * (distance.like(1.0) / distance), self.normal);
        let gap = distance - a.hull.rounding - b.hull.rounding + self.overlap;
        let offset = (b.hull.rounding - a.hull.rounding) * half;
        let point = (on_a + on_b) * half + normal * offset;
        let bodies = (a.hull.body, b.hull.body);
        (gap, Meeting { lanes, bodies, normal, point, gap, friction: self.friction, slot: 0 })
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
            rim: self.rim,
            friction: S::each(kit, |lane| f64::from(self.friction) * worlds[lane].friction),
            overlap: S::of(kit, self.overlap.into()),
            witness: V3::constant(kit, self.witness.0.map(f64::from)),
            normal: V3([0, 1, 2].map(|axis| S::each(kit, |lane| normals[lane][axis]))),
        }
    }
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
    let hulls: Vec<Hull<f32>> = lowered.pieces.iter().map(|piece| Hull::new((), piece)).collect();
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
    let (a, b) = (&hulls[first], &hulls[second]);
    let frame_b = &frames[b.body];
    let (a, b) = (Placed::new(a, &frames[a.body]), Placed::new(b, frame_b));
    let (on_a, on_b) = project(&a, &b, b.centre, FIRST_PROJECTIONS);
    let way = on_a - on_b;
    let distance = way.length();
    if distance <= 1e-4 {
        return None;
    }
    let gap = distance - a.hull.rounding - b.hull.rounding;
    let is_first_inner = (a.hull.rim(), a.hull.reach) < (b.hull.rim(), b.hull.reach);
    let pair = Pair {
        first,
        second,
        rim: (is_first_inner, a.hull.rim().min(b.hull.rim())),
        friction: friction as f32,
        overlap: (-gap).max(0.0),
        witness: frame_b.rotation.transposed(on_b - frame_b.centre),
        normal: way * (1.0 / distance),
    };
    Some((pair, gap))
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
