//! Why recorded steps cannot be made again.

use grammar_lang::eval::EvalError;
use thiserror::Error;

/// Which step of a derivation cannot be made again, and why.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("step {number} of its derivation cannot be applied: {why}")]
pub struct BadStep {
    /// Which, from 1.
    pub number: usize,
    /// Why.
    pub why: Unrepeatable,
}

/// Why a recorded step cannot be made again.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unrepeatable {
    /// It is of a rule that is not declared.
    #[error("there is no rule `{0}`")]
    NoRule(String),
    /// Its rule has another number of locals.
    #[error("the rule `{0}` matches and chooses other things")]
    OtherLocals(String),
    /// It takes a step back: such steps are not recorded.
    #[error("a rule that reverts a step is not a step itself")]
    Reversion,
    /// It chooses a kind that is not declared.
    #[error("there is no part `{0}`")]
    NoPart(String),
    /// It chooses what its rule cannot choose in any design.
    #[error("`{choice}` is {value}, which the rule `{rule}` never chooses")]
    Beyond {
        /// What is chosen.
        choice: String,
        /// The value, in SI units.
        value: f64,
        /// The rule.
        rule: String,
    },
    /// Its rule does not match there, or does not choose this in that design.
    #[error("the rule `{0}` cannot be applied like this")]
    NotDrawn(String),
    /// The rule is refused: the words of [`super::Blocked`].
    #[error("{0}")]
    Refused(String),
    /// The design that it leads to breaks a requirement.
    #[error("the design breaks `{0}`")]
    Breaks(String),
    /// An expression has no value.
    #[error("{}", .0.reason)]
    NoValue(EvalError),
}

impl From<EvalError> for Unrepeatable {
    fn from(error: EvalError) -> Self {
        Self::NoValue(error)
    }
}
