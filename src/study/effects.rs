//! Which factor matters, and by how much: marginal means, differences between levels, and shares of the spread.
//!
//! The mean of a level is that of the means of its cells, so that a cell with fewer runs counts as much as another. Its
//! variance is the sum over these cells of s^2 / n, divided by the square of their number, and its interval is that of Student's t with
//! the degrees of freedom of Welch and Satterthwaite (Satterthwaite 1946, Biometrics Bulletin 2, 110).

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The share of intervals that contain what they are for.
const CONFIDENCE: f64 = 0.95;

/// The numbers of the runs of one cell.
#[derive(Clone, Debug)]
pub struct CellValues {
    /// The place of its level in each factor.
    pub levels: Vec<usize>,
    /// A number for each of its runs that came to one.
    pub values: Vec<f64>,
}

/// A mean or a difference with its interval; none where no cell has two runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Half of the width of its 95 % interval.
    pub margin: Option<f64>,
}

impl Estimate {
    /// Whether zero is outside of the interval.
    #[must_use]
    pub fn is_apart_from_zero(&self) -> bool {
        self.margin.is_some_and(|margin| self.mean.abs() > margin)
    }
}

/// What one factor does.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The place of the factor.
    pub factor: usize,
    /// The mean of each level; none where no run of it came to a number.
    pub levels: Vec<Option<Estimate>>,
    /// The levels with the highest and the lowest mean, and by how much they differ.
    pub widest: (usize, usize, Estimate),
    /// Its share of the spread of all runs.
    pub share: f64,
}

/// What a study says of its factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Effects {
    /// The factors with several levels, the one with the largest share first.
    pub factors: Vec<Effect>,
    /// The share of the spread that is there between runs that differ in nothing but the seed.
    pub seeds: f64,
    /// The share that no factor alone explains: what factors do together.
    pub together: f64,
}

/// A mean of cells with what its interval needs.
#[derive(Clone, Copy, Debug, Default)]
struct Pooled {
    mean: f64,
    /// The variance of the mean.
    variance: f64,
    /// The sum of v_i^2 / (n_i - 1) over the parts v_i of that.
    squares: f64,
}

impl Pooled {
    /// The mean of the means of cells.
    fn of<'a>(cells: impl Iterator<Item = &'a CellValues>) -> Option<Self> {
        let (mut count, mut sum, mut parts) = (0.0, 0.0, Vec::new());
        for cell in cells.filter(|cell| !cell.values.is_empty()) {
            let (mean, variance) = mean_and_variance(&cell.values);
            let n = cell.values.len() as f64;
            count += 1.0;
            sum += mean;
            parts.extend(variance.map(|variance| (variance / n, n - 1.0)));
        }
        if count < 1.0 {
            return None;
        }
        // Cells with a single run say nothing of the spread: as much as the others is assumed of them.
        let scale = if parts.is_empty() { 0.0 } else { count / parts.len() as f64 };
        let parts = parts.iter().map(|(part, free)| (part * scale / (count * count), free));
        let (mut variance, mut squares) = (0.0, 0.0);
        for (part, free) in parts {
            variance += part;
            squares += part * part / free;
        }
        Some(Self { mean: sum / count, variance, squares })
    }

    fn minus(&self, other: &Self) -> Self {
        Self {
            mean: self.mean - other.mean,
            variance: self.variance + other.variance,
            squares: self.squares + other.squares,
        }
    }

    fn estimate(&self) -> Estimate {
        let margin = match self.variance > 0.0 && self.squares > 0.0 {
            true => {
                let free = self.variance * self.variance / self.squares;
                let t = StudentsT::new(0.0, 1.0, free).ok();
                t.map(|t| t.inverse_cdf(0.5 + CONFIDENCE / 2.0) * self.variance.sqrt())
            }
            false => None,
        };
        Estimate { mean: self.mean, margin }
    }
}

/// The mean of some numbers, and their variance if there are several.
fn mean_and_variance(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n.max(1.0);
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (mean, (n > 1.0).then(|| squares / (n - 1.0)))
}

/// The mean of one cell, with its interval.
#[must_use]
pub fn of_cell(cell: &CellValues) -> Option<Estimate> {
    Pooled::of(std::iter::once(cell)).map(|pooled| pooled.estimate())
}

