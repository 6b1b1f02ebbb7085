//! How many moves of an annealing chain are worth trying at once.
//!
//! All start from the current curves, so those after the first that is accepted
//! are in vain. Nothing here changes what is found, only how soon.

use super::evaluator::Evaluator;

/// What each lane after the first adds to the time of a simulation with one.
const LANE: f64 = 0.2;
/// How much the newest move counts for the rate of acceptance.
const FRESH: f64 = 0.05;

/// The rate of acceptance of late, and what it means.
pub(super) struct Forecast {
    threads: usize,
    lanes: usize,
    accepted: f64,
}

impl Forecast {
    pub(super) fn new(evaluator: &Evaluator<'_>) -> Self {
        let (threads, lanes) = evaluator.room();
        Self { threads, lanes, accepted: 0.5 }
    }

    /// Whether one more move was accepted.
    pub(super) fn learn(&mut self, accepted: bool) {
        self.accepted += FRESH * (f64::from(u8::from(accepted)) - self.accepted);
    }

    /// The number of moves that promises the most useful ones for the time.
    pub(super) fn ahead(&self) -> usize {
        let mut best = (self.threads, 0.0);
        let mut lanes = 1;
        while lanes <= self.lanes {
            let moves = self.threads * lanes;
            let used = self.used(moves) / (1.0 + LANE * (lanes - 1) as f64);
            if used > best.1 {
                best = (moves, used);
            }
            lanes = if lanes == 1 { 4 } else { 2 * lanes };
        }
        best.0
    }

    /// Moves up to the first that is accepted, on average.
    fn used(&self, moves: usize) -> f64 {
        let (mut used, mut reached) = (0.0, 1.0);
        for _ in 0..moves {
            used += reached;
            reached *= 1.0 - self.accepted;
        }
        used
    }
}

#[cfg(test)]
mod tests {
    use super::Forecast;

    #[test]
    fn the_rarer_acceptance_the_more_is_tried_at_once() {
        let ahead = |accepted| Forecast { threads: 2, lanes: 16, accepted }.ahead();
        assert_eq!(ahead(1.0), 2);
        assert_eq!(ahead(0.0), 32);
        assert!((2..=32).contains(&ahead(0.2)) && ahead(0.2) <= ahead(0.05));
    }
}
