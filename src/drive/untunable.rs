//! Why a search cannot tune all that is varied of a body.

use grammar_lang::ir::CurveMethod;
use grammar_lang::source::Span;

use super::Drive;
use crate::simulate::Unfit;

/// The most values that a search varies: a checkpoint and a saved design hold them all.
const MOST_VALUES: usize = 20_000;
/// The same where `cma_es` tunes them: its covariance has a number for each pair, and each generation takes its Cholesky factor.
const MOST_BY_CMA_ES: usize = 1500;

/// Why what is varied of a body cannot be tuned.
#[derive(Clone, Debug)]
pub(super) enum Untunable<'r> {
    /// There are more values than its search can tune.
    TooMany {
        /// What has the most of them.
        name: &'r str,
        span: Span,
        /// How many there are in all, and how many may be.
        values: usize,
        most: usize,
    },
    /// A policy has two sides, and an actuator is on neither.
    OnNoSide {
        /// The policy.
        name: &'r str,
        span: Span,
        /// The kind of the actuator.
        kind: String,
    },
}

impl<'r> Drive<'r> {
    /// Why a search cannot tune all that is varied of this body, if it cannot.
    #[must_use]
    pub fn unfit(&self) -> Option<Unfit> {
        let reason = match self.untunable()? {
            Untunable::TooMany { name, values, most, .. } => format!(
                "{values} values are varied for this body, most of them for `{name}`, and its search tunes at most {most}"
            ),
            Untunable::OnNoSide { name, kind, .. } => format!(
                "the policy `{name}` has `mirrored` inputs, so that it decides for two sides of the robot, but a `{kind}` of this body has no mirror image"
            ),
        };
        Some(Unfit { reason })
    }

    /// Why a search cannot tune all that is varied of this body, if it cannot, and where that is written.
    pub(super) fn untunable(&self) -> Option<Untunable<'r>> {
        self.on_no_side().or_else(|| self.too_many_values())
    }

    /// What has the most values, if there are more for this body than its search can tune.
    fn too_many_values(&self) -> Option<Untunable<'r>> {
        let rules = self.candidate.rules;
        let curves = rules.search.curves.as_ref();
        let is_cma_es = curves.is_some_and(|curves| matches!(curves.method, CurveMethod::CmaEs(_)));
        let most = if is_cma_es { MOST_BY_CMA_ES } else { MOST_VALUES };
        if self.length <= most {
            return None;
        }
        let large = self.policies.iter().max_by_key(|policy| policy.weights.size);
        let (name, span) = match large {
            Some(policy) => (policy.name, policy.weights.span),
            None => {
                let (_, actuation) = self.actuations.first()?;
                let largest = actuation.variables.iter().max_by_key(|variable| variable.size)?;
                (largest.name.as_str(), largest.span)
            }
        };
        Some(Untunable::TooMany { name, span, values: self.length, most })
    }

    /// An actuator for which a policy of two sides decides, and which is on neither.
    fn on_no_side(&self) -> Option<Untunable<'r>> {
        for (name, policy) in
            self.candidate.rules.policies.iter().filter(|(_, policy)| policy.mirrored.is_some())
        {
            let sides = self.sides(name, policy);
            for (place, driven) in self.actuators.iter().enumerate() {
                let is_decided = self.actions_of(place, name).next().is_some();
                if is_decided && !sides.iter().any(|side| side.own.contains(&place)) {
                    let kind = self.candidate.derivation.design.parts.get(&driven.id)?.kind.clone();
                    return Some(Untunable::OnNoSide { name, span: policy.span, kind });
                }
            }
        }
        None
    }
}
