//! Learners: what tunes the network of a policy by its rewards.

use serde::{Deserialize, Serialize};

use super::Expr;

/// What every learner is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learner {
    /// How far a weight moves in a step, as Adam has it.
    pub learning_rate: f64,
    /// How much a reward counts that comes one decision later.
    pub discount: f64,
    /// How many decisions a step learns from.
    pub batch: usize,
    /// Steps for each decision that was made.
    pub updates: f64,
    /// How many decisions are remembered.
    pub replay: usize,
    /// How many motions are made before it begins to learn.
    pub warm_up: usize,
    /// How far a target network follows in each step.
    pub target_rate: f64,
    /// Whether motions that explore run in the worlds of the objective by turns, not in the nominal one alone.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub worlds: bool,
}

/// Soft actor-critic (Haarnoja and others 2018), for actions within a range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActorCritic {
    /// What every learner is told.
    pub learner: Learner,
    /// The sizes of the hidden layers of each critic.
    pub critic: Vec<usize>,
    /// The entropy that is held, of each action.
    pub entropy: f64,
}

/// Double Q-learning (van Hasselt, Guez and Silver 2016), for actions of several values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QLearning {
    /// What every learner is told.
    pub learner: Learner,
    /// How likely an action is drawn at random: an expression of the search stage.
    pub exploration: Expr,
}

impl Learner {
    /// Its fields as text.
    pub(super) fn given(&self) -> Vec<(&'static str, Option<String>)> {
        let Self { learning_rate, discount, batch, updates, replay, warm_up, target_rate, worlds } = self;
        let fields = [
            ("learning_rate", learning_rate.to_string()),
            ("discount", discount.to_string()),
            ("batch", batch.to_string()),
            ("updates", updates.to_string()),
            ("replay", replay.to_string()),
            ("warm_up", warm_up.to_string()),
            ("target_rate", target_rate.to_string()),
        ];
        let given = fields.into_iter().map(|(name, value)| (name, Some(value)));
        given.chain([("worlds", worlds.then(|| worlds.to_string()))]).collect()
    }
}
