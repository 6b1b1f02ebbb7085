//! What each iteration of a learner came to: its learning curve.

use serde::{Deserialize, Serialize};

/// One iteration of a learner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learned {
    /// Evaluations that the run had spent when it ended.
    pub evaluations: u64,
    /// Motions that explored so far.
    pub motions: u64,
    /// The mean, over the motions that explored in this iteration, of the sum of their rewards; none if all of them failed.
    pub reward: Option<f64>,
    /// How likely each action was drawn evenly, whatever the policy says: 0 to 1.
    pub exploration: f64,
    /// The value of the policy without random actions in the nominal world; none if its motion failed.
    pub value: Option<f64>,
    /// The best value of the task so far.
    pub best: Option<f64>,
}
