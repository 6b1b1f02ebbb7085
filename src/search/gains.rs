//! What the moves of annealing chains gained of late, and how likely the next one is to gain enough.

use std::collections::VecDeque;

/// So many moves of late say what the next ones may gain.
const LATE: usize = 40;

/// Gains by chain.
#[derive(Clone, Debug, Default)]
pub(super) struct Gains(Vec<VecDeque<f64>>);

impl Gains {
    pub(super) const NONE: Self = Self(Vec::new());

    /// What a move of a chain gained; negative infinity if it failed.
    pub(super) fn learn(&mut self, chain: usize, gain: f64) {
        if self.0.len() <= chain {
            self.0.resize(chain + 1, VecDeque::new());
        }
        let gains = &mut self.0[chain];
        if gains.len() == LATE {
            gains.pop_front();
        }
        gains.push_back(gain);
    }

    /// How likely the next move of a chain is to gain at least so much.
    pub(super) fn chance(&self, chain: usize, least: f64) -> f64 {
        let gains = self.0.get(chain);
        let (all, enough) =
            gains.map_or((0, 0), |gains| (gains.len(), gains.iter().filter(|&&gain| gain >= least).count()));
        // As if there had been one more that is half enough.
        (enough as f64 + 0.5) / (all as f64 + 1.0)
    }
}

/// What a candidate must gain to be accepted, by the random number that decides on it; never more than nothing.
pub(super) fn least_gain(temperature: f64, drawn: f64) -> f64 {
    if temperature > 0.0 { temperature * libm::log(drawn) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::Gains;

    #[test]
    fn gains_of_late_say_what_is_likely() {
        let mut gains = Gains::NONE;
        assert_eq!(gains.chance(3, 1.0), 0.5);
        for gain in [-1.0, -2.0, f64::NEG_INFINITY, 5.0] {
            gains.learn(3, gain);
        }
        assert_eq!(gains.chance(3, -1.5), 2.5 / 5.0);
        for _ in 0..100 {
            gains.learn(3, 0.0);
        }
        assert!(gains.chance(3, -1e-9) > 0.98 && gains.chance(3, 1e-9) < 0.02);
        // Another chain knows nothing of it.
        assert_eq!(gains.chance(0, 0.0), 0.5);
    }
}
