//! What a move of a search for a front is after: one number made of all objectives, by weights that each move draws anew.
//!
//! The number is how far a motion is from the best that the front has of every objective, by the objective that it is farthest
//! in (the augmented weighted Chebyshev distance; Steuer and Choo 1983, used so by Knowles 2006). With some weights each
//! design of a front is the best, also where the front is hollow, which no weighted sum could reach.

use grammar_lang::ir::{Direction, Objective};
use serde::{Deserialize, Serialize};

use crate::derive::random::Stream;

/// The share of moves that are after the first objective alone. Of a few robots that all do little no trade is worth much; what is good by the
/// first objective is made frugal sooner than what is frugal is made good (`docs/experiments.md`).
const LED: f64 = 0.5;
/// So far beyond the best of the front is what a move is after, as a share of the front's range: or nothing would be gained by what is
/// better than the best, and the front would not grow at its ends.
const UTOPIA: f64 = 0.5;
/// How much the distances in all objectives count beside the greatest: so that of two designs that are as far in one the one is
/// better that is nearer in another.
const SUM: f64 = 0.05;
/// A value near zero may change by this share of the front's range before it counts as changed.
const OF_RANGE: f64 = 0.1;

/// What a move is after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Aim {
    /// For each objective, in their order.
    scales: Vec<Scale>,
}

/// How one objective counts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Scale {
    direction: Direction,
    weight: f64,
    /// The best of the front, where more is better.
    ideal: f64,
    /// From the worst of the front to its best; 1 as long as there is no front.
    range: f64,
    /// Whether there is a front, so that its range says what is near zero.
    #[serde(default)]
    has_range: bool,
}

