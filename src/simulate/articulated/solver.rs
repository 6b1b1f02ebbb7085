//! One time step of a tree.

use super::collide::{Collisions, reaches};
use super::energy::{Ledger, doubt, energy};
use super::factor::Factor;
use super::ground::{Ground, top_speed};
use super::inertia::{Composite, mass_matrix, turn_inertias};
use super::joints::Joints;
use super::kinematics::{Frame, State, Velocity, move_on, place};
use super::momentum::{Momenta, Wrench, carry, gather};
use super::pgs::{self, Unrest};
use super::rows::Rows;
use super::scalar::{Mask, Scalar, lanes_of};
use super::stride::{Pose, Stride, Way, stride};
use super::touches::{NO_SLOT, Touches};
use super::tree::{LENGTH, ROOT, Tree};
use super::vector::{Quat, Sym, V3};
use crate::simulate::contacts::Sweeps;
use crate::simulate::lowering::Lowered;
use crate::simulate::{Invalid, Settings, World};

/// Overlap in cm that is left alone, so that resting contacts stay contacts.
const SLOP: f64 = 0.002;
/// The share of an overlap that one step mends.
const MEND: f64 = 0.2;
/// Fastest mending in cm/s: a deep overlap must not become a jump.
const MEND_SPEED: f64 = 20.0;
/// Gap in cm below which a point is a contact even when all is still.
const MARGIN: f64 = 0.02;

/// What is left unsolved is measured by what all rows give, but by no more than contacts give that carry the tree: parts that
/// squeeze each other by a hundred times its weight would else leave its feet unsolved, and it would creep, and its servos work for
/// nothing. On ten points, each carries a tenth: together a tenth of the mass times the square of what a fall gains in a step.
const CARRIED: f64 = 0.1;
/// What turns too far in so many steps on end is refused. A blow makes a body turn so fast for a few.
const WHIRLS: f64 = 20.0;
/// Steps between two looks at the energy.
const AUDIT: u32 = 8;
/// Times a step is solved at most while servos come to or leave their limits, and strides settle.
const PASSES: usize = 12;
/// Strides that differ from those that the step was solved with by no more than this share of all
/// velocities, squared, and by what the contacts may be off, are left as they are: what is missing comes with the
/// next step.
const SETTLED: f64 = 1e-9;
/// Where they differ by more than this at first, squared, the next ones are not foreseen as going on as they did.
const WILD: f64 = 1e-4;
/// A pass that does not bring the strides nearer by this, squared, is the last: limbs turn so far in a step that
/// further ones may lead away. What is missing comes late, which takes energy and gives next to none.
const NEARER: f64 = 0.1;

/// A tree, its surroundings and all room that a step needs.
#[derive(Clone, Debug)]
pub(super) struct Solver<S: Scalar> {
    pub(super) tree: Tree<S>,
    pub(super) state: State<S>,
    pub(super) frames: Vec<Frame<S>>,
    /// cm/s^2.
    pub(super) gravity: V3<S>,
    /// Whether the root cannot move; only tests hold it.
    pub(super) anchored: bool,
    /// Targets of the servos, rad or cm, and of motors, rad/s.
    pub(super) targets: Vec<S>,
    pub(super) ground: Option<Ground<S>>,
    collisions: Option<Collisions<S>>,
    start: State<S>,
    step: S,
    settings: Settings,
    speed_limit: S,
    /// What turns faster than this for long, rad/s, has no right way.
    pub(super) turn_limit: S,
    /// For how many steps something has.
    whirled: S,
    /// Body and place in it of every element, to check speeds.
    centres: Vec<(usize, V3<S>)>,
    reach: Vec<S>,
    /// How the bodies would move on without contacts: servos accelerate light
    /// limbs so much within a step that the present speed says little.
    ahead: Vec<Velocity<S>>,
    /// The greater of present speed and that, for any point of each body.
    tops: Vec<S>,
    inertias: Vec<Sym<S>>,
    composites: Vec<Composite<S>>,
    /// The strides that the step is solved with: foreseen, then found.
    strides: Vec<Stride<S>>,
    /// Those of the speeds that were found.
    found: Vec<Stride<S>>,
    /// Those of the last step.
    before: Vec<Stride<S>>,
    ways: Vec<Way<S>>,
    pub(super) momenta: Momenta<S>,
    wrenches: Vec<Wrench<S>>,
    /// The mass matrix.
    h: Vec<S>,
    factor: Factor<S>,
    pub(super) joints: Joints<S>,
    touches: Touches<S>,
    rows: Rows<S>,
    /// Impulse of each slot in the last step; null where there was none.
    memory: Vec<V3<S>>,
    /// Lane and slot of those that are not null.
    remembered: Vec<(usize, u32)>,
    /// What the contacts give in a step that carry the weight of the tree, as an energy: see [`CARRIED`].
    carried: S,
    /// Steps since the start.
    age: u32,
    pub(super) ledger: Ledger<S>,
    /// What went wrong in each lane, which ends its run.
    pub(super) failures: Vec<Option<Invalid>>,
    /// The lanes where nothing has gone wrong.
    going: S::Mask,
    /// What gravity changes velocities by in this step, cm/s.
    fall: V3<S>,
    /// The lanes where they were off by much in the first.
    wild: S::Mask,
    /// By how much the strides were off in the last pass, as an energy.
    off: S,
    /// By how much the contacts may be off, likewise.
    slack: S,
    /// Passes since the last reset.
    #[cfg(test)]
    pub(super) passes: usize,
    y: Vec<S>,
    free: Vec<S>,
    /// Speeds at the end of the step, as far as they are known.
    next: Vec<S>,
}

