//! The designs that no other is better than in every objective (the Pareto front), so many of them. A move weighs the objectives anew,
//! takes a design that is good by these weights, and changes it by a rule or tunes its curves further.

use std::sync::Arc;

use grammar_lang::ir::{Direction, RuleSet};

use super::super::Failure;
use super::super::aim::Aim;
use super::super::state::{Best, Designs, Incumbent, Member, Tune, Tuned};
use super::Bodies;
use crate::derive::Derivation;
use crate::derive::random::Stream;
use crate::score;

/// The values of one design in all objectives, each on a scale where more is better.
type Point = Vec<f64>;

/// Whether one is nowhere worse than the other.
fn covers(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).all(|(a, b)| a >= b)
}

/// How much of the space in which all is better than a worst corner is covered by points: the hypervolume (Zitzler and Thiele 1998). By
/// slices of the last objective.
pub(crate) fn hypervolume(points: &[Point], worst: &[f64]) -> f64 {
    let Some((bottom, rest)) = worst.split_last() else { return 1.0 };
    let mut order: Vec<&Point> = points.iter().filter(|point| point.len() == worst.len()).collect();
    let last = |point: &Point| point.last().copied().unwrap_or(f64::NEG_INFINITY);
    order.sort_by(|a, b| last(b).total_cmp(&last(a)));
    let mut volume = 0.0;
    for (place, point) in order.iter().enumerate() {
        let top = last(point);
        let below = order.get(place + 1).map_or(*bottom, |next| last(next)).max(*bottom);
        if top <= below {
            continue;
        }
        // All down to this one reach into the slice below it.
        let slice: Vec<Point> = order[..=place].iter().map(|point| point[..rest.len()].to_vec()).collect();
        let inside: Vec<Point> =
            slice.into_iter().filter(|point| point.iter().zip(rest).all(|(x, low)| x > low)).collect();
        let area = if rest.is_empty() { 1.0 } else { hypervolume(&inside, rest) };
        volume += (top - below) * area;
    }
    volume
}

/// Which of more points than there is room for is missed least: the one without which the least hypervolume is lost. The best of each
/// objective stay. Of equals the last that came in goes.
fn least_missed(points: &[Point]) -> Option<usize> {
    let worst = corner(points, f64::min);
    let best = corner(points, f64::max);
    // As shares of the front, so that no unit weighs more than another.
    let share = |point: &Point| -> Point {
        let ends = worst.iter().zip(&best);
        point
            .iter()
            .zip(ends)
            .map(|(x, (low, high))| if high > low { (x - low) / (high - low) } else { 0.0 })
            .collect()
    };
    let shares: Vec<Point> = points.iter().map(share).collect();
    let zero = vec![0.0; worst.len()];
    // Of equals in an objective the one that is best in the others: else all of them would stay.
    let ends: Vec<Option<usize>> = (0..best.len())
        .map(|objective| {
            let at_best =
                (0..points.len()).filter(|place| points[*place].get(objective) == best.get(objective));
            let sum = |place: usize| shares.get(place).map_or(0.0, |share| share.iter().sum::<f64>());
            at_best.reduce(|one, other| if sum(other) > sum(one) { other } else { one })
        })
        .collect();
    let without = |left_out: usize| {
        let rest: Vec<Point> = shares
            .iter()
            .enumerate()
            .filter(|(place, _)| *place != left_out)
            .map(|(_, p)| p.clone())
            .collect();
        hypervolume(&rest, &zero)
    };
    let inner = (0..points.len()).filter(|place| !ends.contains(&Some(*place)));
    inner.map(|place| (place, without(place))).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(place, _)| place)
}

/// The least or the greatest in every objective.
fn corner(points: &[Point], which: fn(f64, f64) -> f64) -> Point {
    let mut points = points.iter();
    let Some(first) = points.next() else { return Vec::new() };
    points.fold(first.clone(), |corner, point| corner.iter().zip(point).map(|(a, b)| which(*a, *b)).collect())
}

/// The values of a design where more is better.
pub(crate) fn point(rules: &RuleSet, each: &[f64]) -> Vec<f64> {
    let directions = rules.objectives().map(|objective| objective.direction);
    directions.zip(each).map(|(direction, value): (Direction, &f64)| direction.fitness(*value)).collect()
}

