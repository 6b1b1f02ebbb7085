//! One body of balls and springs, step by step.

use super::vector::dot;
use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::ground::{Footing, stand};
use super::ledger::{self, Ledger};
use super::near::{self, Near};
use super::order;
use super::springs::{Springs, Vectors, vectors};
use super::swell::Swell;
use super::touch::{self, Touch};
use crate::simulate::lattice::{Ball, Lattice};
use crate::simulate::run::Stepper;
use crate::simulate::{Invalid, Settings};

/// How far from the origin the body may be before the world is moved under it, m: numbers of 32 bits are
/// finer near zero.
const FAR: f32 = 0.25;

/// The state of all balls; x, y, z and nothing in the lanes of each vector.
pub(super) struct State<K: Simd> {
    /// Where they are, m; after the last ball two that are spare.
    pub(super) at: Vectors<K>,
    /// What rounding has taken from `at`, m.
    lost: Vec<f32x4<K>>,
    /// m/s, half a step behind.
    pub(super) velocity: Vec<f32x4<K>>,
    footing: Vec<Footing>,
    /// One over the mass, 1/kg.
    lightness: Vec<f32>,
    /// Steps in a second.
    rate: f32,
}

/// A body that is simulated.
pub(super) struct Solver<K: Simd> {
    kit: K,
    lattice: Lattice,
    settings: Settings,
    pub(super) state: State<K>,
    force: Vectors<K>,
    /// Forces that always act, N.
    weight: Vec<f32x4<K>>,
    springs: Springs<K>,
    swell: Swell,
    near: Near,
    touches: Vec<Touch>,
    pub(super) ledger: Ledger,
    /// Where the world's origin is, m.
    origin: [f64; 3],
    steps: usize,
    failure: Option<Invalid>,
}

impl<K: Simd> Solver<K> {
    /// At rest. None never happens.
    pub(super) fn new(kit: K, lattice: &Lattice, settings: &Settings) -> Option<Self> {
        let classes = order::classes(lattice);
        let (springs, fours) = Springs::new(kit, lattice, &classes, settings.step);
        let weight = |ball: &Ball| {
            let weight = lattice.gravity * if ball.mass.is_finite() { ball.mass } else { 0.0 };
            f32x4::simd_from(kit, [weight.x as f32, weight.y as f32, weight.z as f32, 0.0])
        };
        let mut own = Self {
            kit,
            swell: Swell::new(lattice, &classes, &fours),
            near: Near::new(lattice),
            touches: Vec::new(),
            ledger: Ledger::new(lattice, settings),
            springs,
            state: State::new(kit, lattice, settings)?,
            force: vectors(kit)?,
            weight: lattice.balls.iter().map(weight).collect(),
            origin: [0.0; 3],
            steps: 0,
            failure: None,
            lattice: lattice.clone(),
            settings: settings.clone(),
        };
        own.reset();
        Some(own)
    }

    fn balls(&self) -> usize {
        self.lattice.balls.len()
    }

    #[inline(always)]
    fn advance(&mut self) {
        let count = self.balls();
        self.force[..count].copy_from_slice(&self.weight);
        self.springs.pull(&self.state.at, &mut self.force);
        let audits = self.steps.is_multiple_of(ledger::LOOK);
        let stored = if audits { self.stored() } else { 0.0 };
        let before = if audits { self.state.velocity.clone() } else { Vec::new() };
        // Velocities are half a step behind, but at first they are those of rest.
        let share = if self.steps == 0 { 0.5 } else { 1.0 };
        self.state.kick(self.kit, &self.force, share / self.state.rate);
        self.actuate();
        if self.settings.self_collision {
            self.touch();
        }
        let (squares, grown) = self.state.stand(self.kit);
        self.swell.balance += grown;
        self.failure = self.failure.or(self.strays(squares));
        if audits && !self.ledger.take(stored + self.state.moving(&before, &self.lattice)) {
            self.failure = self.failure.or(Some(Invalid::EnergyFromNowhere));
        }
        self.state.drift(self.kit);
        self.steps += 1;
        self.recentre();
    }

    /// Gives springs and balls the strains of the end of this step.
    #[inline(always)]
    fn actuate(&mut self) {
        let Self { swell, springs, state, kit, .. } = self;
        if swell.changes() {
            swell.strain(|fours, strain| springs.strain(*kit, fours, strain));
            swell.swell(|ball, radius| {
                let footing = &mut state.footing[ball];
                (footing.growth, footing.radius) = (radius - footing.radius, radius);
            });
        } else {
            state.footing.iter_mut().for_each(|footing| footing.growth = 0.0);
        }
    }

