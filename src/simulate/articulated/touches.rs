//! The points that may touch something in this step, gathered over all lanes.
//!
//! Different runs touch the ground with different points of the body. If every
//! point that touches in any lane had rows in all of them, most rows would be
//! idle. So the points of a limb are gathered lane by lane: the first contact of
//! each lane, the second, and so on. They may lie on different bodies of the limb,
//! but all on the path to its tip, and so share their degrees of freedom. Contacts
//! between bodies are gathered by the two limbs that they are on.

use super::places::Places;
use super::scalar::{Mask, Scalar, lanes_of};
use super::tree::{ROOT, Tree};
use super::vector::V3;

/// The most lanes that any number has.
pub(super) const MOST_LANES: usize = 16;
/// The slot of a lane without a contact.
pub(super) const NO_SLOT: u32 = u32::MAX;

/// What it takes to make the rows of a contact, in each lane that has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch<S> {
    /// Contact point relative to the root's centre; null in a lane without the contact.
    pub(super) point: V3<S>,
    /// Velocity along the normal at which the gap closes in this step is
    /// minus this; negative where the surfaces are to be pushed apart.
    pub(super) allowance: S,
    /// Velocities along the two tangents with which the point slides for all that, in the mean over the
    /// step, if it does not at its beginning.
    pub(super) slip: [S; 2],
    /// Friction coefficient.
    pub(super) friction: S,
    /// How many degrees of freedom of the path move the point; zero in a lane
    /// without the contact.
    pub(super) depth: S,
    /// The largest of them over all lanes.
    pub(super) deepest: usize,
    /// Which slot remembers the impulse from step to step, by lane.
    pub(super) slots: [u32; MOST_LANES],
}

impl<S: Scalar> Touch<S> {
    #[inline(always)]
    fn null(kit: S::Kit) -> Self {
        let zero = S::zero(kit);
        let point = V3::null(kit);
        let slots = [NO_SLOT; MOST_LANES];
        Self { point, allowance: zero, slip: [zero; 2], friction: zero, depth: zero, deepest: 0, slots }
    }

    /// Takes over the contact of one lane.
    #[inline(always)]
    fn set(
        &mut self,
        lane: usize,
        (point, allowance, slip, friction): (&V3<S>, &S, &[S; 2], &S),
        depth: usize,
        slot: usize,
    ) {
        self.point.copy_lane(lane, point);
        self.allowance.copy_lane(lane, allowance);
        self.slip.iter_mut().zip(slip).for_each(|(own, slip)| own.copy_lane(lane, slip));
        self.friction.copy_lane(lane, friction);
        self.depth.set_lane(lane, depth as f64);
        self.deepest = self.deepest.max(depth);
        self.slots[lane] = slot as u32;
    }
}

/// A contact of two bodies, which are on the same two limbs in all lanes that have it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<S> {
    /// The contact, with the depth of the body on the first limb.
    pub(super) touch: Touch<S>,
    /// The limbs, which may be the same.
    limbs: (usize, usize),
    /// The bodies at the ends of their paths.
    pub(super) tips: (usize, usize),
    /// The depth of the body on the second limb; zero in a lane without the contact.
    pub(super) depth: S,
    /// The largest of them over all lanes.
    pub(super) deepest: usize,
    /// Across the surfaces.
    pub(super) normal: V3<S>,
    /// 1 where it points to the body on the first limb, -1 where to that on the second.
    pub(super) side: S,
}

/// The contacts with the ground of the bodies on one path.
#[derive(Clone, Debug)]
pub(super) struct Limb<S> {
    /// The body at the end of the path.
    pub(super) tip: usize,
    /// The contacts.
    pub(super) touches: Places<Touch<S>>,
    /// How many of them each lane has.
    counts: [usize; MOST_LANES],
}