/// What each factor does, of which `levels` says how many it has; none where fewer than two cells came to a number.
#[must_use]
pub fn effects(levels: &[usize], cells: &[CellValues]) -> Option<Effects> {
    let known: Vec<&CellValues> = cells.iter().filter(|cell| !cell.values.is_empty()).collect();
    if known.len() < 2 {
        return None;
    }
    let many = known.len() as f64;
    let means: Vec<(f64, f64)> = known
        .iter()
        .map(|cell| {
            let n = cell.values.len() as f64;
            let (mean, variance) = mean_and_variance(&cell.values);
            // That of these runs, not of all that could be made.
            (mean, variance.unwrap_or(0.0) * (n - 1.0) / n)
        })
        .collect();
    let grand = means.iter().map(|(mean, _)| mean).sum::<f64>() / many;
    let between = means.iter().map(|(mean, _)| (mean - grand) * (mean - grand)).sum::<f64>() / many;
    let within = means.iter().map(|(_, variance)| variance).sum::<f64>() / many;
    let whole = between + within;
    let share = |part: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    let mut factors: Vec<Effect> = Vec::new();
    let mut explained = 0.0;
    for (factor, &count) in levels.iter().enumerate().filter(|(_, count)| **count > 1) {
        let at =
            |level: usize| known.iter().copied().filter(move |cell| cell.levels.get(factor) == Some(&level));
        let pooled: Vec<Option<Pooled>> = (0..count).map(|level| Pooled::of(at(level))).collect();
        let own: f64 = pooled
            .iter()
            .enumerate()
            .filter_map(|(level, pooled)| {
                let apart = pooled.as_ref()?.mean - grand;
                Some(apart * apart * at(level).count() as f64 / many)
            })
            .sum();
        let valued =
            || pooled.iter().enumerate().filter_map(|(level, pooled)| Some((level, pooled.as_ref()?)));
        let by_mean = |a: &(usize, &Pooled), b: &(usize, &Pooled)| a.1.mean.total_cmp(&b.1.mean);
        let (Some(high), Some(low)) = (valued().max_by(by_mean), valued().min_by(by_mean)) else { continue };
        explained += own;
        factors.push(Effect {
            factor,
            levels: pooled.iter().map(|pooled| pooled.as_ref().map(Pooled::estimate)).collect(),
            widest: (high.0, low.0, high.1.minus(low.1).estimate()),
            share: share(own),
        });
    }
    factors.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.factor.cmp(&b.factor)));
    Some(Effects { factors, seeds: share(within), together: share((between - explained).max(0.0)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(levels: &[usize], values: &[f64]) -> CellValues {
        CellValues { levels: levels.to_vec(), values: values.to_vec() }
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
        assert_eq!((first.factor, first.widest.0, first.widest.1, first.widest.2.mean), (0, 1, 0, 10.0));
        // 25 between, 1 within.
        assert!((first.share - 25.0 / 26.0).abs() < 1e-12 && (found.seeds - 1.0 / 26.0).abs() < 1e-12);
        assert_eq!((second.share, second.widest.2.mean, found.together), (0.0, 0.0, 0.0));
        assert!(first.widest.2.is_apart_from_zero() && !second.widest.2.is_apart_from_zero());
    }

    /// Of one cell with n runs the interval is t s / sqrt(n); of two samples with equal variances and sizes, Welch's has
    /// 2 (n - 1) degrees of freedom.
    #[test]
    fn intervals_are_those_of_the_textbook() {
        let one = of_cell(&cell(&[0], &[1.0, 2.0, 3.0, 4.0, 5.0])).unwrap();
        assert_eq!(one.mean, 3.0);
        // t(0.975; 4) = 2.776445, s = 1.581139.
        assert!((one.margin.unwrap() - 2.776_445 * 1.581_139 / 5.0_f64.sqrt()).abs() < 1e-5, "{one:?}");
        let pair = [cell(&[0], &[1.0, 2.0, 3.0]), cell(&[1], &[4.0, 5.0, 6.0])];
        let apart = effects(&[2], &pair).unwrap().factors[0].widest.2;
        // t(0.975; 4) again: sqrt(1/3 + 1/3).
        assert!((apart.margin.unwrap() - 2.776_445 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-5, "{apart:?}");
    }

    #[test]
    fn what_factors_do_together_is_no_factors() {
        let cells =
            [cell(&[0, 0], &[1.0]), cell(&[0, 1], &[-1.0]), cell(&[1, 0], &[-1.0]), cell(&[1, 1], &[1.0])];
        let found = effects(&[2, 2], &cells).unwrap();
        assert_eq!((found.together, found.seeds), (1.0, 0.0));
        assert!(found.factors.iter().all(|effect| effect.share == 0.0 && effect.widest.2.margin.is_none()));
    }

    #[test]
    fn missing_runs_leave_the_others() {
        assert_eq!(effects(&[2], &[cell(&[0], &[1.0]), cell(&[1], &[])]), None);
        let found = effects(&[3], &[cell(&[0], &[1.0, 2.0]), cell(&[1], &[]), cell(&[2], &[4.0])]).unwrap();
        assert_eq!(found.factors[0].levels[1], None);
        assert_eq!((found.factors[0].widest.0, found.factors[0].widest.1), (2, 0));
        let alike = effects(&[2], &[cell(&[0], &[1.0, 1.0]), cell(&[1], &[1.0, 1.0])]).unwrap();
        assert_eq!((alike.factors[0].share, alike.factors[0].widest.2.margin), (0.0, None));
    }
}