impl Bodies<'_> {
    /// What the move of a number is after; none where no front is searched for.
    pub(super) fn aim(&self, number: usize) -> Option<Aim> {
        self.rules.search.front()?;
        let mut random = Stream::named(self.seed, &format!("aim {number}"));
        let known: Vec<Vec<f64>> = self.parents().iter().map(|member| member.best.each()).collect();
        Some(Aim::draw(self.rules.objectives(), &known, &mut random))
    }

    /// What a design comes to in the objectives beside the first; nothing where no front is searched for.
    pub(super) fn beside(&self, derivation: &Derivation, tunes: &[Tune]) -> Result<Vec<f64>, Failure> {
        if self.rules.search.front().is_none() || tunes.is_empty() {
            return Ok(Vec::new());
        }
        let names = self.rules.tasks.keys().map(String::as_str);
        let values: Vec<(&str, f64)> = names.zip(tunes.iter().map(|tune| tune.value)).collect();
        let each = tunes.first().map_or(&[][..], |tune| &tune.each);
        Ok(score::beside(self.rules, derivation, &values, each)?)
    }

    /// Whether what a design comes to beside its first objective is nowhere worse than that of another, and better somewhere.
    pub(super) fn is_ahead(&self, beside: &[f64], other: &[f64]) -> bool {
        let objectives = || self.rules.objectives().skip(1);
        let on_scale = |values: &[f64]| -> Point {
            objectives().zip(values).map(|(objective, x)| objective.direction.fitness(*x)).collect()
        };
        let (new, old) = (on_scale(beside), on_scale(other));
        new.len() == old.len() && covers(&new, &old) && !covers(&old, &new)
    }

    /// Keeps a design if no other is as good in every objective; those that it is better than leave. Whether it is kept.
    pub(super) fn keep_on_front(
        &mut self,
        place: &Incumbent<Arc<Derivation>>,
        beside: &[f64],
        tuned: &Tuned,
    ) -> Result<bool, Failure> {
        let rules = self.rules;
        let (Some(_), Some(value)) = (rules.search.front(), place.value) else { return Ok(false) };
        let size = self.size(self.state.spent)?;
        let Some(Designs::Front(members)) = &mut self.state.designs else { return Ok(false) };
        let Incumbent { number, derivation, tunes, .. } = place.clone();
        let best = Best { derivation, tasks: tunes, value, beside: beside.to_vec(), found_at: number };
        let own = point(rules, &best.each());
        let points = |members: &[Arc<Member<_>>]| -> Vec<Point> {
            members.iter().map(|member| point(rules, &member.best.each())).collect()
        };
        if points(members).iter().any(|other| covers(other, &own)) {
            return Ok(false);
        }
        members.retain(|member| !covers(&own, &point(rules, &member.best.each())));
        members.push(Arc::new(Member { best, tuned: tuned.clone() }));
        let mut is_kept = true;
        while members.len() > size
            && let Some(least) = least_missed(&points(members))
        {
            is_kept &= least + 1 < members.len();
            members.remove(least);
        }
        if is_kept {
            let kept: Vec<Best> = members.iter().map(|member| member.best.clone()).collect();
            self.observer.on_front(&kept)?;
        }
        Ok(is_kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points<const N: usize>(points: &[[f64; N]]) -> Vec<Point> {
        points.iter().map(|point| point.to_vec()).collect()
    }

    #[test]
    fn the_hypervolume_is_what_the_points_cover() {
        assert_eq!(hypervolume(&[], &[0.0, 0.0]), 0.0);
        assert_eq!(hypervolume(&points(&[[2.0, 3.0]]), &[0.0, 1.0]), 4.0);
        // Two boxes that overlap: 3 x 1 + 1 x 3 - 1 x 1.
        assert_eq!(hypervolume(&points(&[[3.0, 1.0], [1.0, 3.0]]), &[0.0, 0.0]), 5.0);
        // What is covered adds nothing, nor does what is below the corner.
        assert_eq!(
            hypervolume(&points(&[[3.0, 1.0], [1.0, 3.0], [1.0, 1.0], [-1.0, 9.0]]), &[0.0, 0.0]),
            5.0
        );
    }

    #[test]
    fn the_hypervolume_of_three_objectives_is_that_of_the_union_of_boxes() {
        let three = points(&[[2.0, 2.0, 2.0], [3.0, 1.0, 1.0], [1.0, 3.0, 1.0]]);
        let mut counted = 0;
        for x in 0..30 {
            for y in 0..30 {
                for z in 0..30 {
                    let at = [x, y, z].map(|i| (f64::from(i) + 0.5) / 10.0);
                    counted += i32::from(three.iter().any(|point| covers(point, &at)));
                }
            }
        }
        assert!((hypervolume(&three, &[0.0; 3]) - f64::from(counted) / 1000.0).abs() < 1e-9);
    }

    /// Where all are equal in an objective, one of them is enough to be the best by it.
    #[test]
    fn of_equals_in_an_objective_one_stays() {
        let points = points(&[[1.0, 5.0, 1.0], [1.0, 3.0, 3.0], [1.0, 1.0, 5.0], [1.0, 2.9, 2.9]]);
        assert_eq!(least_missed(&points), Some(3));
        let mut rest = points;
        while let Some(place) = least_missed(&rest) {
            rest.remove(place);
        }
        assert!(rest.len() <= 3, "{rest:?}");
    }

    #[test]
    fn the_point_in_a_crowd_is_missed_least_and_never_the_best_of_an_objective() {
        let crowd = points(&[[0.0, 10.0], [4.9, 5.0], [5.0, 4.9], [8.0, 3.0], [10.0, 0.0]]);
        assert!(matches!(least_missed(&crowd), Some(1 | 2)));
        // The units of the objectives weigh nothing.
        let scaled: Vec<Point> = crowd.iter().map(|p| vec![p[0] * 1000.0, p[1] / 50.0]).collect();
        assert_eq!(least_missed(&scaled), least_missed(&crowd));
        assert_eq!(least_missed(&points(&[[0.0, 1.0], [1.0, 0.0]])), None);
    }
}
