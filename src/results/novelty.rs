//! How novel designs are in a set of known ones (Shah's metric a posteriori, thesis 6.3.1): of each feature
//! counts how few of the set share it.

use grammar_lang::eval::{EvalError, order};
use grammar_lang::ir::{Feature, Novelty, RuleSet, Ty};
use grammar_lang::units;
use serde::Serialize;

use super::DesignError;
use super::replay;
use super::saved::SavedDesign;

/// The score of a feature that nothing else in a large set shares.
const MOST: f64 = 10.0;

/// A design of the set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Member {
    /// What it is called.
    pub name: String,
    /// Whether the grammar says what it is.
    pub known: bool,
    /// Its features, in their order.
    pub features: Vec<Share>,
    /// The sum of what they contribute.
    pub score: f64,
}

/// What a feature contributes to a score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Its name.
    pub feature: String,
    /// What it is, in words.
    pub value: String,
    /// How many of the set share it, this one included.
    pub count: usize,
    /// What it contributes.
    pub score: f64,
}

/// Scores all designs of a set: the known ones, and others with their values by feature.
#[must_use]
pub fn scores(rules: &RuleSet, novelty: &Novelty, others: &[(String, Vec<f64>)]) -> Vec<Member> {
    let known = novelty.known.iter().map(|(name, values)| (name, values, true));
    let all: Vec<(&String, &Vec<f64>, bool)> =
        known.chain(others.iter().map(|(name, values)| (name, values, false))).collect();
    let total = all.len();
    let share = |place: usize, (name, feature): (&String, &Feature), values: &[f64]| {
        let own = values.get(place).copied().unwrap_or(0.0);
        let count = all
            .iter()
            .filter(|(_, values, _)| values.get(place).is_some_and(|x| order::is_same(*x, own)))
            .count();
        let score = feature.weight * MOST * (total - count) as f64 / total as f64;
        Share { feature: name.clone(), value: told(rules, &feature.ty, own), count, score }
    };
    let member = |(name, values, known): &(&String, &Vec<f64>, bool)| {
        let features: Vec<Share> = novelty
            .features
            .iter()
            .enumerate()
            .map(|(place, feature)| share(place, feature, values))
            .collect();
        let score = features.iter().map(|share| share.score).sum();
        Member { name: (*name).clone(), known: *known, features, score }
    };
    all.iter().map(member).collect()
}

/// A value of a feature as a grammar writes it.
fn told(rules: &RuleSet, ty: &Ty, value: f64) -> String {
    match ty {
        Ty::Enum(of) => rules.value_of(of, value).map_or_else(|| value.to_string(), str::to_owned),
        Ty::Bool => (value != 0.0).to_string(),
        ty => units::shown(value, ty.dimension().unwrap_or_default()),
    }
}

/// The features of a saved design, in their order.
///
/// # Errors
///
/// A sentence: it cannot be made or simulated again, or a feature has no value for it.
pub fn features(rules: &RuleSet, novelty: &Novelty, design: &SavedDesign) -> Result<Vec<f64>, DesignError> {
    let wanted: Vec<_> = novelty.features.values().map(|feature| &feature.value).collect();
    let values = replay::quantities(rules, design, &wanted)?;
    let values = novelty.features.keys().zip(values);
    let value = |(name, value): (&String, Result<f64, EvalError>)| {
        value.map_err(|why| DesignError::NoFeature { name: name.clone(), why })
    };
    values.map(value).collect()
}

/// The mean score of some; none of none.
#[must_use]
pub fn mean<'m>(members: impl Iterator<Item = &'m Member>) -> Option<f64> {
    let (sum, count) = members.fold((0.0, 0_u32), |(sum, n), member| (sum + member.score, n + 1));
    (count > 0).then(|| sum / f64::from(count))
}
