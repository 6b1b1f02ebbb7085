//! Learners: networks that learn from rewards what a policy is to decide.
//!
//! They know nothing of bodies: an [`Episode`] is a list of what was known, done and gained. Everything is `f32`, sums have a
//! fixed order, and random numbers come from named streams, so that the same episodes give the same bits on every machine.

mod actor_critic;
mod adam;
mod layers;
mod packed;
mod products;
mod q_learning;
mod replay;
mod tanh;

pub use actor_critic::{ActorCritic, ActorCriticSettings};
pub use q_learning::QLearning;
pub use replay::{Episode, Replay};

/// What every learner is told of its networks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// How far a weight moves in a step, as Adam has it.
    pub learning_rate: f32,
    /// How much a reward counts that comes one decision later.
    pub discount: f32,
    /// How many decisions a step learns from.
    pub batch: usize,
    /// How far a target network follows in each step.
    pub target_rate: f32,
}

/// The weights of a policy stay within this of zero: they are values that a search varies.
pub const GREATEST: f32 = 8.0;

/// Does two things side by side, where there are threads for it.
fn together<A: Send, B: Send>(one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B + Send) -> (A, B) {
    // Outside of the threads of a search there is one thread.
    if rayon::current_thread_index().is_some() { rayon::join(one, other) } else { (one(), other()) }
}

#[cfg(test)]
mod tests;
