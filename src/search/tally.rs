//! Failed evaluations, counted by reason.

use std::collections::BTreeMap;

use grammar_lang::eval::EvalError;
use serde::{Deserialize, Serialize};

use crate::simulate::Invalid;

/// What an evaluation without a value is called that an expression is to blame for.
const NO_VALUE: &str = "undefined";

/// What an evaluation is called whose body the solver cannot simulate.
const UNFIT: &str = "of bodies that the solver cannot simulate";

/// What an evaluation is called that has no value in another world.
const ELSEWHERE: &str = "without a value in another world";

/// What the end of a learner is called whose rewards or steps are too large.
const DIVERGED: &str = "of a learner that diverged (make `learning_rate` or its rewards smaller)";

/// What an evaluation is called whose value hinges gave it.
const WITH_RODS: &str = "that lose their value with soft rods in place of hinges";

/// Why an evaluation has no value.
#[derive(Clone, Debug)]
pub(crate) enum Missing {
    /// The motion may not be scored.
    Motion(Invalid),
    /// The motion in another world, by its name, may not be scored.
    Elsewhere(String, Invalid),
    /// An expression has no value for it.
    Expression(EvalError),
    /// The solver cannot simulate the body, for this reason.
    Unfit(String),
    /// It loses its value where rows that bend are simulated as elastic rods.
    WithRods,
    /// What a learner learned is no numbers any more.
    Diverged,
}

/// How many evaluations failed, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Evaluations whose motion may not be scored.
    pub invalid: BTreeMap<Invalid, u64>,
    /// Evaluations whose motion in another world may not be scored, by the world and the reason.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub elsewhere: BTreeMap<String, u64>,
    /// Evaluations for which an expression has no value, by the expression.
    #[serde(with = "pairs")]
    pub no_value: BTreeMap<EvalError, u64>,
    /// Moves that were refused because an expression has no value, by the expression.
    #[serde(with = "pairs")]
    pub refused: BTreeMap<EvalError, u64>,
    /// Evaluations of bodies that the solver cannot simulate, and why it cannot simulate the first of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unfit: Option<(u64, String)>,
    /// Candidates that lost their value at half the step.
    pub unstable: u64,
    /// What the first of them was worth, and what it was worth at half the step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_unstable: Option<String>,
    /// Candidates that lost their value with rods in place of hinges.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub with_rods: u64,
    /// Evaluations that could not come to a value that would be accepted, as was known before their end.
    #[serde(default)]
    pub hopeless: u64,
    /// Learners whose weights were no numbers any more.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub diverged: u64,
}

impl Tally {
    /// Counts an evaluation without a value.
    pub(crate) fn count(&mut self, why: Missing) {
        match why {
            Missing::Motion(invalid) => *self.invalid.entry(invalid).or_default() += 1,
            Missing::Elsewhere(world, why) => {
                *self.elsewhere.entry(format!("`{world}`: {}", why.describe())).or_default() += 1;
            }
            Missing::Expression(error) => *self.no_value.entry(error).or_default() += 1,
            Missing::Unfit(reason) => self.count_unfit(1, &reason),
            Missing::WithRods => self.with_rods += 1,
            Missing::Diverged => self.diverged += 1,
        }
    }

    fn count_unfit(&mut self, more: u64, reason: &str) {
        self.unfit.get_or_insert_with(|| (0, reason.to_owned())).0 += more;
    }

    /// Adds those of another.
    pub(crate) fn add(&mut self, other: &Self) {
        add_all(&mut self.invalid, &other.invalid);
        add_all(&mut self.elsewhere, &other.elsewhere);
        add_all(&mut self.no_value, &other.no_value);
        add_all(&mut self.refused, &other.refused);
        if let Some((more, reason)) = &other.unfit {
            self.count_unfit(*more, reason);
        }
        self.unstable += other.unstable;
        if self.first_unstable.is_none() {
            self.first_unstable.clone_from(&other.first_unstable);
        }
        self.with_rods += other.with_rods;
        self.hopeless += other.hopeless;
        self.diverged += other.diverged;
    }

    /// Evaluations without a value, for whatever reason.
    #[must_use]
    pub fn invalid(&self) -> u64 {
        self.by_reason().map(|(_, n)| n).sum()
    }

    /// Evaluations without a value, by reason.
    pub fn by_reason(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let expressions = Some(self.no_value.values().sum()).filter(|n| *n > 0);
        let elsewhere = Some(self.elsewhere.values().sum()).filter(|n| *n > 0);
        let motions = self.invalid.iter().map(|(reason, n)| (reason.describe(), *n));
        let unfit = self.unfit.as_ref().map(|(n, _)| (UNFIT, *n));
        let with_rods = Some(self.with_rods).filter(|n| *n > 0);
        let diverged = Some(self.diverged).filter(|n| *n > 0);
        motions
            .chain(elsewhere.map(|n| (ELSEWHERE, n)))
            .chain(expressions.map(|n| (NO_VALUE, n)))
            .chain(unfit)
            .chain(with_rods.map(|n| (WITH_RODS, n)))
            .chain(diverged.map(|n| (DIVERGED, n)))
    }

    /// Why evaluations had no value: `3 too fast, 1 not finite`; empty if all had one.
    #[must_use]
    pub fn reasons(&self) -> String {
        let reasons: Vec<_> = self.by_reason().map(|(reason, n)| format!("{n} {reason}")).collect();
        reasons.join(", ")
    }

    /// The same with the other worlds, and why they had none.
    #[must_use]
    pub fn reasons_in_worlds(&self) -> String {
        let worlds = self.worlds().join("; ");
        let in_worlds = if worlds.is_empty() { String::new() } else { format!(" ({worlds})") };
        let of = |reason: &str| if reason == ELSEWHERE { in_worlds.as_str() } else { "" };
        let reasons: Vec<_> =
            self.by_reason().map(|(reason, n)| format!("{n} {reason}{}", of(reason))).collect();
        reasons.join(", ")
    }

    /// The other worlds without a value, and why: `` 1 in `wet`: too fast ``.
    #[must_use]
    pub fn worlds(&self) -> Vec<String> {
        self.elsewhere.iter().map(|(world, n)| format!("{n} in {world}")).collect()
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // What serde asks for.
fn is_zero(count: &u64) -> bool {
    *count == 0
}

fn add_all<K: Ord + Clone>(to: &mut BTreeMap<K, u64>, from: &BTreeMap<K, u64>) {
    for (key, count) in from {
        *to.entry(key.clone()).or_default() += count;
    }
}

/// A map in a file whose keys are no texts: a list of pairs.
mod pairs {
    use std::collections::BTreeMap;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<K: Serialize, S: Serializer>(
        map: &BTreeMap<K, u64>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(map)
    }

    pub(super) fn deserialize<'de, K: Deserialize<'de> + Ord, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<BTreeMap<K, u64>, D::Error> {
        Ok(Vec::deserialize(deserializer)?.into_iter().collect())
    }
}
