//! Whether a saved design is what it says: the file may have been changed, or the grammar.

use grammar_lang::ir::RuleSet;

use super::replay::{Replayed, body_of, drive_of};
use super::saved::SavedDesign;

/// Checks that the derivation of a design leads, by its own grammar, to the body that was saved.
///
/// # Errors
///
/// A sentence: it does not.
pub fn check_body(rules: &RuleSet, design: &SavedDesign) -> Result<(), String> {
    let (derivation, body) = body_of(rules, design)?;
    if derivation.design.canonical_hash(rules) != design.body {
        return Err("its derivation does not lead to the body that was saved: it was changed".to_owned());
    }
    // Earlier versions wrote no names.
    let is_named = !design.own_names.is_empty();
    if is_named {
        design.own_names.check(&body.actuators)?;
    }
    for saved in &design.tasks {
        let (_, drive, _) = drive_of(rules, saved, (&derivation, &body))?;
        if !is_named {
            continue;
        }
        let labels = drive.labels(|id| design.own_names.get(id).unwrap_or_default().to_owned());
        let other = saved.drive.iter().zip(&labels).find(|((saved, _), label)| saved != *label);
        if let Some(((saved, _), label)) = other {
            return Err(format!(
                "`{saved}` in its drive is `{label}` by the names of its parts: the file was changed"
            ));
        }
    }
    Ok(())
}

/// Checks that a design says of itself what its simulation says: values, terms and what was observed, to the bit.
///
/// # Errors
///
/// A sentence that names the first difference.
pub fn check_values(design: &SavedDesign, replayed: &Replayed) -> Result<(), String> {
    let is_same = |a: f64, b: f64| a.to_bits() == b.to_bits();
    if !replayed.value.is_some_and(|value| is_same(value, design.value))
        || replayed.tasks.len() != design.tasks.len()
    {
        return Err(design.other_value());
    }
    let changed =
        |what: String| Err(format!("{what} is another one than the design comes to: the file was changed"));
    for (task, saved) in replayed.tasks.iter().zip(&design.tasks) {
        let Some(score) = &task.score else { return Err(design.other_value()) };
        if !is_same(score.value, saved.value) {
            return changed(format!("the saved value of the task `{}`", saved.name));
        }
        let names = |terms: &[(String, f64)]| terms.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        if names(&score.terms) != names(&saved.terms) {
            return changed("the list of saved terms".to_owned());
        }
        let other = score.terms.iter().zip(&saved.terms).find(|((_, now), (_, then))| !is_same(*now, *then));
        if let Some(((name, _), _)) = other {
            return changed(format!("the saved term `{name}`"));
        }
    }
    for (name, value) in &replayed.observed {
        if design.observed.get(name).is_some_and(|saved| saved != value) {
            return changed(format!("what was observed as `{name}`"));
        }
    }
    Ok(())
}
