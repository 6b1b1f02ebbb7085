//! States of valves over a cycle.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What the two valves of an actuator do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Valve {
    /// Both are closed: the actuator keeps its air.
    Closed,
    /// Air comes in.
    Inflate,
    /// Air goes out.
    Vent,
}

/// Why there is no cycle of valves.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoCycle {
    /// It takes no time.
    #[error("the period of a cycle must be above 0 s")]
    NoPeriod,
    /// Shares and states are not as many, or none.
    #[error("a cycle needs one share for each state, but has {shares} shares and {states} states")]
    OtherNumbers {
        /// How many shares there are.
        shares: usize,
        /// How many states there are.
        states: usize,
    },
}

/// The states of an actuator's valves over a cycle that repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Valves {
    /// How long the cycle lasts, s.
    pub period: f64,
    /// From when on which state holds: times in s within the period, ascending, the first at 0. Neighbours differ.
    pub changes: Vec<(f64, Valve)>,
}

impl Valves {
    /// States that take turns, each for its share of the period; at time 0 a part of the cycle, `phase`, has passed.
    /// Shares need not add up to one; below zero they count as zero, and if all are zero as equal.
    ///
    /// # Errors
    ///
    /// Why there is no such cycle.
    pub fn cycle(period: f64, shares: &[f64], states: &[Valve], phase: f64) -> Result<Self, NoCycle> {
        if period <= 0.0 {
            return Err(NoCycle::NoPeriod);
        }
        if shares.len() != states.len() || states.is_empty() {
            return Err(NoCycle::OtherNumbers { shares: shares.len(), states: states.len() });
        }
        let mut shares: Vec<f64> = shares.iter().map(|share| share.max(0.0)).collect();
        let sum: f64 = shares.iter().sum();
        if sum > 0.0 {
            shares.iter_mut().for_each(|share| *share /= sum);
        } else {
            shares.fill(1.0 / states.len() as f64);
        }
        let mut begin = 0.0;
        let mut changes: Vec<(f64, Valve)> = Vec::with_capacity(states.len() + 1);
        for (share, state) in shares.iter().zip(states) {
            if *share > 0.0 {
                let place = begin - phase;
                changes.push(((place - libm::floor(place)) * period, *state));
            }
            begin += share;
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        // What began last in the cycle goes on when it begins anew.
        if let (Some(first), Some(last)) = (changes.first().copied(), changes.last().copied())
            && first.0 > 0.0
        {
            changes.insert(0, (0.0, last.1));
        }
        changes.dedup_by(|next, before| next.1 == before.1);
        Ok(Self { period, changes })
    }
}

impl Valves {
    /// The same without states that last shorter than valves need, s: the state before them goes on.
    #[must_use]
    pub fn settled(&self, shortest: f64) -> Self {
        let mut changes = self.changes.clone();
        // Each time there is one state less in the cycle.
        while let Some(short) = self.shortest_of(&changes, shortest) {
            let mut short = short;
            if wraps(&changes) && (short == 0 || short + 1 == changes.len()) {
                // What ends the cycle and begins it is one state.
                changes.pop();
                short = 0;
            }
            changes.remove(short);
            if let (0, Some(last)) = (short, changes.last().copied()) {
                changes.insert(0, (0.0, last.1));
            }
            changes.dedup_by(|next, before| next.1 == before.1);
        }
        Self { period: self.period, changes }
    }

    /// The state that lasts shortest, if that is too short.
    fn shortest_of(&self, changes: &[(f64, Valve)], shortest: f64) -> Option<usize> {
        if changes.len() < 2 {
            return None;
        }
        let ends = |i: usize| changes.get(i + 1).map_or(self.period, |(to, _)| *to);
        let lasts = |(i, (from, _)): (usize, &(f64, Valve))| match i {
            0 if wraps(changes) => {
                (ends(0) + self.period - changes.last().map_or(self.period, |(to, _)| *to), 0)
            }
            _ => (ends(i) - from, i),
        };
        // The last piece of a state that goes on at the beginning counts there.
        let count = changes.len() - usize::from(wraps(changes));
        let all = changes.iter().enumerate().take(count).map(lasts).filter(|(time, _)| *time < shortest);
        all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
    }
}

/// Whether the state that ends the cycle goes on at its beginning.
fn wraps(changes: &[(f64, Valve)]) -> bool {
    let ends = changes.first().zip(changes.last());
    changes.len() > 1 && ends.is_some_and(|(first, last)| first.1 == last.1)
}

#[cfg(test)]
mod tests {
    use super::Valve::{Closed, Inflate, Vent};
    use super::Valves;

