//! Evaluates saved designs again and cross-checks them.

use std::sync::Arc;

use grammar_lang::ir::RuleSet;

use super::describe;
use super::saved::{Check, Grammar, SavedDesign};
use crate::derive::Derivation;
use crate::design::Body;
use crate::drive::Drive;
use crate::score::{Score, score};
use crate::search::{Best, keeps, settings};
use crate::simulate::{self, Invalid, Motion};

/// The names of the checks that every final best goes through.
const HALF_STEP: &str = "half the step";
const RAPIER: &str = "rapier";

/// A saved design that has been simulated again.
pub struct Replayed {
    /// The derivation that its steps lead to.
    pub derivation: Arc<Derivation>,
    /// Elements and joints.
    pub body: Body,
    /// The motion, or why there is none to score.
    pub motion: Result<Motion, Invalid>,
    /// The targets of its actuators.
    pub targets: simulate::Targets,
    /// The score of a valid motion.
    pub score: Option<Score>,
}

/// Simulates a saved design: with a solver, and at a step in s.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn replay(
    rules: &RuleSet,
    design: &SavedDesign,
    solver: &str,
    step: Option<f64>,
) -> Result<Replayed, String> {
    let derivation = Derivation::replay(rules, &design.derivation)
        .map_err(|(n, reason)| format!("step {n} of its derivation cannot be applied: {reason}"))?;
    let derivation = Arc::new(derivation);
    let body = Body::new(&derivation.design, rules);
    let drive = Drive::new(rules, Arc::clone(&derivation), &body);
    let parameters = design.parameters();
    let names: Vec<String> = design.drive.iter().map(|(name, _)| name.clone()).collect();
    if names != drive.labels() || !drive.fits(&parameters) {
        return Err("its drive does not fit the actuation of this grammar".to_owned());
    }
    let targets = drive.targets(&parameters).map_err(|e| e.reason)?;
    let mut settings = settings(rules);
    if let Some(step) = step {
        settings.step = step;
    }
    let model = simulate::model(solver).ok_or_else(|| format!("there is no solver `{solver}`"))?;
    let mut simulation = model.prepare(&body.assembly, &settings).map_err(|u| u.reason)?;
    let motion =
        simulation.run(std::slice::from_ref(&targets)).into_iter().next().unwrap_or(Err(Invalid::NotFinite));
    let score = match &motion {
        Ok(motion) => Some(score(rules, &derivation, motion).map_err(|e| e.reason)?),
        Err(_) => None,
    };
    Ok(Replayed { derivation, body, motion, targets, score })
}

/// Makes the saved form of a best design.
///
/// # Errors
///
/// A sentence; a best design has been simulated before, so there should be none.
pub fn save(
    rules: &RuleSet,
    grammar: Grammar,
    seed: u64,
    solver: &str,
    best: &Best,
) -> Result<SavedDesign, String> {
    let body = Body::new(&best.derivation.design, rules);
    let drive = Drive::new(rules, Arc::clone(&best.derivation), &body);
    let varied = drive.labels().into_iter().zip(best.parameters.iter().copied()).collect();
    let mut design = SavedDesign::new(
        grammar,
        seed,
        solver,
        best.found_at,
        (best.value, &rules.objective.unit),
        Vec::new(),
        (&best.derivation, best.derivation.design.canonical_hash(rules)),
        varied,
    );
    let replayed = replay(rules, &design, solver, None)?;
    design.terms = replayed.score.map(|s| s.terms).unwrap_or_default();
    if let Some(half) = best.half_step {
        design.checks.push(Check { name: HALF_STEP.to_owned(), value: Some(half) });
    }
    Ok(design)
}

/// Adds what a final best is checked with: half the step, where the search had
/// no need to, and the opinion of the reference solver.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn final_check(rules: &RuleSet, design: &SavedDesign) -> Result<SavedDesign, String> {
    let mut design = design.clone();
    if !design.checks.iter().any(|c| c.name == HALF_STEP) {
        let fine = replay(rules, &design, &design.solver, Some(rules.model.step / 2.0))?;
        design.checks.insert(0, Check { name: HALF_STEP.to_owned(), value: fine.score.map(|s| s.value) });
    }
    if design.solver != RAPIER {
        let other = replay(rules, &design, RAPIER, None)?;
        design.checks.retain(|c| c.name != RAPIER);
        design.checks.push(Check { name: RAPIER.to_owned(), value: other.score.map(|s| s.value) });
    }
    Ok(design)
}

/// The value, terms and checks of a design in words.
#[must_use]
pub fn report(rules: &RuleSet, design: &SavedDesign) -> String {
    let mut out = format!("value {}\n", describe::quantity(design.value, &design.unit));
    for (name, value) in &design.terms {
        out.push_str(&format!("  {name} {}\n", describe::term(rules, name, *value)));
    }
    for check in &design.checks {
        let text =
            check.value.map_or("not a valid motion".to_owned(), |v| describe::quantity(v, &design.unit));
        let kept = check.value.is_some_and(|v| keeps(rules, design.value, v));
        let doubt = if kept { "" } else { "   (less than a best should keep: see docs/physics.md)" };
        out.push_str(&format!("  with {}: {text}{doubt}\n", check.name));
    }
    out
}