/// All contacts of a step. Emptied, never freed.
#[derive(Clone, Debug)]
pub(super) struct Touches<S: Scalar> {
    kit: S::Kit,
    /// The root, then a limb for each tip.
    pub(super) limbs: Vec<Limb<S>>,
    /// The limb and the depth of each body.
    places: Vec<(usize, usize)>,
    /// Contacts between bodies.
    pub(super) pairs: Places<Pair<S>>,
    /// For each lane, the place in them after its last one.
    last: [usize; MOST_LANES],
}

impl<S: Scalar> Touches<S> {
    /// Room for the contacts of a tree.
    pub(super) fn new(tree: &Tree<S>) -> Self {
        let limb = |tip| Limb { tip, touches: Places::new(16), counts: [0; MOST_LANES] };
        let bodies = tree.links.len();
        let (mut limbs, mut places) = (vec![limb(0)], vec![(0, ROOT); bodies]);
        // Children have higher numbers: a body that no limb has reached is a tip.
        for tip in (1..bodies).rev() {
            if places[tip].0 != 0 {
                continue;
            }
            let mut body = tip;
            while body != 0 && places[body].0 == 0 {
                places[body] = (limbs.len(), tree.path(body).len());
                body = tree.links[body].parent;
            }
            limbs.push(limb(tip));
        }
        Self { kit: tree.kit, limbs, places, pairs: Places::new(bodies), last: [0; MOST_LANES] }
    }

    /// Forgets the contacts of the last step.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        for limb in &mut self.limbs {
            limb.touches.clear();
            limb.counts = [0; MOST_LANES];
        }
        self.pairs.clear();
        self.last = [0; MOST_LANES];
    }

    /// Adds a contact with the ground in some lanes.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        lanes: S::Mask,
        body: usize,
        slot: usize,
        point: V3<S>,
        (allowance, slip): (S, [S; 2]),
        friction: S,
    ) {
        let (limb, depth) = self.places[body];
        let limb = &mut self.limbs[limb];
        for lane in lanes_of(lanes.bits()) {
            let place = limb.counts[lane];
            limb.counts[lane] += 1;
            if place == limb.touches.len() {
                limb.touches.push(Touch::null(self.kit));
            }
            let touch = &mut limb.touches[place];
            touch.set(lane, (&point, &allowance, &slip, &friction), depth, slot);
        }
    }

    /// Adds a contact between two bodies in some lanes; the normal points from the
    /// second to the first. Each lane keeps the order in which its contacts come.
    #[inline(always)]
    pub(super) fn add_pair(
        &mut self,
        lanes: S::Mask,
        (a, b): (usize, usize),
        slot: usize,
        (point, normal): (V3<S>, V3<S>),
        allowance: S,
        friction: S,
    ) {
        let (a, b) = (self.places[a], self.places[b]);
        let (side, (first, depth), (second, other)) = if a.0 < b.0 { (-1.0, b, a) } else { (1.0, a, b) };
        let limbs = (first, second);
        for lane in lanes_of(lanes.bits()) {
            let later = self.pairs.iter().skip(self.last[lane]).position(|pair| pair.limbs == limbs);
            let place = later.map_or(self.pairs.len(), |later| self.last[lane] + later);
            self.last[lane] = place + 1;
            let zero = S::zero(self.kit);
            if place == self.pairs.len() {
                let touch = Touch::null(self.kit);
                let tips = (self.limbs[first].tip, self.limbs[second].tip);
                let normal = V3::null(self.kit);
                self.pairs.push(Pair { touch, limbs, tips, depth: zero, deepest: 0, normal, side: zero });
            }
            let pair = &mut self.pairs[place];
            pair.touch.set(lane, (&point, &allowance, &[zero; 2], &friction), depth, slot);
            pair.normal.copy_lane(lane, &normal);
            pair.depth.set_lane(lane, other as f64);
            pair.deepest = pair.deepest.max(other);
            pair.side.set_lane(lane, side);
        }
    }
}
