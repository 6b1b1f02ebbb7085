//! Looks more closely at designs that searches have found: at half the step, and with soft rods in place of hinges.

use grammar_lang::ir::RuleSet;

use super::DesignError;
use super::replay::{Precision, replay};
use super::saved::SavedDesign;
use crate::simulate::{SolverName, rod};

/// What a design comes to when it is simulated more closely. A value is that of the grammar's objective, over all of its worlds.
#[derive(Clone, Debug)]
pub struct Closely {
    /// At half the step, with finer contacts.
    pub half_step: Result<f64, String>,
    /// With soft rods in place of rows that bend; none where nothing bends, or the design was found with rods.
    pub rods: Option<Result<f64, String>>,
}

/// Simulates a saved design more closely.
///
/// # Errors
///
/// [`DesignError`] where the design does not fit the rules.
pub fn closely(rules: &RuleSet, design: &SavedDesign) -> Result<Closely, DesignError> {
    let finer = replay(rules, design, &design.solver, Precision::Finer)?;
    let is_other = design.solver != SolverName::Rod.text();
    let bends = rod::bends(&finer.candidate.body.assembly);
    let rods =
        (is_other && bends).then(|| match replay(rules, design, SolverName::Rod.text(), Precision::Model) {
            Ok(replayed) => replayed.value.ok_or_else(|| replayed.why_invalid()),
            Err(why) => Err(why.to_string()),
        });
    Ok(Closely { half_step: finer.value.ok_or_else(|| finer.why_invalid()), rods })
}

impl Closely {
    /// The value that counts for a rank: with rods, where there is one, and otherwise at half the step.
    #[must_use]
    pub fn counts(&self) -> Option<f64> {
        self.rods.as_ref().unwrap_or(&self.half_step).as_ref().ok().copied()
    }
}
