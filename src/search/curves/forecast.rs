//! Which moves of an annealing chain are worth trying before it is known whether they come to pass.
//!
//! Whether a move is accepted is known only after its simulation, but what the next move
//! would be in either case is known at once: it starts from the candidate or from where the
//! chain stood. Of this tree of futures the likeliest are simulated side by side (Brockwell,
//! Journal of Computational and Graphical Statistics 15, 2006, "prefetching"). Then the chain
//! walks through them as far as they reach. Nothing here changes what is found, only how soon.

use super::super::evaluator::Evaluator;
use super::super::gains::Gains;

/// What each lane after the first adds to the time of a simulation with one, for each hinge of the body and at
/// most: the larger it is, the more differently the runs touch the ground and themselves.
const LANE: (f64, f64) = (0.01, 0.5);
/// So many guesses at most for each simulation: a row of moves that are known may be as long as its iteration.
const GUESSES: usize = 8;

/// What is worth trying at once.
#[derive(Clone, Debug)]
pub(super) struct Forecast {
    /// How many threads there are now.
    pub(super) threads: usize,
    lanes: usize,
    /// What each lane after the first adds to the time of a simulation with one.
    lane: f64,
    /// What the moves of each chain gained of late.
    pub(super) gains: Gains,
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
    /// Whether it takes no simulation of its own.
    is_free: bool,
}

/// What is thought of a move before it is simulated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outlook {
    /// How likely it is to be accepted.
    pub(super) acceptance: f64,
    /// Whether its value is known, or comes with that of a guess before it.
    pub(super) is_free: bool,
}

impl Forecast {
    pub(super) fn new(evaluator: &Evaluator<'_>, most: Option<usize>) -> Self {
        let (threads, lanes) = evaluator.room();
        let lanes = lanes.min(most.unwrap_or(lanes)).max(1);
        let lane = (LANE.0 * evaluator.hinges() as f64).min(LANE.1);
        Self { threads, lanes, lane, gains: Gains::NONE }
    }

    /// How many simulations each of several chains can have at once.
    pub(super) fn room(&self, chains: usize) -> usize {
        (self.threads * self.lanes / chains).max(1)
    }

    /// The likeliest futures of one of several chains, the likeliest first, as many as there is room for.
    /// The first is the next move; each stands after the one it starts from. What is thought of a move is asked
    /// by its depth and the guess it starts from, once for each guess, in their order; none if it cannot be made.
    pub(super) fn likeliest<E>(
        &self,
        chains: usize,
        mut outlook: impl FnMut(usize, Option<usize>) -> Result<Option<Outlook>, E>,
    ) -> Result<Vec<Guess>, E> {
        let mut guesses: Vec<Guess> = Vec::new();
        let mut taken = 0;
        // How likely it is, the guess before it and whether that is accepted, and what it starts from.
        let mut open = vec![(1.0, None, None)];
        let room = self.room(chains);
        while taken < room && guesses.len() < GUESSES * room {
            let likelier = |(a, x): &(usize, &(f64, _, _)), (b, y): &(usize, &(f64, _, _))| {
                x.0.total_cmp(&y.0).then(b.cmp(a))
            };
            let Some((place, _)) = open.iter().enumerate().max_by(likelier) else { break };
            let (chance, before, from): (f64, Option<(usize, bool)>, Option<usize>) = open.remove(place);
            let depth = before.map_or(0, |(before, _)| guesses[before].depth + 1);
            let Some(Outlook { acceptance, is_free }) = outlook(depth, from)? else { continue };
            let own = guesses.len();
            match before {
                Some((before, true)) => guesses[before].accepted = Some(own),
                Some((before, false)) => guesses[before].refused = Some(own),
                None => {}
            }
            let next = [(chance * acceptance, true, Some(own)), (chance * (1.0 - acceptance), false, from)];
            open.extend(
                next.map(|(chance, accepted, from)| (chance, Some((own, accepted)), from))
                    .into_iter()
                    .filter(|(chance, ..)| *chance > 0.0),
            );
            guesses.push(Guess { depth, from, accepted: None, refused: None, chance, is_free });
            taken += usize::from(!is_free);
        }
        Ok(guesses)
    }

