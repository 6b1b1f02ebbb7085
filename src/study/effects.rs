//! Which factor matters, and by how much: means of levels, differences between levels, and shares of the spread.
//!
//! Runs of one seed begin with the same random numbers in every cell, so their values are not independent. The seeds are
//! therefore the samples: a mean of a level is taken for each seed first, and a difference between two levels only between cells that differ in nothing
//! else, seed by seed. The interval is that of Student's t over the seeds (a paired comparison). Of several levels the highest and the lowest are
//! compared because they are that: the interval is widened for all pairs that could have been (Bonferroni).

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The share of intervals that do not contain what they are for.
const MISSES: f64 = 0.05;
/// A smaller share is rounding.
const ROUNDING: f64 = 1e-9;

/// The numbers of the runs of one cell.
#[derive(Clone, Debug)]
pub struct CellValues {
    /// The place of its level in each factor.
    pub levels: Vec<usize>,
    /// By seed, in the order of the study; none of a run that came to no number.
    pub by_seed: Vec<Option<f64>>,
}

impl CellValues {
    /// The numbers that there are.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.by_seed.iter().flatten().copied()
    }

    fn mean(&self) -> Option<f64> {
        mean(&self.values().collect::<Vec<_>>())
    }
}

/// A mean or a difference with its interval; none of a single seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Half of the width of its 95 % interval.
    pub margin: Option<f64>,
}

impl Estimate {
    /// Of numbers that are independent, one of so many comparisons; none of no number.
    fn of(values: &[f64], comparisons: usize) -> Option<Self> {
        let mean = mean(values)?;
        let n = values.len() as f64;
        let free = n - 1.0;
        let margin = StudentsT::new(0.0, 1.0, free).ok().filter(|_| free > 0.0).map(|t| {
            let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
            let tail = MISSES / 2.0 / comparisons.max(1) as f64;
            t.inverse_cdf(1.0 - tail) * (squares / free / n).sqrt()
        });
        Some(Self { mean, margin })
    }

    /// Whether zero is outside of the interval.
    #[must_use]
    pub fn is_apart_from_zero(&self) -> bool {
        self.margin.is_some_and(|margin| self.mean.abs() > margin)
    }

    /// Whether all that it is of is zero.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.mean == 0.0 && self.margin.is_none_or(|margin| margin == 0.0)
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    if values.is_empty() { None } else { Some(values.iter().sum::<f64>() / values.len() as f64) }
}

/// What one factor does.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The place of the factor.
    pub factor: usize,
    /// The mean of each level; none where no run of it came to a number.
    pub levels: Vec<Option<Estimate>>,
    /// The levels with the highest and the lowest mean, and by how much they differ; none where no two runs differ in them alone.
    pub widest: Option<(usize, usize, Estimate)>,
    /// Its share of the spread of these runs, chance included.
    pub share: f64,
}

/// What a study says of its factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Effects {
    /// The factors with several levels, the one with the largest share first.
    pub factors: Vec<Effect>,
    /// The share of the spread that is there between runs that differ in nothing but the seed.
    pub seeds: f64,
    /// The share that no factor alone explains: what factors do together, and chance.
    pub together: f64,
    /// How many seeds the means and shares are over.
    pub over: usize,
}

/// The mean of one cell, with its interval.
#[must_use]
pub fn of_cell(cell: &CellValues) -> Option<Estimate> {
    Estimate::of(&cell.values().collect::<Vec<_>>(), 1)
}

/// The mean of some cells for each seed that has a number in one of them, and over those seeds.
fn of_level(cells: &[&CellValues], seeds: usize) -> Option<Estimate> {
    let by_seed = (0..seeds).filter_map(|seed| {
        mean(&cells.iter().filter_map(|cell| *cell.by_seed.get(seed)?).collect::<Vec<_>>())
    });
    Estimate::of(&by_seed.collect::<Vec<_>>(), 1)
}

/// By how much two levels of a factor differ, between cells that differ in nothing else, seed by seed.
fn difference(
    all: &BTreeMap<&[usize], &CellValues>,
    (factor, high, low): (usize, usize, usize),
    (seeds, comparisons): (usize, usize),
) -> Option<Estimate> {
    let pairs: Vec<(&CellValues, &CellValues)> = all
        .values()
        .filter(|cell| cell.levels.get(factor) == Some(&high))
        .filter_map(|cell| {
            let mut levels = cell.levels.clone();
            *levels.get_mut(factor)? = low;
            Some((*cell, *all.get(levels.as_slice())?))
        })
        .collect();
    let by_seed = (0..seeds).filter_map(|seed| {
        let of = |cell: &CellValues| *cell.by_seed.get(seed)?;
        mean(&pairs.iter().filter_map(|(high, low)| Some(of(high)? - of(low)?)).collect::<Vec<_>>())
    });
    Estimate::of(&by_seed.collect::<Vec<_>>(), comparisons)
}