    fn touch(&mut self) {
        let Self { state, near, touches, settings, .. } = self;
        if self.steps.is_multiple_of(near::LOOK) {
            let (place, velocity) = (|ball| xyz(state.at[ball]), |ball| xyz(state.velocity[ball]));
            let time = near::LOOK as f32 / state.rate;
            near.look(place, velocity, |ball| state.footing[ball].radius, time, touches);
        }
        if !touches.is_empty() {
            let (rate, tolerance) = (state.rate, settings.tolerance as f32);
            self.swell.balance += touch::solve(touches, state, rate, settings.iterations, tolerance);
        }
    }

    /// Elastic and potential energy less the work so far, J.
    fn stored(&self) -> f64 {
        let falling = |(ball, place): (&Ball, &f32x4<K>)| {
            let place = nalgebra::Vector3::from(xyz(*place).map(f64::from));
            let place = place + nalgebra::Vector3::from(self.origin);
            if ball.mass.is_finite() { ball.mass * self.lattice.gravity.dot(&place) } else { 0.0 }
        };
        let fallen: f64 = self.lattice.balls.iter().zip(self.state.at.iter()).map(falling).sum();
        let work = self.swell.balance + self.swell.pending(|class| self.springs.push(class));
        self.springs.energy() - fallen - work
    }

    /// What is wrong with the balls, if the squares of all speeds come to so much.
    fn strays(&self, squares: f32) -> Option<Invalid> {
        let limit = (self.settings.speed_limit * self.settings.speed_limit) as f32;
        if squares <= limit {
            return None;
        }
        let mut speeds = self.state.velocity.iter().map(|v| dot(xyz(*v), xyz(*v)));
        if speeds.clone().any(|square| !square.is_finite()) {
            return Some(Invalid::NotFinite);
        }
        speeds.any(|square| square > limit).then_some(Invalid::TooFast)
    }

    /// Moves the world when the body has gone far, by sixteenths of a metre.
    #[inline(always)]
    fn recentre(&mut self) {
        let [x, _, z] = xyz(self.state.at[0]);
        if x.abs() <= FAR && z.abs() <= FAR {
            return;
        }
        let by = [(x * 16.0).round() / 16.0, 0.0, (z * 16.0).round() / 16.0];
        let shift = f32x4::simd_from(self.kit, [by[0], 0.0, by[2], 0.0]);
        let count = self.balls();
        self.state.at[..count].iter_mut().for_each(|place| *place -= shift);
        (0..3).for_each(|axis| self.origin[axis] += f64::from(by[axis]));
    }
}

impl<K: Simd> State<K> {
    fn new(kit: K, lattice: &Lattice, settings: &Settings) -> Option<Self> {
        let none = vec![f32x4::splat(kit, 0.0); lattice.balls.len()];
        let friction = |ball: &Ball| (ball.friction * settings.ground_friction).sqrt() as f32;
        let footing = |ball: &Ball| Footing { radius: 0.0, growth: 0.0, friction: friction(ball) };
        Some(Self {
            at: vectors(kit)?,
            lost: none.clone(),
            velocity: none,
            footing: lattice.balls.iter().map(footing).collect(),
            lightness: lattice.balls.iter().map(|ball| (1.0 / ball.mass) as f32).collect(),
            rate: (1.0 / settings.step) as f32,
        })
    }

    fn reset(&mut self, kit: K, lattice: &Lattice) {
        for (index, ball) in lattice.balls.iter().enumerate() {
            let [x, y, z] = ball.centre.into();
            self.at[index] = f32x4::simd_from(kit, [x as f32, y as f32, z as f32, 0.0]);
            self.footing[index].radius = ball.radius as f32;
            self.footing[index].growth = 0.0;
        }
        let count = lattice.balls.len();
        self.at[count + 1] = f32x4::simd_from(kit, [1.0, 0.0, 0.0, 0.0]);
        self.lost.fill(f32x4::splat(kit, 0.0));
        for (velocity, ball) in self.velocity.iter_mut().zip(&lattice.balls) {
            let [x, y, z] = ball.velocity.into();
            *velocity = f32x4::simd_from(kit, [x as f32, y as f32, z as f32, 0.0]);
        }
    }

