//! States of valves over a cycle.

use serde::{Deserialize, Serialize};

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
    pub fn cycle(period: f64, shares: &[f64], states: &[Valve], phase: f64) -> Result<Self, String> {
        if period <= 0.0 {
            return Err("the period of a cycle must be above 0 s".to_owned());
        }
        if shares.len() != states.len() || states.is_empty() {
            return Err(format!(
                "a cycle has a share for each state: here are {} shares and {} states",
                shares.len(),
                states.len()
            ));
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
    fn what_does_not_fit_together_is_told() {
        assert!(Valves::cycle(0.0, &[1.0], &[Closed], 0.0).unwrap_err().contains("above 0"));
        assert!(Valves::cycle(1.0, &[1.0], &[], 0.0).unwrap_err().contains("1 shares and 0 states"));
    }
}