impl<S: Scalar> Solver<S> {
    /// At rest in the world of each lane.
    pub(super) fn new(kit: S::Kit, lowered: &Lowered, settings: &Settings, worlds: &[World]) -> Self {
        let tree = Tree::new(kit, lowered, worlds);
        let of = |value: f64| S::of(kit, value);
        let places: Vec<_> = worlds.iter().map(|world| lowered.set_down(world) * LENGTH).collect();
        let turns: Vec<_> = worlds.iter().map(|world| world.turn()).collect();
        let position = V3([0, 1, 2].map(|axis| S::each(kit, |lane| places[lane][axis])));
        let rotation = Quat::each(kit, &turns);
        let mut state = State::new(&tree, position, rotation);
        let mut frames = vec![Frame::null(kit); tree.links.len()];
        place(&tree, &state, &mut frames);
        let mut momenta = Momenta::new(&tree);
        momenta.settle(&tree, &frames);
        state.centre = state.position + momenta.centre;
        let ground = Ground::new(kit, lowered, settings, worlds);
        let collisions = settings.self_collision.then(|| Collisions::new(kit, lowered, worlds));
        let slots = ground.slots + collisions.as_ref().map_or(0, Collisions::slots);
        // More than stand on the ground at once; it grows if it must.
        let contacts = 16 + 4 * lowered.pieces.len();
        let (bodies, dofs) = (tree.links.len(), vec![of(0.0); tree.dofs()]);
        let centres = lowered.pieces.iter().map(|piece| {
            let centre = piece.local.translation.vector * LENGTH;
            (piece.body, V3::constant(kit, centre.into()))
        });
        Self {
            gravity: V3(
                [0, 1, 2].map(|axis| S::each(kit, |lane| worlds[lane].gravity(settings)[axis] * LENGTH))
            ),
            anchored: false,
            targets: vec![of(0.0); lowered.servos.len()],
            start: state.clone(),
            step: of(settings.step),
            settings: settings.clone(),
            speed_limit: of(settings.speed_limit * LENGTH),
            turn_limit: of(settings.turn_limit()),
            whirled: of(0.0),
            centres: centres.collect(),
            reach: reaches(kit, lowered),
            ahead: vec![Velocity::null(kit); bodies],
            tops: vec![of(0.0); bodies],
            inertias: vec![Sym::null(kit); bodies],
            composites: vec![Composite::null(kit); bodies],
            strides: vec![Stride::null(kit); bodies],
            found: vec![Stride::null(kit); bodies],
            before: vec![Stride::null(kit); bodies],
            ways: vec![Way::null(kit); bodies],
            momenta,
            wrenches: vec![Wrench::null(kit); bodies],
            h: vec![of(0.0); tree.entries],
            factor: Factor::new(&tree),
            joints: Joints::new(&tree),
            touches: Touches::new(&tree),
            rows: Rows::new(&tree, contacts),
            memory: vec![V3::null(kit); slots],
            remembered: Vec::with_capacity(contacts * S::LANES),
            age: 0,
            carried: {
                // Without weight a body may still squeeze itself: as much as on earth.
                let fall = settings.gravity.max(9.81) * LENGTH * settings.step;
                tree.mass() * of(CARRIED * fall * fall)
            },
            ledger: Ledger::new(&tree, settings),
            failures: vec![None; S::LANES],
            going: S::mask(kit, true),
            fall: V3::null(kit),
            off: of(0.0),
            slack: of(0.0),
            wild: S::mask(kit, false),
            #[cfg(test)]
            passes: 0,
            y: dofs.clone(),
            next: dofs.clone(),
            free: dofs,
            ground: Some(ground),
            collisions,
            frames,
            state,
            tree,
        }
    }

