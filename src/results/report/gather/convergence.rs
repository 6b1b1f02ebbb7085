//! The best value so far, against evaluations and against moves of bodies.

use super::spread::{Spread, mean};
use super::{or_empty, table};
use crate::results::report::moves::Move;
use crate::results::report::read::{Group, Run};

/// Into how many steps a course is divided.
const STEPS: u64 = 200;

/// What the best value is shown against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Against {
    Evaluations,
    Moves,
}

impl Against {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Evaluations => "evaluations",
            Self::Moves => "moves",
        }
    }

    fn of(self, made: &Move) -> u64 {
        match self {
            Self::Evaluations => made.evaluations,
            Self::Moves => made.number,
        }
    }
}

/// The best values of a group's runs at one place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    pub(crate) x: u64,
    /// Runs that are so far and have a value; complete runs keep theirs.
    pub(crate) runs: usize,
    pub(crate) mean: f64,
    pub(crate) median: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
    /// Of the run that is best in the end.
    pub(crate) best: Option<f64>,
}

/// The course of a group.
pub(crate) fn course(group: &Group, against: Against) -> Vec<Point> {
    let last = |run: &Run| run.moves.last().map_or(0, |m| against.of(m));
    let end = group.runs.iter().map(last).max().unwrap_or(0);
    let mut places: Vec<u64> = (0..=STEPS).map(|i| end * i / STEPS).collect();
    places.dedup();
    let best = group.best().map(|(_, run)| run);
    let point = |x: u64| {
        let values: Vec<f64> = group.runs.iter().filter_map(|run| at(run, against, x)).collect();
        let spread = Spread::of(values)?;
        Some(Point {
            x,
            runs: spread.count,
            mean: spread.mean,
            median: spread.median,
            min: spread.min,
            max: spread.max,
            best: best.and_then(|run| at(run, against, x)),
        })
    };
    places.into_iter().filter_map(point).collect()
}

/// The best value of a run when it had come so far; none if it has not, or had no value yet.
fn at(run: &Run, against: Against, x: u64) -> Option<f64> {
    let is_beyond = run.moves.last().is_none_or(|m| against.of(m) < x);
    if is_beyond && !run.is_complete() {
        return None;
    }
    // Rows are in order: the last of those up to here.
    let until = run.moves.partition_point(|m| against.of(m) <= x);
    run.moves.get(until.checked_sub(1)?)?.best
}

/// How many evaluations it took on average, over the runs with a gain, to reach half of what was gained in the end.
pub(crate) fn half_way(group: &Group) -> Option<f64> {
    let reached = group.runs.iter().filter_map(|run| {
        let first = group.fitness(run.moves.iter().find_map(|m| m.best)?);
        let last = group.fitness(run.value()?);
        let half = (first + last) / 2.0;
        let made = run.moves.iter().find(|m| m.best.is_some_and(|best| group.fitness(best) >= half))?;
        (last > first).then_some(made.evaluations as f64)
    });
    mean(reached)
}

/// How many runs found their best in the last tenth of their evaluations.
pub(crate) fn still_rising(group: &Group) -> usize {
    let late =
        |run: &&Run| run.found().is_some_and(|m| m.evaluations * 10 >= run.evaluations() * 9 && m.number > 0);
    group.runs.iter().filter(late).count()
}

/// `convergence.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns = ["group", "against", "x", "runs", "mean", "median", "min", "max", "best_run"];
    let rows = groups.iter().flat_map(|group| {
        [Against::Evaluations, Against::Moves].into_iter().flat_map(move |against| {
            course(group, against).into_iter().map(move |point| {
                [
                    group.name.clone(),
                    against.text().to_owned(),
                    point.x.to_string(),
                    point.runs.to_string(),
                    point.mean.to_string(),
                    point.median.to_string(),
                    point.min.to_string(),
                    point.max.to_string(),
                    or_empty(point.best),
                ]
            })
        })
    });
    table(columns, rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{group, run, two};
    use super::*;
    use crate::results::report::read::Standing;

    fn means(points: &[Point]) -> Vec<(u64, usize, f64)> {
        points.iter().map(|p| (p.x, p.runs, p.mean)).collect()
    }

    #[test]
    fn a_run_holds_its_best_until_it_finds_a_better_one() {
        // By evaluations: run 1 has 0 at 1, 4 at 2 and 8 at 8; run 2 has 0 at 1 and 2 at 4, and ends at 6.
        let points = course(&two(), Against::Evaluations);
        assert_eq!(
            means(&points),
            [
                (1, 2, 0.0),
                (2, 2, 2.0),
                (3, 2, 2.0),
                (4, 2, 3.0),
                (5, 2, 3.0),
                (6, 2, 3.0),
                (7, 2, 3.0),
                (8, 2, 5.0)
            ]
        );
        let last = points.last().unwrap();
        assert_eq!((last.min, last.median, last.max, last.best), (2.0, 5.0, 8.0, Some(8.0)));
        let points = course(&two(), Against::Moves);
        assert_eq!(means(&points)[..2], [(0, 2, 0.0), (1, 2, 3.0)]);
    }

    #[test]
    fn a_run_that_is_not_complete_counts_as_far_as_it_is() {
        let mut group = two();
        group.runs[1].standing = Standing::Stopped;
        let points = course(&group, Against::Evaluations);
        assert_eq!(means(&points)[5..], [(6, 2, 3.0), (7, 1, 4.0), (8, 1, 8.0)]);
    }

    #[test]
    fn when_the_gain_came() {
        // Run 1 gains 8 and has 4 at the second evaluation; run 2 gains 2 and has it at the fourth.
        assert_eq!(half_way(&two()), Some(3.0));
        // Run 1 found its best at the last of 8 evaluations, run 2 at the fourth of 6.
        assert_eq!(still_rising(&two()), 1);
        assert_eq!(course(&group(vec![run(1, "")]), Against::Moves), []);
        assert_eq!(half_way(&group(vec![run(1, "0,0,,,1,0,2,true,2,0,1,0,0,\n")])), None);
    }
}