/// What each factor does, of which `levels` says how many it has; none where fewer than two cells came to a number.
#[must_use]
pub fn effects(levels: &[usize], cells: &[CellValues]) -> Option<Effects> {
    let known: Vec<&CellValues> = cells.iter().filter(|cell| cell.values().next().is_some()).collect();
    if known.len() < 2 {
        return None;
    }
    let all: BTreeMap<&[usize], &CellValues> =
        known.iter().map(|cell| (cell.levels.as_slice(), *cell)).collect();
    let seeds = known.iter().map(|cell| cell.by_seed.len()).max().unwrap_or(0);
    // While runs are missing, means and shares are over the seeds that every cell has, if there are two of them: else one level would
    // have other seeds than another.
    let has_all =
        |seed: &usize| known.iter().all(|cell| cell.by_seed.get(*seed).is_some_and(Option::is_some));
    let shared: Vec<usize> = (0..seeds).filter(has_all).collect();
    let over = if shared.len() < 2 { (0..seeds).collect() } else { shared };
    let kept: Vec<CellValues> = known
        .iter()
        .map(|cell| CellValues {
            levels: cell.levels.clone(),
            by_seed: over.iter().filter_map(|seed| cell.by_seed.get(*seed).copied()).collect(),
        })
        .collect();
    let known: Vec<&CellValues> = kept.iter().collect();
    let means: Vec<f64> = known.iter().filter_map(|cell| cell.mean()).collect();
    let many = known.len() as f64;
    let grand = means.iter().sum::<f64>() / many;
    let between = means.iter().map(|mean| (mean - grand) * (mean - grand)).sum::<f64>() / many;
    let spread = |(cell, mean): (&&CellValues, &f64)| {
        let squares: f64 = cell.values().map(|value| (value - mean) * (value - mean)).sum();
        squares / cell.values().count() as f64
    };
    let within = known.iter().zip(&means).map(spread).sum::<f64>() / many;
    let whole = between + within;
    let share = |part: f64| {
        let share = if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
        if share < ROUNDING { 0.0 } else { share }
    };
    let mut factors: Vec<Effect> = Vec::new();
    let mut explained = 0.0;
    for (factor, &count) in levels.iter().enumerate().filter(|(_, count)| **count > 1) {
        let at = |level: usize| -> Vec<&CellValues> {
            known.iter().copied().filter(|cell| cell.levels.get(factor) == Some(&level)).collect()
        };
        let own: f64 = (0..count)
            .filter_map(|level| {
                let cells = at(level);
                let apart = mean(&cells.iter().filter_map(|cell| cell.mean()).collect::<Vec<_>>())? - grand;
                Some(apart * apart * cells.len() as f64 / many)
            })
            .sum();
        explained += own;
        let estimates: Vec<Option<Estimate>> =
            (0..count).map(|level| of_level(&at(level), over.len())).collect();
        let valued =
            || estimates.iter().enumerate().filter_map(|(level, one)| Some((level, one.as_ref()?.mean)));
        let by_mean = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        let comparisons = valued().count() * valued().count().saturating_sub(1) / 2;
        let widest =
            valued().max_by(by_mean).zip(valued().min_by(by_mean)).and_then(|((high, _), (low, _))| {
                // Where all are equal, any two are compared.
                let low = if low == high {
                    valued().map(|(level, _)| level).find(|level| *level != high)?
                } else {
                    low
                };
                Some((high, low, difference(&all, (factor, high, low), (seeds, comparisons))?))
            });
        factors.push(Effect { factor, levels: estimates, widest, share: share(own) });
    }
    factors.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.factor.cmp(&b.factor)));
    Some(Effects {
        factors,
        seeds: share(within),
        together: share((between - explained).max(0.0)),
        over: over.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(levels: &[usize], values: &[f64]) -> CellValues {
        CellValues { levels: levels.to_vec(), by_seed: values.iter().copied().map(Some).collect() }
    }

    /// Two factors, the first worth 10, the second nothing; runs differ by 1.
    fn two_by_two() -> Vec<CellValues> {
        vec![
            cell(&[0, 0], &[9.0, 11.0]),
            cell(&[0, 1], &[9.0, 11.0]),
            cell(&[1, 0], &[19.0, 21.0]),
            cell(&[1, 1], &[19.0, 21.0]),
        ]
    }

    #[test]
    fn a_factor_that_matters_has_the_spread() {
        let found = effects(&[2, 2], &two_by_two()).unwrap();
        let [first, second] = &found.factors[..] else { panic!("{found:?}") };
        let (high, low, apart) = first.widest.unwrap();
        assert_eq!((first.factor, high, low, apart.mean, apart.margin), (0, 1, 0, 10.0, Some(0.0)));
        // 25 between, 1 within.
        assert!((first.share - 25.0 / 26.0).abs() < 1e-12 && (found.seeds - 1.0 / 26.0).abs() < 1e-12);
        assert!(apart.is_apart_from_zero());
        let (_, _, nothing) = second.widest.unwrap();
        assert!(nothing.is_nothing() && !nothing.is_apart_from_zero());
        assert_eq!((second.share, found.together), (0.0, 0.0));
    }

    /// A parameter that changes no run must not narrow the interval of another: the seeds are the samples.
    #[test]
    fn a_factor_that_does_nothing_narrows_no_interval() {
        let one = [cell(&[0], &[1.0, 2.0, 6.0]), cell(&[1], &[4.0, 5.5, 6.5])];
        let twice = |levels: &[usize]| {
            one.iter()
                .map(|own| cell(&[own.levels[0], levels[0]], &own.values().collect::<Vec<_>>()))
                .collect::<Vec<_>>()
        };
        let both = [twice(&[0]), twice(&[1])].concat();
        let of = |levels: &[usize], cells: &[CellValues]| {
            let found = effects(levels, cells).unwrap();
            let effect = found.factors.iter().find(|effect| effect.factor == 0).unwrap();
            (effect.levels.clone(), effect.widest)
        };
        assert_eq!(of(&[2], &one), of(&[2, 2], &both));
    }

    /// While one cell lacks a seed, a factor that changes no run has no share of the spread.
    #[test]
    fn missing_runs_give_no_factor_a_share() {
        let mut cells = [cell(&[0], &[1.0, 2.0, 9.0]), cell(&[1], &[1.0, 2.0, 9.0])];
        cells[1].by_seed[2] = None;
        let found = effects(&[2], &cells).unwrap();
        assert_eq!((found.factors[0].share, found.over), (0.0, 2));
        assert!(found.factors[0].levels.iter().all(|level| level.unwrap().mean == 1.5));
    }

    /// Of one cell with n runs the interval is t s / sqrt(n); of two levels it is that of the differences, seed by seed; of several it is
    /// widened for all pairs.
    #[test]
    fn intervals_are_those_of_the_textbook() {
        let one = of_cell(&cell(&[0], &[1.0, 2.0, 3.0, 4.0, 5.0])).unwrap();
        assert_eq!(one.mean, 3.0);
        // t(0.975; 4) = 2.776445, s = 1.581139.
        assert!((one.margin.unwrap() - 2.776_445 * 1.581_139 / 5.0_f64.sqrt()).abs() < 1e-5, "{one:?}");
        let pair = [cell(&[0], &[1.0, 2.0, 3.0]), cell(&[1], &[4.0, 6.0, 8.0])];
        let (_, _, apart) = effects(&[2], &pair).unwrap().factors[0].widest.unwrap();
        // Differences 3, 4, 5: t(0.975; 2) = 4.302653.
        assert_eq!(apart.mean, 4.0);
        assert!((apart.margin.unwrap() - 4.302_653 / 3.0_f64.sqrt()).abs() < 1e-5, "{apart:?}");
        let three = [pair.to_vec(), vec![cell(&[2], &[2.0, 2.0, 2.0])]].concat();
        let (_, _, apart) = effects(&[3], &three).unwrap().factors[0].widest.unwrap();
        // t(1 - 0.025 / 3; 2) = 7.648865.
        assert!((apart.margin.unwrap() - 7.648_865 / 3.0_f64.sqrt()).abs() < 1e-3, "{apart:?}");
    }

    /// Where nothing has an effect, one in twenty intervals misses zero with two levels, and fewer with ten.
    #[test]
    fn intervals_miss_as_often_as_they_say() {
        let mut random = crate::derive::Stream::named(1, "effects");
        for (levels, allowed) in [(2, 30..=70), (10, 1..=50)] {
            let missed = (0..1000).filter(|_| {
                let cells: Vec<CellValues> = (0..levels)
                    .map(|level| {
                        let values: Vec<f64> = (0..10).map(|_| random.normal(0.0, 1.0)).collect();
                        cell(&[level], &values)
                    })
                    .collect();
                let (_, _, apart) = effects(&[levels], &cells).unwrap().factors[0].widest.unwrap();
                apart.is_apart_from_zero()
            });
            let missed = missed.count();
            assert!(allowed.contains(&missed), "{missed} of 1000 with {levels} levels");
        }
    }

    #[test]
    fn what_factors_do_together_is_no_factors() {
        let cells =
            [cell(&[0, 0], &[1.0]), cell(&[0, 1], &[-1.0]), cell(&[1, 0], &[-1.0]), cell(&[1, 1], &[1.0])];
        let found = effects(&[2, 2], &cells).unwrap();
        assert_eq!((found.together, found.seeds), (1.0, 0.0));
        let unknown = |effect: &Effect| effect.share == 0.0 && effect.widest.unwrap().2.margin.is_none();
        assert!(found.factors.iter().all(unknown));
    }

    #[test]
    fn missing_runs_leave_the_others() {
        let none = |levels: &[usize]| CellValues { levels: levels.to_vec(), by_seed: vec![None, None] };
        assert_eq!(effects(&[2], &[cell(&[0], &[1.0]), none(&[1])]), None);
        // The second seed of the third level is missing: only the first is compared.
        let third = CellValues { levels: vec![2], by_seed: vec![Some(4.0), None] };
        let found = effects(&[3], &[cell(&[0], &[1.0, 2.0]), none(&[1]), third]).unwrap();
        assert_eq!(found.factors[0].levels[1], None);
        assert_eq!(found.factors[0].widest, Some((2, 0, Estimate { mean: 3.0, margin: None })));
    }
}
