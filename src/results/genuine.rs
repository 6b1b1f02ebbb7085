//! Whether a saved design is what it says: the file may have been changed, or the grammar.

use std::path::Path;

use grammar_lang::ir::RuleSet;

use super::evals::Mark;
use super::replay::{Replayed, candidate, drive_of};
use super::run_files::{self, Asked, EVALS, Finished, RESULT, RUN};
use super::saved::{SavedDesign, SavedTask};
use super::{DesignError, FileError, Unfit, saving};
use crate::{reading, score};

/// Checks that the derivation of a design leads, by its own grammar, to the body that was saved.
///
/// # Errors
///
/// A sentence: it does not.
pub fn check_body(rules: &RuleSet, design: &SavedDesign) -> Result<(), DesignError> {
    let candidate = candidate(rules, design)?;
    if !candidate.design().is_body(&design.body) {
        return Err(design.differs(DesignError::OtherBody));
    }
    // Earlier versions wrote no names.
    let is_named = !design.own_names.is_empty();
    if is_named {
        design.own_names.check(&candidate.body.actuators)?;
    }
    for saved in &design.tasks {
        let (drive, _) = drive_of(&candidate, saved)?;
        if !is_named {
            continue;
        }
        let labels = drive.labels(|id| design.own_names.get(id).unwrap_or_default().to_owned());
        let other = saved.drive.iter().zip(&labels).find(|((saved, _), label)| saved != *label);
        if let Some(((saved, _), label)) = other {
            return Err(DesignError::OtherLabel { saved: saved.clone(), label: label.clone() });
        }
    }
    Ok(())
}