    /// Begins anew with the speeds and places of the state.
    #[cfg(test)]
    pub(super) fn begin(&mut self) {
        let Self { tree, state, frames, inertias, ahead, momenta, .. } = self;
        place(tree, state, frames);
        turn_inertias(tree, frames, inertias);
        move_on(tree, frames, &state.speeds, ahead);
        self.strides.fill(Stride::null(tree.kit));
        carry(inertias, ahead, &self.strides, momenta);
        stride(
            Pose { tree, frames, inertias },
            &state.speeds,
            ahead,
            self.step,
            &mut self.ways,
            &mut self.strides,
        );
        self.age = 0;
        momenta.settle(tree, frames);
        state.centre = state.position + momenta.centre;
    }

    /// Back to the state at rest, bit for bit.
    pub(super) fn reset(&mut self) {
        self.state.copy_from(&self.start);
        self.joints.reset();
        self.whirled = S::zero(self.tree.kit);
        self.memory.fill(V3::null(self.tree.kit));
        self.remembered.clear();
        self.age = 0;
        self.ledger.reset();
        self.failures.fill(None);
        self.going = S::mask(self.tree.kit, true);
        if let Some(collisions) = &mut self.collisions {
            collisions.reset();
        }
        place(&self.tree, &self.state, &mut self.frames);
        self.momenta.reset();
        self.strides.fill(Stride::null(self.tree.kit));
        self.before.fill(Stride::null(self.tree.kit));
        self.momenta.settle(&self.tree, &self.frames);
    }

    /// Moves on by one step. The frames always belong to the state.
    pub(super) fn advance(&mut self) {
        S::call(
            self.tree.kit,
            #[inline(always)]
            || self.advance_inlined(),
        );
    }

    #[inline(always)]
    fn advance_inlined(&mut self) {
        self.assemble();
        // The lanes whose step is not solved yet.
        let mut live = self.going;
        self.off = self.step.like(f64::INFINITY);
        let mut servos_changed = true;
        for pass in 0..PASSES {
            self.release(servos_changed);
            if pass == 0 {
                self.touch();
            }
            self.constrain(pass == 0, servos_changed, live);
            for (next, &found) in self.next.iter_mut().zip(&self.free) {
                *next = S::pick(live, found, *next);
            }
            let strained = self.joints.review(&self.free, pass == 0, live);
            servos_changed = strained.any();
            // A blow makes joints faster than was foreseen.
            let overstepped = self.joints.watch(&self.tree, &self.state, &self.free, self.step, live);
            let changed = strained | overstepped;
            // What servos and limits gave that have changed since says nothing of the strides.
            let unsettled = live & !changed & self.unsettled(changed);
            live = changed | unsettled;
            #[cfg(test)]
            {
                self.passes += 1;
            }
            if !live.any() || pass + 1 == PASSES {
                break;
            }
            for (stride, found) in self.strides.iter_mut().zip(&self.found) {
                stride.take(unsettled, found);
            }
        }
        self.joints.tally(&self.tree, &self.state.speeds, &self.next);
        self.move_on();
        self.check();
    }

