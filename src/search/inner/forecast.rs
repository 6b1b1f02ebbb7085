//! Which moves of an annealing chain are worth trying before it is known whether they come to pass.
//!
//! Whether a move is accepted is known only after its simulation, but what the next move
//! would be in either case is known at once: it starts from the candidate or from where the
//! chain stood. Of this tree of futures the likeliest are simulated side by side (Brockwell,
//! Journal of Computational and Graphical Statistics 15, 2006, "prefetching"). Then the chain
//! walks through them as far as they reach. Nothing here changes what is found, only how soon.

use super::super::evaluator::Evaluator;

/// What each lane after the first adds to the time of a simulation with one.
const LANE: f64 = 0.2;
/// How much the newest move counts for the rate of acceptance.
const FRESH: f64 = 0.05;

/// The rate of acceptance of late, and what it means.
#[derive(Clone, Debug)]
pub(super) struct Forecast {
    threads: usize,
    lanes: usize,
    accepted: f64,
}

/// A move that may come to pass.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Guess {
    /// How many moves come before it.
    pub(super) depth: usize,
    /// The guess whose candidate it starts from; none is where the chain stands.
    pub(super) from: Option<usize>,
    /// The guess that follows if it is accepted.
    pub(super) accepted: Option<usize>,
    /// The guess that follows if it is not.
    pub(super) refused: Option<usize>,
    /// How likely it is to come to pass.
    chance: f64,
}

impl Forecast {
    pub(super) fn new(evaluator: &Evaluator<'_>, most: Option<usize>) -> Self {
        let (threads, lanes) = evaluator.room();
        Self { threads, lanes: lanes.min(most.unwrap_or(lanes)).max(1), accepted: 0.5 }
    }

    /// Whether one more move was accepted.
    pub(super) fn learn(&mut self, accepted: bool) {
        self.accepted += FRESH * (f64::from(u8::from(accepted)) - self.accepted);
    }

    /// The moves that promise the most for the time, at most some deep, for each of several chains that go
    /// on side by side. The first is the next move; each stands after the one it starts from.
    pub(super) fn ahead(&self, deepest: usize, chains: usize) -> Vec<Guess> {
        let mut guesses = self.likeliest((self.threads * self.lanes / chains).max(1), deepest);
        let (mut best, mut most) = (1, 0.0);
        let mut lanes = 1;
        while lanes <= self.lanes {
            let count = (self.threads * lanes / chains).clamp(1, guesses.len());
            let used: f64 = guesses[..count].iter().map(|guess| guess.chance).sum();
            let gain = used / (1.0 + LANE * (lanes - 1) as f64);
            if gain > most {
                (best, most) = (count, gain);
            }
            lanes = if lanes == 1 { 4 } else { 2 * lanes };
        }
        guesses.truncate(best);
        for guess in &mut guesses {
            guess.accepted = guess.accepted.filter(|&next| next < best);
            guess.refused = guess.refused.filter(|&next| next < best);
        }
        guesses
    }

    /// The likeliest futures, the likeliest first.
    fn likeliest(&self, count: usize, deepest: usize) -> Vec<Guess> {
        let mut guesses: Vec<Guess> = Vec::with_capacity(count);
        // The guess before and whether it is accepted, none for the first; and the guess.
        let first = Guess { depth: 0, from: None, accepted: None, refused: None, chance: 1.0 };
        let mut open = vec![(None, first)];
        while guesses.len() < count {
            let likelier = |(a, (_, x)): &(usize, &(_, Guess)), (b, (_, y)): &(usize, &(_, Guess))| {
                x.chance.total_cmp(&y.chance).then(b.cmp(a))
            };
            let Some((place, _)) = open.iter().enumerate().max_by(likelier) else { break };
            let (before, guess): (Option<(usize, bool)>, Guess) = open.remove(place);
            let own = guesses.len();
            match before {
                Some((before, true)) => guesses[before].accepted = Some(own),
                Some((before, false)) => guesses[before].refused = Some(own),
                None => {}
            }
            if guess.depth + 1 < deepest {
                let next = |accepted: bool| {
                    let chance = guess.chance * if accepted { self.accepted } else { 1.0 - self.accepted };
                    let from = if accepted { Some(own) } else { guess.from };
                    let next = Guess { depth: guess.depth + 1, from, accepted: None, refused: None, chance };
                    (Some((own, accepted)), next)
                };
                open.extend([next(true), next(false)]);
            }
            guesses.push(guess);
        }
        guesses
    }
}

#[cfg(test)]
mod tests {
    use super::Forecast;

    fn forecast(accepted: f64) -> Forecast {
        Forecast { threads: 2, lanes: 16, accepted }
    }

    #[test]
    fn the_surer_the_future_the_more_of_it_is_tried() {
        assert_eq!(forecast(0.0).ahead(100, 1).len(), 32);
        assert_eq!(forecast(1.0).ahead(100, 1).len(), 32);
        assert!(forecast(0.5).ahead(100, 1).len() < 32);
        assert!(forecast(0.3).ahead(5, 1).iter().all(|guess| guess.depth < 5));
        assert_eq!(forecast(0.5).ahead(1, 1).len(), 1);
        // Many chains fill the lanes with moves that surely come to pass.
        assert_eq!(forecast(0.5).ahead(100, 32).len(), 1);
        assert_eq!(forecast(0.5).ahead(100, 100).len(), 1);
    }

    #[test]
    fn futures_hang_together() {
        let guesses = forecast(0.4).likeliest(32, 100);
        for (place, guess) in guesses.iter().enumerate() {
            assert!(guess.from.is_none_or(|from| from < place));
            for (next, from) in [(guess.accepted, Some(place)), (guess.refused, guess.from)] {
                let Some(next) = next.map(|next| &guesses[next]) else { continue };
                assert_eq!((next.depth, next.from), (guess.depth + 1, from));
            }
        }
        // All always refused: one row from where the chain stands.
        assert!(
            forecast(0.0).ahead(100, 1).iter().enumerate().all(|(n, g)| g.depth == n && g.from.is_none())
        );
    }
}