    #[test]
    fn states_take_turns_by_their_shares() {
        let four = Valves::cycle(4.0, &[1.0, 2.0, 0.0, 1.0], &[Closed, Inflate, Closed, Vent], 0.0).unwrap();
        assert_eq!(four.changes, [(0.0, Closed), (1.0, Inflate), (3.0, Vent)]);
    }

    #[test]
    fn a_phase_turns_the_cycle() {
        let half = Valves::cycle(4.0, &[0.25, 0.5, 0.25], &[Closed, Inflate, Vent], 0.5).unwrap();
        assert_eq!(half.changes, [(0.0, Inflate), (1.0, Vent), (2.0, Closed), (3.0, Inflate)]);
        let early = Valves::cycle(4.0, &[0.25, 0.5, 0.25], &[Closed, Inflate, Vent], 0.125).unwrap();
        assert_eq!(early.changes, [(0.0, Closed), (0.5, Inflate), (2.5, Vent), (3.5, Closed)]);
    }

    #[test]
    fn nothing_at_all_is_shared_equally() {
        let equal = Valves::cycle(3.0, &[0.0; 3], &[Closed, Inflate, Vent], 0.0).unwrap();
        assert_eq!(equal.changes, [(0.0, Closed), (1.0, Inflate), (2.0, Vent)]);
    }

    #[test]
    fn states_too_short_for_a_valve_are_left_out() {
        let valves = |changes: &[(f64, super::Valve)]| Valves { period: 2.0, changes: changes.to_vec() };
        let short = valves(&[(0.0, Closed), (0.5, Inflate), (1.5, Closed), (1.51, Vent)]);
        assert_eq!(short.settled(0.04).changes, [(0.0, Closed), (0.5, Inflate), (1.51, Vent)]);
        // The state before it goes on, and is then the same as the one after it.
        let between = valves(&[(0.0, Closed), (0.5, Inflate), (0.51, Closed), (1.0, Vent)]);
        assert_eq!(between.settled(0.04).changes, [(0.0, Closed), (1.0, Vent)]);
        // Short at the beginning of the cycle: what ended the cycle before goes on.
        let first = valves(&[(0.0, Inflate), (0.01, Closed), (1.0, Vent)]);
        assert_eq!(first.settled(0.04).changes, [(0.0, Vent), (0.01, Closed), (1.0, Vent)]);
        // Over the beginning, both pieces count together.
        let over = valves(&[(0.0, Vent), (0.03, Closed), (1.97, Vent)]);
        assert_eq!(over.settled(0.04), over);
        assert_eq!(over.settled(0.07).changes, [(0.0, Closed)]);
        let exactly = valves(&[(0.0, Vent), (0.25, Closed), (1.75, Vent)]);
        assert_eq!(exactly.settled(0.75).changes, [(0.0, Closed)]);
    }

    proptest::proptest! {
        #[test]
        fn whatever_the_cycle_no_state_stays_too_short(
            shares in proptest::collection::vec(0.0f64..1.0, 4), phase in 0.0f64..1.0, shortest in 0.001f64..0.8,
        ) {
            let settled = Valves::cycle(2.0, &shares, &[Closed, Inflate, Closed, Vent], phase).unwrap().settled(shortest);
            let changes = &settled.changes;
            proptest::prop_assert_eq!(changes[0].0, 0.0);
            proptest::prop_assert!(changes.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 != pair[1].1));
            proptest::prop_assert!(settled.shortest_of(changes, shortest).is_none());
            proptest::prop_assert_eq!(settled.settled(shortest), settled.clone());
        }
    }

    #[test]
    fn what_does_not_fit_together_is_told() {
        assert!(Valves::cycle(0.0, &[1.0], &[Closed], 0.0).unwrap_err().to_string().contains("above 0"));
        assert!(
            Valves::cycle(1.0, &[1.0], &[], 0.0).unwrap_err().to_string().contains("1 shares and 0 states")
        );
    }
}
