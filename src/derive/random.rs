//! Random numbers: named streams that do not depend on platform or library version.

use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// A stream of random numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stream {
    generator: ChaCha8Rng,
}

impl Stream {
    /// The stream with this name under a seed: streams with different names are
    /// independent, whoever draws first.
    #[must_use]
    pub fn named(seed: u64, name: &str) -> Self {
        let mut hasher = Sha256::new();
        hasher.update(seed.to_le_bytes());
        hasher.update(name.as_bytes());
        Self { generator: ChaCha8Rng::from_seed(hasher.finalize().into()) }
    }

    /// A number in [0, 1) with 53 random bits.
    pub fn unit(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// A whole number below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.generator.next_u64()) * n as u128) >> 64) as usize
    }

    /// An index, drawn in proportion to the weights.
    pub fn weighted(&mut self, weights: &[f64]) -> usize {
        let mut rest = self.unit() * weights.iter().sum::<f64>();
        let mut last = 0;
        for (i, weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            last = i;
            if rest < *weight {
                return i;
            }
            rest -= weight;
        }
        last
    }

    /// A normally distributed number (Box and Muller).
    pub fn normal(&mut self, mean: f64, deviation: f64) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        mean + deviation * radius * libm::cos(2.0 * std::f64::consts::PI * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_repeatable_and_independent() {
        let (mut a, mut b, mut c) = (Stream::named(1, "x"), Stream::named(1, "x"), Stream::named(1, "y"));
        let first = a.unit();
        assert_eq!(first.to_bits(), b.unit().to_bits());
        assert_ne!(first.to_bits(), c.unit().to_bits());
    }

    #[test]
    fn normal_numbers_have_their_moments() {
        let mut random = Stream::named(7, "moments");
        let n = 20_000;
        let xs: Vec<f64> = (0..n).map(|_| random.normal(2.0, 3.0)).collect();
        let mean = xs.iter().sum::<f64>() / f64::from(n);
        let variance = xs.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / f64::from(n);
        assert!((mean - 2.0).abs() < 0.1, "{mean}");
        assert!((variance.sqrt() - 3.0).abs() < 0.1, "{variance}");
    }

    #[test]
    fn a_weight_of_zero_is_never_drawn() {
        let mut random = Stream::named(7, "weights");
        let mut drawn = [0; 3];
        for _ in 0..3000 {
            drawn[random.weighted(&[1.0, 0.0, 2.0])] += 1;
        }
        assert_eq!(drawn[1], 0);
        assert!((900..1100).contains(&drawn[0]), "{drawn:?}");
    }
}
