//! Which balls may come to touch: pairs that nothing holds apart, found anew only when balls have come
//! closer than a margin.
//!
//! Balls that a spring joins do not touch, nor do those that are joined to the same ball and lie within the margin
//! at rest, as across a corner of a lattice: to meet they would have to squeeze those springs by two fifths.

use super::touch::Touch;
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
    /// Where balls were when pairs were found, m.
    then: Vec<[f32; 3]>,
    order: Vec<usize>,
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
        let mut near = Self { count, apart, margin, then: Vec::new(), order: (0..count).collect() };
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
        self.then.clear();
        self.order.sort_unstable();
    }

    /// The world has been moved under the balls, m.
    pub(super) fn shift(&mut self, by: [f32; 3]) {
        for place in &mut self.then {
            for axis in 0..3 {
                place[axis] -= by[axis];
            }
        }
    }

    /// Whether balls may have come closer than the margin before the next look, in `time` s.
    ///
    /// What all balls have moved together brings none closer. Speeds may double until then.
    pub(super) fn is_stale(
        &self,
        place: impl Fn(usize) -> [f32; 3],
        velocity: impl Fn(usize) -> [f32; 3],
        time: f32,
    ) -> bool {
        if self.then.is_empty() {
            return true;
        }
        let count = self.then.len();
        let way = |ball: usize| sub(place(ball), self.then[ball]);
        let (drift, mean) = (mean(count, way), mean(count, &velocity));
        let far = |v: [f32; 3]| dot(v, v);
        let ways = (0..count).map(|ball| far(sub(way(ball), drift))).fold(0.0, f32::max).sqrt();
        let speed = (0..count).map(|ball| far(sub(velocity(ball), mean))).fold(0.0, f32::max).sqrt();
        2.0 * (ways + (2.0 * speed + 0.1) * time) > self.margin
    }

    /// Finds pairs anew: sorted along the axis on which the body is longest, each with those that follow closely.
    pub(super) fn find(
        &mut self,
        place: impl Fn(usize) -> [f32; 3],
        radius: impl Fn(usize) -> f32,
        into: &mut Vec<Touch>,
    ) {
        let count = self.count;
        self.then.clear();
        self.then.extend((0..count).map(place));
        let then = &self.then;
        let spread = |axis: usize| {
            let all = then.iter().map(|place| place[axis]);
            all.clone().fold(f32::MIN, f32::max) - all.fold(f32::MAX, f32::min)
        };
        let axis = (1..3).fold(0, |best, axis| if spread(axis) > spread(best) { axis } else { best });
        self.order.sort_by(|&a, &b| then[a][axis].total_cmp(&then[b][axis]).then(a.cmp(&b)));
        let widest = (0..count).map(&radius).fold(0.0, f32::max);
        let known = std::mem::take(into);
        // In sequences of numbers, so that the processor compares several at once.
        let column = |axis: usize| self.order.iter().map(|&ball| then[ball][axis]).collect::<Vec<f32>>();
        let (x, y, z) = (column(axis), column((axis + 1) % 3), column((axis + 2) % 3));
        let reach: Vec<f32> = self.order.iter().map(|&ball| radius(ball) + self.margin / 2.0).collect();
        let mut close: Vec<bool> = Vec::new();
        for (n, &a) in self.order.iter().enumerate() {
            let after = n + 1;
            let end = after + x[after..].partition_point(|x2| x2 - x[n] <= 2.0 * widest + self.margin);
            let (columns, reach2) =
                (x[after..end].iter().zip(&y[after..end]).zip(&z[after..end]), &reach[after..end]);
            close.clear();
            close.extend(columns.zip(reach2).map(|(((x2, y2), z2), reach2)| {
                let (dx, dy, dz, far) = (x2 - x[n], y2 - y[n], z2 - z[n], reach[n] + reach2);
                dx * dx + dy * dy + dz * dz < far * far
            }));
            for (b, _) in self.order[after..end].iter().zip(&close).filter(|(_, close)| **close) {
                if !self.are_apart(a, *b) {
                    into.push(Touch::between(a.min(*b), a.max(*b)));
                }
            }
        }
        into.sort_unstable_by_key(|touch| touch.balls);
        for touch in into {
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

/// The difference of two vectors.
#[inline(always)]
pub(super) fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The product of two vectors.
#[inline(always)]
pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