    /// Fills H.
    #[inline(always)]
    fn assemble(&mut self) {
        let Self { tree, state, frames, inertias, h, .. } = self;
        turn_inertias(tree, frames, inertias);
        mass_matrix(tree, frames, inertias, &mut self.composites, h);
        if self.anchored {
            for dof in 0..ROOT {
                h[tree.rows[dof] + dof] += S::of(tree.kit, 1e20);
            }
        }
        // The first step begins at rest, half a step after the middle of one that was not.
        let time = if self.age == 0 { self.step * self.step.like(0.5) } else { self.step };
        self.fall = self.gravity * time;
        self.joints.prepare(tree, state, (&self.targets, h), self.step, time);
    }

    /// Finds the strides of the speeds that were found, and where they are not those that they were found with.
    #[inline(always)]
    fn unsettled(&mut self, changed: S::Mask) -> S::Mask {
        let Self { tree, frames, inertias, ahead, next, .. } = self;
        move_on(tree, frames, next, ahead);
        let pose = Pose { tree, frames, inertias };
        stride(pose, next, ahead, self.step, &mut self.ways, &mut self.found);
        let zero = S::zero(tree.kit);
        let (mut error, mut whole) = (zero, zero);
        for (body, link) in tree.links.iter().enumerate() {
            let (used, found) = (&self.strides[body], &self.found[body]);
            let (shift, spin) = (found.shift - used.shift, found.spin - used.spin);
            error += shift.square() * link.mass + spin.square() * link.lightness;
            whole += self.ways[body].energy(link.mass);
        }
        let first = zero.like(1e36).less(self.off);
        let nearer = error.less(self.off * zero.like(NEARER));
        let wild = (whole * zero.like(2.0 * WILD)).less(error);
        self.wild = (first & wild) | (!first & self.wild);
        self.off = S::pick(changed, zero.like(f64::INFINITY), error);
        nearer & (whole * zero.like(2.0 * SETTLED) + self.slack).less(error)
    }

    /// Adds up all impulses but those of contacts, adds the servos to H and factorises it, if they have
    /// changed, and finds y and the speeds as they would be without contacts.
    #[inline(always)]
    fn release(&mut self, servos_changed: bool) {
        let Self {
            tree, state, frames, inertias, strides, momenta, wrenches, factor, joints, y, free, ..
        } = self;
        let pose = Pose { tree, frames, inertias };
        gather(pose, strides, momenta, self.fall, wrenches, free);
        joints.push(state, free);
        if servos_changed {
            factor.rows.copy_from_slice(&self.h);
            joints.stiffen(tree, &mut factor.rows);
            factor.factorise(tree);
        }
        factor.transform(tree, &state.speeds, free, y);
        factor.restore(tree, y, free);
        joints.collect(tree, state, factor, free, self.step);
    }

    /// Takes over the speeds that were found, and moves on with them.
    #[inline(always)]
    fn move_on(&mut self) {
        let Self { tree, state, frames, inertias, strides, momenta, ahead, .. } = self;
        state.speeds.copy_from_slice(&self.next);
        carry(inertias, ahead, strides, momenta);
        for ((stride, &found), before) in strides.iter_mut().zip(&self.found).zip(&mut self.before) {
            *stride = found.beyond(before, self.wild);
            *before = found;
        }
        momenta.fall(self.fall);
        for contact in &self.rows.contacts[..self.rows.grounded] {
            let V3([up, x, z]) = contact.impulse;
            momenta.push(contact.point, V3([x, up, z]));
        }
        if self.anchored {
            momenta.settle(tree, frames);
        }
        state.turn(tree, self.step);
        place(tree, state, frames);
        momenta.advance(frames, state, self.step);
    }

