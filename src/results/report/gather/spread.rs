//! How values are spread.

/// Some values in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    pub(crate) count: usize,
    pub(crate) mean: f64,
    /// The standard deviation of the sample; none of a single value.
    pub(crate) sd: Option<f64>,
    pub(crate) min: f64,
    /// A twentieth of the values lies below.
    pub(crate) low: f64,
    /// The quartiles.
    pub(crate) q1: f64,
    pub(crate) median: f64,
    pub(crate) q3: f64,
    /// A twentieth of the values lies above.
    pub(crate) high: f64,
    pub(crate) max: f64,
}

impl Spread {
    /// None of no values.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let (min, max) = (*values.first()?, *values.last()?);
        let count = values.len();
        let mean = mean(values.iter().copied())?;
        let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
        let at = |share| quantile(&values, share);
        Some(Self {
            count,
            mean,
            sd: (count > 1).then(|| (squares / (count - 1) as f64).sqrt()).filter(|sd| sd.is_finite()),
            min,
            low: at(0.05),
            q1: at(0.25),
            median: at(0.5),
            q3: at(0.75),
            high: at(0.95),
            max,
        })
    }
}

/// The mean; none of no values.
pub(crate) fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_u64), |(sum, n), x| (sum + x, n + 1));
    (count > 0).then(|| sum / count as f64)
}

/// A part of a number; none of zero.
pub(crate) fn share(part: u64, all: u64) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

/// Where a share of sorted values is reached, between two of them in proportion.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * sorted.len().saturating_sub(1) as f64;
    let at = |i: usize| sorted.get(i).or(sorted.last()).copied().unwrap_or(0.0);
    let below = place.floor() as usize;
    let (a, b) = (at(below), at(below + 1));
    a + (b - a) * (place - below as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_values_by_hand() {
        let spread = Spread::of([4.0, 1.0, 3.0, 2.0, 10.0]).unwrap();
        assert_eq!((spread.min, spread.q1, spread.median, spread.q3, spread.max), (1.0, 2.0, 3.0, 4.0, 10.0));
        // Deviations -3, -2, -1, 0, 6: squares 50, over 4.
        assert_eq!((spread.count, spread.mean, spread.sd), (5, 4.0, Some(12.5_f64.sqrt())));
        // A twentieth of the way from the first to the last of five is a fifth of the way to the second.
        assert_eq!(spread.low, 1.2);
        let two = Spread::of([1.0, 2.0]).unwrap();
        assert_eq!((two.q1, two.median, two.q3), (1.25, 1.5, 1.75));
    }

    #[test]
    fn one_value_has_no_deviation_and_none_no_spread() {
        let one = Spread::of([7.0]).unwrap();
        assert_eq!((one.mean, one.sd, one.q1, one.high), (7.0, None, 7.0, 7.0));
        assert_eq!(Spread::of([]), None);
        assert_eq!((mean([]), share(1, 0), share(1, 4)), (None, None, Some(0.25)));
    }
}
