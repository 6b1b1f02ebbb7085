//! Which balls may come to touch: pairs that nothing holds apart. The pairs of a ball are found anew when it has come
//! further than half a margin from where it was when they were found.
//!
//! Balls that a spring joins do not touch, nor do those that are joined to the same ball and lie within the margin
//! at rest, as across a corner of a lattice: to meet they would have to squeeze those springs by two fifths.

use super::touch::Touch;
use super::vector::{dot, sub};
use crate::simulate::lattice::Lattice;

/// The margin, as a share of the mean diameter: less than what lies at rest between balls of a lattice that are
/// two places apart.
const MARGIN: f32 = 0.8;
/// Between two looks at how far balls have moved, steps.
pub(super) const LOOK: usize = 4;

/// Pairs that are close, and when to look again.
pub(super) struct Near {
    /// How many balls there are.
    count: usize,
    /// Whether two balls are held apart: a bit for each pair.
    apart: Vec<u64>,
    margin: f32,
    /// Where each ball was when its pairs were found, as x, y and z from the middle of the body, m: what all balls have moved
    /// together brings none closer. In sequences of numbers, so that the processor compares several at once.
    then: [Vec<f32>; 3],
    /// Its radius then, m.
    radius: Vec<f32>,
    /// The balls whose pairs are found now, and whether each ball is one.
    moved: Vec<usize>,
    has_moved: Vec<bool>,
    close: Vec<bool>,
}

impl Near {
    /// Before anything has been found.
    pub(super) fn new(lattice: &Lattice) -> Self {
        let count = lattice.balls.len();
        let mut joined = vec![Vec::new(); count];
        for link in &lattice.links {
            let [from, to] = link.ends;
            joined[from].push(to);
            joined[to].push(from);
        }
        let mean: f64 = lattice.balls.iter().map(|ball| 2.0 * ball.radius).sum::<f64>();
        let margin = MARGIN * (mean / count as f64) as f32;
        let apart = vec![0; (count * count).div_ceil(64)];
        let mut near = Self {
            count,
            apart,
            margin,
            then: [(); 3].map(|()| vec![f32::INFINITY; count]),
            radius: vec![0.0; count],
            moved: Vec::new(),
            has_moved: vec![false; count],
            close: Vec::new(),
        };
        for (ball, others) in joined.iter().enumerate() {
            for &other in others {
                near.hold_apart(ball, other);
                for &third in joined[other].iter().filter(|third| **third != ball) {
                    let (a, b) = (&lattice.balls[ball], &lattice.balls[third]);
                    if (a.centre - b.centre).norm() < a.radius + b.radius + f64::from(margin) {
                        near.hold_apart(ball, third);
                    }
                }
            }
        }
        near
    }

    fn hold_apart(&mut self, a: usize, b: usize) {
        let bit = a * self.count + b;
        self.apart[bit / 64] |= 1 << (bit % 64);
    }

    fn are_apart(&self, a: usize, b: usize) -> bool {
        let bit = a * self.count + b;
        self.apart[bit / 64] >> (bit % 64) & 1 == 1
    }

    /// Forgets what was found.
    pub(super) fn reset(&mut self) {
        self.then.iter_mut().for_each(|column| column.fill(f32::INFINITY));
    }

    /// Brings the pairs up to date, if balls may come closer than the margin before the next look, in `time` s. Speeds may
    /// double until then.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        place: impl Fn(usize) -> [f32; 3],
        velocity: impl Fn(usize) -> [f32; 3],
        radius: impl Fn(usize) -> f32,
        time: f32,
        pairs: &mut Vec<Touch>,
    ) {
        let (middle, mean) = (mean(self.count, &place), mean(self.count, &velocity));
        self.moved.clear();
        for ball in 0..self.count {
            let own = sub(place(ball), middle);
            let way = sub(own, [0, 1, 2].map(|axis: usize| self.then[axis][ball]));
            let speed = sub(velocity(ball), mean);
            let grown = (radius(ball) - self.radius[ball]).max(0.0);
            let far = dot(way, way).sqrt() + grown + (2.0 * dot(speed, speed).sqrt() + 0.1) * time;
            self.has_moved[ball] = far > self.margin / 2.0;
            if self.has_moved[ball] {
                self.moved.push(ball);
            }
        }
        if self.moved.is_empty() {
            return;
        }
        for &ball in &self.moved {
            let own = sub(place(ball), middle);
            (0..3).for_each(|axis| self.then[axis][ball] = own[axis]);
            self.radius[ball] = radius(ball);
        }
        self.find(pairs);
    }

    /// Finds the pairs of the balls that have moved.
    fn find(&mut self, pairs: &mut Vec<Touch>) {
        let is_old = |touch: &Touch| self.has_moved[touch.balls.0] || self.has_moved[touch.balls.1];
        let known: Vec<Touch> = pairs.iter().copied().filter(is_old).collect();
        pairs.retain(|touch| !is_old(touch));
        let [x, y, z] = &self.then;
        for &a in &self.moved {
            let all = x.iter().zip(y).zip(z).zip(&self.radius);
            self.close.clear();
            self.close.extend(all.map(|(((x2, y2), z2), radius)| {
                let (dx, dy, dz) = (x2 - x[a], y2 - y[a], z2 - z[a]);
                let far = radius + self.radius[a] + self.margin;
                dx * dx + dy * dy + dz * dz < far * far
            }));
            for (b, _) in self.close.iter().enumerate().filter(|(_, close)| **close) {
                // Of two that have moved, once.
                if b != a && !(self.has_moved[b] && b < a) && !self.are_apart(a, b) {
                    pairs.push(Touch::between(a.min(b), a.max(b)));
                }
            }
        }
        pairs.sort_unstable_by_key(|touch| touch.balls);
        for touch in pairs {
            if let Ok(place) = known.binary_search_by_key(&touch.balls, |own| own.balls) {
                *touch = known[place];
            }
        }
    }
}

fn mean(count: usize, of: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for ball in 0..count {
        let own = of(ball);
        (0..3).for_each(|axis| sum[axis] += own[axis]);
    }
    sum.map(|s| s / count as f32)
}