    /// Finds the points that may touch within the step.
    #[inline(always)]
    fn touch(&mut self) {
        let Self { tree, frames, touches, strides, .. } = self;
        let step = self.step;
        let half = step * step.like(0.5);
        touches.clear();
        move_on(tree, frames, &self.free, &mut self.ahead);
        for (body, top) in self.tops.iter_mut().enumerate() {
            let (now, ahead) = (&frames[body], &self.ahead[body]);
            let reach = self.reach[body];
            *top = top_speed(now.spin, now.velocity, reach).max(top_speed(ahead.spin, ahead.velocity, reach));
        }
        let still = step.like(MARGIN) + self.gravity.length() * step * step;
        let going = self.going;
        let mut slots = 0;
        if let Some(ground) = &self.ground {
            slots = ground.slots;
            let tops = &self.tops;
            ground.find(
                &self.state,
                frames,
                #[inline(always)]
                |body| still + tops[body] * step,
                #[inline(always)]
                |c| {
                    let frame = &frames[c.body];
                    let arm = c.point - frame.centre;
                    let stride = &strides[c.body];
                    let around = stride.turn.cross(arm) + frame.spin.cross(c.moving) * half;
                    let V3([x, y, z]) = stride.shift + around;
                    let allowance = allowance(c.gap, step) + y;
                    touches.add(c.lanes & going, c.body, c.slot, c.point, (allowance, [x, z]), c.friction);
                },
            );
        }
        if let Some(collisions) = &mut self.collisions {
            collisions.find(
                frames,
                &self.ahead,
                step,
                #[inline(always)]
                |m| {
                    let allowance = allowance(m.gap, step);
                    let place = (m.point, m.normal);
                    touches.add_pair(m.lanes & going, m.bodies, slots + m.slot, place, allowance, m.friction);
                },
            );
        }
    }

    /// Makes the rows of the contacts, solves limits and contacts, and
    /// remembers the impulses of the live lanes; leaves the speeds in `free`.
    #[inline(always)]
    fn constrain(&mut self, first: bool, servos_changed: bool, live: S::Mask) {
        let Self { tree, frames, factor, joints, rows, y, .. } = self;
        if servos_changed {
            rows.fill(tree, frames, factor, &self.touches);
        }
        for contact in rows.contacts.iter_mut() {
            for (lane, slot) in used(&contact.slots, S::LANES) {
                contact.impulse.copy_lane(lane, &self.memory[slot]);
            }
        }
        joints.warm_start(y);
        pgs::warm_start(rows, y);
        // A lane that has come to rest is left as it is, while others go on.
        let mut open = live;
        let Sweeps { most, tolerance } = self.settings.sweeps_after(self.age);
        let tolerance = S::of(tree.kit, tolerance * tolerance);
        for _ in 0..most {
            let mut unrest = Unrest::new(tree.kit);
            joints.sweep(y, open, &mut unrest);
            pgs::sweep(rows, y, open, &mut unrest);
            self.slack = S::pick(open, unrest.share(tolerance, self.carried), self.slack);
            open = open & unrest.exceeds(tolerance, self.carried);
            if !open.any() {
                break;
            }
        }
        factor.restore(tree, y, &mut self.free);
        joints.remember(live);
        self.remember(first, live);
    }

    /// Remembers the impulses of the contacts; what was not touched in the
    /// `first` pass of a step is forgotten.
    #[inline(always)]
    fn remember(&mut self, first: bool, live: S::Mask) {
        let Self { memory, remembered, .. } = self;
        if first {
            for (lane, slot) in remembered.drain(..) {
                memory[slot as usize].copy_lane(lane, &V3::null(self.tree.kit));
            }
        }
        let live = live.bits();
        for contact in self.rows.contacts.iter() {
            for (lane, slot) in used(&contact.slots, S::LANES) {
                if live >> lane & 1 == 0 {
                    continue;
                }
                memory[slot].copy_lane(lane, &contact.impulse);
                if first {
                    remembered.push((lane, slot as u32));
                }
            }
        }
    }

    /// Ends the runs of lanes with numbers that are not finite, or elements
    /// beyond the speed limit.
    #[inline(always)]
    fn check(&mut self) {
        let zero = S::zero(self.tree.kit);
        let away = self.state.position.square();
        // inf x 0 is NaN, and every comparison with NaN is false.
        let mut fine = (away * zero).at_most(zero);
        let mut fastest = zero;
        for (frame, &reach) in self.frames.iter().zip(&self.reach) {
            // Only lanes in which a body might be too fast are looked at closely.
            let spin = frame.spin.length();
            fastest = fastest.max(spin);
            fine = fine & (frame.velocity.length() + spin * reach).less(self.speed_limit);
        }
        let whirls = self.turn_limit.less(fastest);
        self.whirled = S::pick(whirls, self.whirled + zero.like(1.0), zero);
        fine = fine & self.whirled.less(zero.like(WHIRLS));
        let sinks = if self.ground.is_some() { self.frames.as_slice() } else { &[] };
        for frame in sinks {
            fine = fine & zero.less(self.state.position[1] + frame.centre[1]);
        }
        self.age += 1;
        if self.age.is_multiple_of(AUDIT) {
            let energy = (self.energy(), doubt(&self.tree, &self.ahead, &self.frames));
            let gained = self.ledger.gain(energy, &self.joints, self.frames.len());
            fine = fine & gained.at_most(self.ledger.allowed);
        }
        let doubtful = self.going & !fine;
        if doubtful.any() {
            self.examine(doubtful);
        }
    }

