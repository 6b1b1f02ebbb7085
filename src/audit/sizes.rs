//! The distribution of a number over designs.

use serde::Serialize;

/// How a number is distributed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sizes {
    /// The least.
    pub min: usize,
    /// The mean.
    pub mean: f64,
    /// The greatest.
    pub max: usize,
    /// How many designs have each number, from the least to the greatest.
    pub counts: Vec<usize>,
}

impl Sizes {
    /// The distribution of these numbers.
    #[must_use]
    pub fn of(numbers: &[usize]) -> Self {
        let (Some(min), Some(max)) = (numbers.iter().min().copied(), numbers.iter().max().copied()) else {
            return Self::default();
        };
        let mean = numbers.iter().sum::<usize>() as f64 / numbers.len() as f64;
        let counts = (min..=max).map(|n| numbers.iter().filter(|x| **x == n).count()).collect();
        Self { min, mean, max, counts }
    }

    /// The distribution in at most so many bins: least, greatest and how many of each.
    #[must_use]
    pub fn bins(&self, most: usize) -> Vec<(usize, usize, usize)> {
        let width = self.counts.len().div_ceil(most.max(1)).max(1);
        let bins = self.counts.chunks(width).enumerate();
        bins.map(|(i, bin)| {
            let low = self.min + i * width;
            (low, low + bin.len() - 1, bin.iter().sum())
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_every_number_once() {
        let sizes = Sizes::of(&[3, 3, 4, 9, 12]);
        assert_eq!((sizes.min, sizes.max, sizes.mean), (3, 12, 6.2));
        assert_eq!(sizes.bins(5), [(3, 4, 3), (5, 6, 0), (7, 8, 0), (9, 10, 1), (11, 12, 1)]);
        assert_eq!(Sizes::of(&[]).bins(5), []);
    }
}
