//! Evaluations that came to nothing, counted by reason.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::simulate::Invalid;

/// How many evaluations came to nothing, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Evaluations without a value.
    pub invalid: BTreeMap<Invalid, u64>,
    /// Candidates that lost their value at half the step.
    pub unstable: u64,
}

impl Tally {
    /// Adds those of another.
    pub(crate) fn add(&mut self, other: &Self) {
        for (&reason, count) in &other.invalid {
            *self.invalid.entry(reason).or_default() += count;
        }
        self.unstable += other.unstable;
    }

    /// Evaluations without a value, for whatever reason.
    #[must_use]
    pub fn invalid(&self) -> u64 {
        self.invalid.values().sum()
    }

    /// Why evaluations had no value: `3 too fast, 1 not finite`; empty if all had one.
    #[must_use]
    pub fn reasons(&self) -> String {
        let reasons: Vec<_> = self.invalid.iter().map(|(r, n)| format!("{n} {}", r.describe())).collect();
        reasons.join(", ")
    }
}