    /// Cuts the futures of chains that go on side by side down to those that promise the most for the time.
    pub(super) fn cut(&self, chains: &mut [Vec<Guess>]) {
        let (mut best, mut most) = (1, 0.0);
        let mut lanes = 1;
        while lanes <= self.lanes {
            let room = (self.threads * lanes / chains.len()).max(1);
            let used = |guesses: &Vec<Guess>| -> f64 {
                guesses.iter().filter(|guess| !guess.is_free).take(room).map(|guess| guess.chance).sum()
            };
            let gain = chains.iter().map(used).sum::<f64>() / (1.0 + self.lane * (lanes - 1) as f64);
            if gain > most {
                (best, most) = (room, gain);
            }
            lanes = if lanes == 1 { 4 } else { 2 * lanes };
        }
        for guesses in chains {
            let places = guesses.iter().enumerate().filter(|(_, guess)| !guess.is_free);
            let end = places.map(|(place, _)| place).nth(best).unwrap_or(guesses.len());
            guesses.truncate(end);
            for guess in guesses {
                guess.accepted = guess.accepted.filter(|&next| next < end);
                guess.refused = guess.refused.filter(|&next| next < end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::{Forecast, Gains, Guess, Outlook};

    const FORECAST: Forecast = Forecast { threads: 2, lanes: 16, lane: 0.2, gains: Gains::NONE };

    /// The futures of one of several chains that all accept so often.
    fn futures(acceptance: f64, chains: usize) -> Vec<Guess> {
        let outlook =
            |depth, _| Ok::<_, Infallible>((depth < 100).then_some(Outlook { acceptance, is_free: false }));
        let Ok(guesses) = FORECAST.likeliest(chains, outlook);
        guesses
    }

    fn cut(acceptance: f64, chains: usize) -> usize {
        let mut all = vec![futures(acceptance, chains); chains];
        FORECAST.cut(&mut all);
        all[0].len()
    }

    #[test]
    fn the_surer_the_future_the_more_of_it_is_tried() {
        assert_eq!(cut(0.0, 1), 32);
        assert_eq!(cut(1.0, 1), 32);
        assert!(cut(0.5, 1) < 32);
        // And the more lanes cost, the less.
        let mut dear = vec![futures(0.5, 1)];
        Forecast { lane: 0.5, ..FORECAST }.cut(&mut dear);
        assert!(dear[0].len() < cut(0.5, 1), "{}", dear[0].len());
        // Many chains fill the lanes with moves that surely come to pass.
        assert_eq!(cut(0.5, 32), 1);
        assert_eq!(cut(0.5, 100), 1);
    }

    #[test]
    fn futures_hang_together() {
        let guesses = futures(0.4, 1);
        for (place, guess) in guesses.iter().enumerate() {
            assert!(guess.from.is_none_or(|from| from < place));
            for (next, from) in [(guess.accepted, Some(place)), (guess.refused, guess.from)] {
                let Some(next) = next.map(|next| &guesses[next]) else { continue };
                assert_eq!((next.depth, next.from), (guess.depth + 1, from));
            }
        }
        // All always refused: one row from where the chain stands.
        assert!(futures(0.0, 1).iter().enumerate().all(|(n, g)| g.depth == n && g.from.is_none()));
    }

    #[test]
    fn what_is_known_takes_no_room() {
        // Every second move is known, and refused.
        let outlook =
            |depth, _| Ok::<_, Infallible>(Some(Outlook { acceptance: 0.0, is_free: depth % 2 == 0 }));
        let Ok(guesses) = FORECAST.likeliest(1, outlook);
        assert_eq!(guesses.iter().filter(|guess| !guess.is_free).count(), 32);
        assert_eq!(guesses.len(), 64);
        // A row that ends ends.
        let outlook =
            |depth, _| Ok::<_, Infallible>((depth < 9).then_some(Outlook { acceptance: 1.0, is_free: true }));
        let Ok(guesses) = FORECAST.likeliest(1, outlook);
        assert_eq!(guesses.len(), 9);
        // One that does not end is gone on with later.
        let outlook = |_, _| Ok::<_, Infallible>(Some(Outlook { acceptance: 0.5, is_free: true }));
        let Ok(guesses) = FORECAST.likeliest(1, outlook);
        assert_eq!(guesses.len(), 32 * 8);
    }
}