impl Aim {
    /// An aim for a move, on the scale of a front: the values of each of its designs in each objective. It is the first objective alone, or weights that
    /// are drawn evenly. As long as there is no front, it is the first objective.
    pub(super) fn draw<'o>(
        objectives: impl Iterator<Item = &'o Objective>,
        front: &[Vec<f64>],
        random: &mut Stream,
    ) -> Self {
        let is_led = random.unit() < LED;
        let scales = objectives.enumerate().map(|(place, Objective { direction, .. })| {
            let drawn = match (is_led, place) {
                (true, 0) => 1.0,
                (true, _) => 0.0,
                // Exponential numbers over their sum are even on the simplex.
                (false, _) => -libm::log(1.0 - random.unit()),
            };
            let known = front.iter().filter_map(|values| values.get(place)).map(|x| direction.fitness(*x));
            let (low, high) =
                known.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            let Some((ideal, range)) = (low <= high).then_some((high, high - low)) else {
                let weight = if place == 0 { 1.0 } else { 0.0 };
                return Scale { direction: *direction, weight, ideal: 0.0, range: 1.0, has_range: false };
            };
            let range = if range > 0.0 {
                range
            } else if ideal != 0.0 {
                ideal.abs()
            } else {
                1.0
            };
            Scale { direction: *direction, weight: drawn, ideal, range, has_range: true }
        });
        let mut scales: Vec<Scale> = scales.collect();
        let sum: f64 = scales.iter().map(|scale| scale.weight).sum();
        if sum > 0.0 {
            scales.iter_mut().for_each(|scale| scale.weight /= sum);
        }
        Self { scales }
    }

    /// How good the values of all objectives are, as a value of the first objective: in its unit and by its direction. It is 0 at
    /// [`UTOPIA`], and below that where more is better.
    pub(super) fn value(&self, each: &[f64]) -> f64 {
        let far = |(scale, value): (&Scale, &f64)| {
            scale.weight * (UTOPIA + (scale.ideal - scale.direction.fitness(*value)) / scale.range)
        };
        let farness: Vec<f64> = self.scales.iter().zip(each).map(far).collect();
        let farthest = farness.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let distance = farthest + SUM * farness.iter().sum::<f64>();
        self.scales.first().map_or(0.0, |first| first.direction.fitness(-distance * first.range))
    }

    /// Whether other values confirm those of all objectives, each by the share that the search asks for. What they are where nothing
    /// moves is no part of what a motion is worth.
    pub(super) fn keeps(&self, keep: f64, at_rest: &[f64], each: &[f64], other: &[f64]) -> bool {
        let at_rest = at_rest.iter().copied().chain(std::iter::repeat(0.0));
        let all = self.scales.iter().zip(at_rest).zip(each.iter().zip(other));
        each.len() == other.len() && { all }.all(|((scale, at_rest), (value, other))| {
            let fitness = |x: &f64| scale.direction.fitness(*x);
            let near_zero = if scale.has_range { OF_RANGE * scale.range } else { 0.0 };
            let size = (value - at_rest).abs().max(near_zero);
            fitness(other) >= fitness(value) - (1.0 - keep) * size
        })
    }

    /// Whether a design is as good as these values in every objective, or better.
    pub(super) fn is_covered(&self, each: &[f64], front: &[Vec<f64>]) -> bool {
        let covers = |other: &&Vec<f64>| {
            self.scales
                .iter()
                .zip(other.iter().zip(each))
                .all(|(scale, (other, own))| scale.direction.fitness(*other) >= scale.direction.fitness(*own))
        };
        front.iter().any(|other| covers(&other))
    }

    /// All that it says, for a name of what is evaluated by it.
    pub(super) fn bits(&self) -> Vec<u8> {
        let numbers = self.scales.iter().flat_map(|scale| [scale.weight, scale.ideal, scale.range]);
        numbers.flat_map(|x| x.to_bits().to_le_bytes()).collect()
    }
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::{Expr, ExprKind, Ty};

    use super::*;

    fn objectives() -> [Objective; 2] {
        let value = Expr { kind: ExprKind::Number(0.0), ty: Ty::NUMBER, span: Default::default() };
        [Direction::Maximize, Direction::Minimize].map(|direction| Objective {
            direction,
            value: value.clone(),
            unit: String::new(),
        })
    }

    fn aim(front: &[Vec<f64>], seed: u64) -> Aim {
        Aim::draw(objectives().iter(), front, &mut Stream::named(seed, "aim"))
    }

    /// As long as there is no front, nothing says what is near zero: a loss of half of a small value is a loss.
    #[test]
    fn the_first_design_keeps_small_values_too() {
        let (at_rest, each, closer) = ([0.0, 0.0], [10.0, 0.0084], [10.0, 0.0124]);
        assert!(!aim(&[], 0).keeps(0.8, &at_rest, &each, &closer));
        assert!(aim(&[], 0).keeps(0.8, &at_rest, &each, &[9.0, 0.0098]));
        // Beside designs of 1 J, four millijoules are next to nothing.
        let front = [vec![10.0, 0.0084], vec![20.0, 1.0]];
        assert!(aim(&front, 0).keeps(0.8, &at_rest, &each, &closer));
    }

    #[test]
    fn what_is_better_in_one_objective_and_no_worse_in_another_is_better_by_any_weights() {
        let front = [vec![10.0, 2.0], vec![40.0, 8.0]];
        for seed in 0..200 {
            let aim = aim(&front, seed);
            assert!(aim.value(&[30.0, 5.0]) > aim.value(&[29.0, 5.0]));
            assert!(aim.value(&[30.0, 5.0]) >= aim.value(&[30.0, 5.5]), "by the first alone they are equal");
            assert!(
                aim.value(&[41.0, 1.0]) > aim.value(&[40.0, 2.0]),
                "better than the best of each is better"
            );
            assert!(aim.value(&[40.0, 2.0]) < 0.0);
        }
    }

    #[test]
    fn each_design_of_a_hollow_front_is_the_best_by_some_weights() {
        // The one between is below the line through the others: by no weighted sum would it be the best.
        let front = [vec![0.0, 0.0], vec![4.0, 6.0], vec![10.0, 10.0]];
        let mut won = [0; 3];
        for seed in 0..200 {
            let aim = aim(&front, seed);
            let values: Vec<f64> = front.iter().map(|each| aim.value(each)).collect();
            let best = (0..3).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap();
            won[best] += 1;
        }
        assert!(won.iter().all(|times| *times > 5), "{won:?}");
        assert!(won[2] > 80, "half of the moves are after the first objective: {won:?}");
    }

    #[test]
    fn without_a_front_it_is_the_first_objective() {
        let aim = aim(&[], 3);
        assert!(aim.value(&[7.0, 100.0]) > aim.value(&[6.0, 1.0]));
    }

    #[test]
    fn every_objective_must_be_kept_but_next_to_nothing_may_change() {
        let aim = aim(&[vec![0.0, 0.0], vec![40.0, 8.0]], 1);
        assert!(aim.keeps(0.8, &[], &[30.0, 5.0], &[25.0, 5.9]));
        assert!(!aim.keeps(0.8, &[], &[30.0, 5.0], &[23.0, 5.0]));
        assert!(!aim.keeps(0.8, &[], &[30.0, 5.0], &[30.0, 6.1]));
        // A hundredth of a joule against a front of eight.
        assert!(aim.keeps(0.8, &[], &[30.0, 0.01], &[30.0, 0.1]));
        assert!(!aim.keeps(0.8, &[], &[30.0, 0.01], &[30.0, 0.3]));
    }
}
