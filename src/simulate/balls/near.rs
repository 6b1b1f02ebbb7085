//! Which balls may come to touch: pairs that no spring joins, found anew only when balls have come
//! closer than a margin.

use super::touch::Touch;
use crate::simulate::lattice::Lattice;

/// The margin, as a share of the mean diameter: less than what lies between balls of a lattice at rest.
const MARGIN: f32 = 0.4;
/// Between two looks at how far balls have moved, steps.
pub(super) const LOOK: usize = 8;

/// Pairs that are close, and when to look again.
pub(super) struct Near {
    /// Those that each ball is joined to by a spring.
    joined: Vec<Vec<usize>>,
    margin: f32,
    /// Where balls were when pairs were found, m.
    then: Vec<[f32; 3]>,
    order: Vec<usize>,
}

impl Near {
    /// Before anything has been found.
    pub(super) fn new(lattice: &Lattice) -> Self {
        let mut joined = vec![Vec::new(); lattice.balls.len()];
        for link in &lattice.links {
            let [from, to] = link.ends;
            joined[from].push(to);
            joined[to].push(from);
        }
        let mean: f64 = lattice.balls.iter().map(|ball| 2.0 * ball.radius).sum::<f64>();
        let margin = MARGIN * (mean / lattice.balls.len() as f64) as f32;
        Self { joined, margin, then: Vec::new(), order: (0..lattice.balls.len()).collect() }
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
        let count = self.joined.len();
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
        for (n, &a) in self.order.iter().enumerate() {
            for &b in &self.order[n + 1..] {
                if then[b][axis] - then[a][axis] > 2.0 * widest + self.margin {
                    break;
                }
                let (way, reach) = (sub(then[b], then[a]), radius(a) + radius(b) + self.margin);
                if dot(way, way) < reach * reach && !self.joined[a].contains(&b) {
                    into.push(Touch::between(a.min(b), a.max(b)));
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