/// Checks that a design says of itself what its simulation says: values, terms and what was observed, to the bit.
///
/// # Errors
///
/// A sentence that names the first difference.
pub fn check_values(
    rules: &RuleSet,
    design: &SavedDesign,
    replayed: &Replayed<'_>,
) -> Result<(), DesignError> {
    let is_same = |a: f64, b: f64| a.to_bits() == b.to_bits();
    if !replayed.value.is_some_and(|value| is_same(value, design.value))
        || replayed.tasks.len() != design.tasks.len()
    {
        return Err(design.differs(DesignError::OtherValue));
    }
    let changed = |what: String| Err(design.differs(DesignError::Other { what }));
    let unit_of = |saved: &SavedTask| rules.tasks.get(&saved.name).map(|task| &task.objective.unit);
    if design.unit != rules.objective.unit || design.tasks.iter().any(|t| unit_of(t) != Some(&t.unit)) {
        return changed("the saved unit".to_owned());
    }
    let beside = saving::beside(rules, &replayed.beside);
    if design.beside.len() != beside.len() || !design.beside.iter().zip(&beside).all(|(a, b)| a.is_same(b)) {
        return changed("its value in another objective".to_owned());
    }
    if design.penalties != score::penalties(rules, &replayed.candidate.derivation)? {
        return changed("the list of preferences that are not fulfilled".to_owned());
    }
    for (task, saved) in replayed.tasks.iter().zip(&design.tasks) {
        let Some(score) = &task.score else { return Err(design.differs(DesignError::OtherValue)) };
        if !is_same(score.value, saved.value) {
            return changed(format!("the saved value of the task `{}`", saved.name));
        }
        if task.nominal.map(f64::to_bits) != saved.nominal.map(f64::to_bits) {
            return changed(format!("the saved value of the task `{}` in the nominal world", saved.name));
        }
        // Versions before this one did not say it.
        if let Some(said) = saved.at_rest {
            let (drive, parameters) = drive_of(&replayed.candidate, saved)?;
            if saving::at_rest(&drive, &parameters).map(f64::to_bits) != Some(said.to_bits()) {
                return changed(format!("the value of the task `{}` where nothing moves", saved.name));
            }
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
    if let Some(of_all) = &design.of_all {
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        if bits(&of_all.at_rest) != bits(&saving::all_at_rest(&replayed.candidate, design)?) {
            return changed("the list of its objective values where nothing moves".to_owned());
        }
    }
    for (name, value) in &replayed.observed {
        if design.observed.get(name).is_some_and(|saved| saved != value) {
            return changed(format!("the observed value `{name}`"));
        }
    }
    Ok(())
}

/// Checks that a design is that of a run, as far as the two tell.
///
/// # Errors
///
/// A sentence: it is not.
pub(super) fn check_run(
    design: &SavedDesign,
    asked: &Asked,
    finished: Option<&Finished>,
) -> Result<(), DesignError> {
    if design.seed != asked.seed || design.grammar.rules != asked.rules {
        return Err(DesignError::OtherRun { grammar: design.grammar.name.clone(), seed: design.seed });
    }
    if finished.is_some_and(|finished| finished.value != Some(design.value)) {
        return Err(DesignError::OtherResult { file: RESULT });
    }
    Ok(())
}

/// Checks that the best design of a folder is that of its run, as far as the two tell.
///
/// # Errors
///
/// A sentence: it is not, or what the run was asked cannot be read.
pub fn check_best(folder: &Path, design: &SavedDesign) -> Result<(), FileError> {
    let (finished, asked) = reading::only_looking(|| (run_files::finished(folder), run_files::asked(folder)));
    check_run(design, &asked?, finished?.as_ref()).map_err(FileError::inside(&run_files::best(folder)))
}

/// Checks that a run among several is of the seed that its folder is named by.
///
/// # Errors
///
/// A sentence: it is not.
pub(super) fn check_seed(folder: &Path, asked: &Asked, seed: u64) -> Result<(), FileError> {
    match asked.seed == seed {
        true => Ok(()),
        false => Err(FileError::unfit(folder, Unfit::OtherSeed { seed: asked.seed })),
    }
}

/// Checks that the result of a complete run fits to what it was asked, and to its table of moves.
///
/// # Errors
///
/// A sentence: one of these files was changed.
pub fn check_finished(folder: &Path, asked: &Asked, finished: &Finished) -> Result<(), FileError> {
    check_result(folder, asked, finished)?;
    let table = folder.join(EVALS);
    let is_own = |mark: &Mark| Ok(mark.is_of(&reading::own(&table).map_err(FileError::read(&table))?));
    match finished.evals.as_ref().map(is_own).transpose()? {
        Some(false) => Err(FileError::unfit(&table, Unfit::OtherTable)),
        Some(true) | None => Ok(()),
    }
}

/// Checks that the result of a complete run fits to what it was asked.
///
/// # Errors
///
/// A sentence: one of these files was changed.
pub fn check_result(folder: &Path, asked: &Asked, finished: &Finished) -> Result<(), FileError> {
    if (finished.seed, &finished.grammar) != (asked.seed, &asked.grammar) {
        let Finished { grammar, seed, .. } = finished.clone();
        return Err(FileError::unfit(&folder.join(RESULT), Unfit::OtherAsked { grammar, seed }));
    }
    if finished.asked.as_ref().is_some_and(|own| *own != asked.identity()) {
        return Err(FileError::unfit(&folder.join(RUN), Unfit::OtherRun));
    }
    Ok(())
}

/// Checks that runs of one folder are of one grammar: what they come to is told together.
///
/// # Errors
///
/// A sentence that names one that is not.
pub(super) fn check_one_grammar<'a>(
    mut runs: impl Iterator<Item = (&'a Path, &'a Asked)>,
) -> Result<(), FileError> {
    let Some((first, known)) = runs.next() else { return Ok(()) };
    match runs.find(|(_, asked)| asked.rules != known.rules) {
        Some((path, asked)) => {
            let (grammar, first) = (asked.grammar.clone(), first.to_owned());
            Err(FileError::unfit(path, Unfit::OtherRules { grammar, first }))
        }
        None => Ok(()),
    }
}
