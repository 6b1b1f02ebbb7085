//! What a grammar makes and what it excludes, found by deriving designs without
//! simulating any.
//!
//! Random walks tell how often rules apply and what stops them; the first depths
//! are enumerated; a body that is asked for is searched for.

mod depths;
mod reach;
mod sizes;
mod text;
mod walks;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::RuleSet;
use serde::Serialize;

pub use depths::{Counted, Depth};
pub use reach::{Answer, Made, can_make};
pub use sizes::Sizes;
pub use text::{answer, report};
pub use walks::{Requirements, Rules, Stopped};

use crate::derive::Derivation;

/// How much is tried.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The seed of the random numbers.
    pub seed: u64,
    /// How many random walks are made.
    pub walks: usize,
    /// How many moves a walk has.
    pub steps: usize,
    /// The temperature that weights and choices read.
    pub temperature: f64,
    /// How many applications of rules are tried to enumerate designs, and to find one that is asked for.
    pub budget: usize,
}

/// What an audit found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// The grammar.
    pub grammar: String,
    /// The seed of the random numbers.
    pub seed: u64,
    /// How many random walks were made.
    pub walks: usize,
    /// How many moves a walk had.
    pub steps: usize,
    /// The temperature that weights and choices read.
    pub temperature: f64,
    /// How often each rule was drawn, applied and stopped.
    pub rules: Vec<Rules>,
    /// How often each requirement stopped a rule.
    pub requirements: Vec<Requirements>,
    /// How often each preference was fulfilled, of how many designs.
    pub preferences: Vec<(String, usize, usize)>,
    /// Numbers of parts at the ends of the walks.
    pub parts: Sizes,
    /// Numbers of actuators at the ends of the walks.
    pub actuators: Sizes,
    /// How many different designs there are at each depth.
    pub depths: Vec<Depth>,
    /// Expressions of rules that had no value, and how often that stopped one.
    #[serde(skip)]
    pub failing: Vec<(EvalError, usize)>,
}

/// Told how far an audit is.
pub trait Observer {
    /// So many of so many are done.
    fn progress(&mut self, what: &str, done: usize, of: usize);
}

/// Audits a grammar.
///
/// # Errors
///
/// [`EvalError`] when an expression of a rule or requirement has no value.
pub fn audit(
    rules: &RuleSet,
    start: &Derivation,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Audit, EvalError> {
    let walked = walks::walk(rules, start, settings, observer)?;
    let depths = depths::depths(rules, start, settings, &walked.seen, observer);
    Ok(Audit {
        grammar: rules.name.clone(),
        seed: settings.seed,
        walks: settings.walks,
        steps: settings.steps,
        temperature: settings.temperature,
        rules: walked.rules,
        requirements: walked.requirements,
        preferences: walked.preferences,
        parts: Sizes::of(&walked.parts),
        actuators: Sizes::of(&walked.actuators),
        depths,
        failing: walked.failing,
    })
}