    #[inline(always)]
    fn kick(&mut self, kit: K, force: &Vectors<K>, step: f32) {
        let balls = self.velocity.iter_mut().zip(force.iter()).zip(&self.lightness);
        for ((velocity, force), lightness) in balls {
            *velocity += *force * f32x4::splat(kit, *lightness * step);
        }
    }

    /// Lets the ground push and rub. Returns the squares of all speeds, (m/s)^2, and the work of balls that grew
    /// against it, J.
    #[inline(always)]
    fn stand(&mut self, kit: K) -> (f32, f64) {
        let (mut squares, mut grown) = (f32x4::splat(kit, 0.0), 0.0);
        let balls = self.velocity.iter_mut().zip(self.at.iter()).zip(&self.footing).zip(&self.lightness);
        for (((velocity, at), footing), lightness) in balls {
            let (stood, push) = stand(footing, at[1], self.rate, (*velocity).into());
            if push > 0.0 {
                *velocity = f32x4::simd_from(kit, stood);
                grown += f64::from(push / lightness * footing.growth.max(0.0) * self.rate);
            }
            squares += *velocity * *velocity;
        }
        (squares[0] + squares[1] + squares[2], grown)
    }

    /// Moves all balls; what rounding takes in a step is given back in the next.
    #[inline(always)]
    fn drift(&mut self, kit: K) {
        let step = f32x4::splat(kit, 1.0 / self.rate);
        for ((at, lost), velocity) in self.at.iter_mut().zip(&mut self.lost).zip(&self.velocity) {
            let way = *velocity * step - *lost;
            let next = *at + way;
            *lost = (next - *at) - way;
            *at = next;
        }
    }

    /// Kinetic energy between two half steps, J: with it, energy is kept exactly by undamped linear springs.
    fn moving(&self, before: &[f32x4<K>], lattice: &Lattice) -> f64 {
        let pairs = before.iter().zip(&self.velocity).zip(&lattice.balls);
        let one = |((before, after), ball): ((&f32x4<K>, &f32x4<K>), &Ball)| {
            let product = dot(xyz(*before), xyz(*after));
            if ball.mass.is_finite() { 0.5 * ball.mass * f64::from(product) } else { 0.0 }
        };
        pairs.map(one).sum()
    }
}

impl<K: Simd> touch::Balls for State<K> {
    fn place(&self, ball: usize) -> [f32; 3] {
        xyz(self.at[ball])
    }

    fn radius(&self, ball: usize) -> (f32, f32) {
        (self.footing[ball].radius, self.footing[ball].growth)
    }

    fn lightness(&self, ball: usize) -> f32 {
        self.lightness[ball]
    }

    fn velocity(&self, ball: usize) -> [f32; 3] {
        let (stood, _) = stand(&self.footing[ball], self.at[ball][1], self.rate, self.velocity[ball].into());
        [stood[0], stood[1], stood[2]]
    }

    fn kick(&mut self, ball: usize, by: [f32; 3]) {
        let velocity = &mut self.velocity[ball];
        velocity.iter_mut().zip(by).for_each(|(own, by)| *own += by);
    }
}

fn xyz<K: Simd>(v: f32x4<K>) -> [f32; 3] {
    [v[0], v[1], v[2]]
}

impl<K: Simd> Stepper for Solver<K> {
    const LANES: usize = 1;

    fn reset(&mut self) {
        self.state.reset(self.kit, &self.lattice);
        self.springs.reset();
        self.swell.reset();
        self.near.reset();
        self.touches.clear();
        self.ledger.reset();
        (self.origin, self.steps, self.failure) = ([0.0; 3], 0, None);
    }

    fn aim(&mut self, _: usize, actuator: usize, target: f64) {
        self.swell.targets[actuator] = target;
    }

    fn step(&mut self) {
        let kit = self.kit;
        kit.vectorize(
            #[inline(always)]
            || self.advance(),
        );
    }

    fn failure(&self, _: usize) -> Option<Invalid> {
        self.failure
    }

    fn pose(&self, _: usize, ball: usize) -> Isometry3<f64> {
        let place = |axis: usize| f64::from(self.state.at[ball][axis]) + self.origin[axis] + 0.0;
        Isometry3::from_parts(Translation3::new(place(0), place(1), place(2)), UnitQuaternion::identity())
    }

    fn position(&self, _: usize, actuator: usize) -> f64 {
        self.swell.targets[actuator]
    }

    fn work(&self, _: usize, actuator: usize) -> f64 {
        self.swell.work[actuator]
    }
}