    /// The force with which the ground carried an element in the last step, g cm/s^2: the impulses of its points.
    pub(super) fn carried_by(&self, lane: usize, element: usize) -> f64 {
        let slots = self.ground.as_ref().map_or(0..0, |ground| ground.slots_of(element));
        let impulses = self.memory[slots].iter().map(|impulse| impulse[0].lane(lane));
        impulses.sum::<f64>() / self.step.lane(lane)
    }

    /// Kinetic and potential energy in the middle of the last step, erg.
    #[inline(always)]
    pub(super) fn energy(&self) -> S {
        let stored = self.joints.stored(&self.tree, &self.state, self.step);
        stored + energy(&self.tree, &self.ways, &self.momenta, &self.state, self.gravity, self.step)
    }

    #[cold]
    fn examine(&mut self, doubtful: S::Mask) {
        for lane in lanes_of(doubtful.bits()) {
            self.failures[lane] = self.failure(lane);
        }
        let mut gone = S::zero(self.tree.kit);
        for (lane, failure) in self.failures.iter().enumerate() {
            gone.set_lane(lane, if failure.is_some() { 1.0 } else { 0.0 });
        }
        self.going = gone.less(gone.like(0.5));
    }

    fn failure(&self, lane: usize) -> Option<Invalid> {
        let finite = |v: V3<S>| v.lane(lane).0.iter().all(|part| part.is_finite());
        let moves = |frame: &Frame<S>| finite(frame.spin) && finite(frame.velocity);
        if !finite(self.state.position) || !self.frames.iter().all(moves) {
            return Some(Invalid::NotFinite);
        }
        let limit = self.speed_limit.lane(lane);
        let fast = |&(body, centre): &(usize, V3<S>)| {
            let frame = &self.frames[body];
            let arm = frame.rotation.lane(lane) * centre.lane(lane);
            let speed = (frame.velocity.lane(lane) + frame.spin.lane(lane).cross(arm)).length();
            speed.is_nan() || speed > limit
        };
        if self.centres.iter().any(fast) {
            return Some(Invalid::TooFast);
        }
        if self.whirled.lane(lane) >= WHIRLS {
            return Some(Invalid::TurnsTooFast);
        }
        let height = |frame: &Frame<S>| self.state.position[1].lane(lane) + frame.centre[1].lane(lane);
        // Between the axes of a socket are bodies without mass, which are but places.
        let mut bodies =
            self.frames.iter().zip(&self.tree.links).filter(|(_, link)| link.mass.lane(lane) > 0.0);
        if self.ground.is_some() && bodies.any(|(frame, _)| height(frame) <= 0.0) {
            return Some(Invalid::Sunk);
        }
        (self.ledger.gained.lane(lane) > self.ledger.allowed.lane(lane)).then_some(Invalid::EnergyFromNowhere)
    }
}

/// The lanes that have a slot.
#[inline(always)]
fn used(slots: &[u32], lanes: usize) -> impl Iterator<Item = (usize, usize)> {
    slots[..lanes]
        .iter()
        .enumerate()
        .filter(|(_, slot)| **slot != NO_SLOT)
        .map(|(lane, slot)| (lane, *slot as usize))
}

/// The velocity that closes a gap in one step, or minus that which mends an
/// overlap.
#[inline(always)]
fn allowance<S: Scalar>(gap: S, step: S) -> S {
    let k = |value: f64| gap.like(value);
    let deep = (-gap - k(SLOP)).max(k(0.0));
    let mending = -(deep * k(MEND) / step).min(k(MEND_SPEED));
    S::pick(gap.less(k(0.0)), mending, gap / step)
}
