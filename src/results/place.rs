//! Whether what is in a folder may be replaced: only what runs have written ever is.

use std::path::{Path, PathBuf};

use super::edited::{check_own_designs, check_untouched, edited};
use super::learning::LEARNING;
use super::processes::{self, PROCESSES};
use super::run_files::{BEST, CHECKPOINT, EVALS, RESULT, RUN, SOURCES, asked, is_run};
use super::seal::is_as_written;
use super::whole::{entries, is_unfinished, lock};
use super::{FileError, Unfit, archive, front, report};
use crate::reading;

pub(super) const RUNS: &str = "runs.toml";
pub(super) const SUMMARY: &str = "summary.csv";

/// Whether there are several runs in a folder.
#[must_use]
pub fn is_series(path: &Path) -> bool {
    path.join(RUNS).is_file()
}

/// Refuses to remove what is not only the folder of a run, or is under way; the run may be damaged.
///
/// # Errors
///
/// A sentence that says which of these it is.
pub fn check_run(path: &Path) -> Result<(), FileError> {
    if check_kind_of_place(path, true)? && is_run(path) {
        check_own_designs(path)?;
    }
    Ok(())
}

/// The file of a run that somebody has changed since it was written, or that is damaged, if there is one.
#[must_use]
pub fn changed(path: &Path) -> Option<PathBuf> {
    if is_run(path) { edited(path) } else { None }
}

/// Refuses to replace what is not only the folder of several runs, or is under way.
pub(super) fn check_series(path: &Path) -> Result<(), FileError> {
    drop(lock(&path.join(RUNS))?);
    for name in entries(path).map_err(FileError::read(path))? {
        if name.starts_with("seed-") {
            check_place(&path.join(name), true)?;
        } else if name != RUNS && name != SUMMARY && !is_unfinished(&name) && !report::is_own(path, &name) {
            return Err(FileError::unfit(path, Unfit::NotOnlyRuns { foreign: name }));
        }
    }
    Ok(())
}

/// Whether there is a run to be replaced; what is none, or was changed by somebody, is left alone.
pub(super) fn check_place(path: &Path, force: bool) -> Result<bool, FileError> {
    let is_there = check_kind_of_place(path, force)?;
    if is_there && is_run(path) {
        check_untouched(path)?;
        check_own_designs(path)?;
    }
    Ok(is_there)
}

/// The same; files of the run that were changed or damaged do not matter.
fn check_kind_of_place(path: &Path, force: bool) -> Result<bool, FileError> {
    if !path.exists() {
        return Ok(false);
    }
    let entries =
        if path.is_dir() { entries(path).map_err(FileError::read(path))? } else { vec![String::new()] };
    if entries.is_empty() {
        return Ok(false);
    }
    if !force {
        return Err(FileError::unfit(path, Unfit::Exists));
    }
    if let Some(file) = reading::read_within(path, &["sgr", "json"]) {
        return Err(FileError::unfit(path, Unfit::HoldsGrammar { file: file.display().to_string() }));
    }
    // Only what a run has written is ever replaced.
    if let Some(foreign) = entries.iter().find(|e| !is_own(path, e)).cloned().or_else(|| foreign_within(path))
    {
        return Err(FileError::unfit(path, Unfit::NotOnlyRun { foreign }));
    }
    if is_run(path) {
        // Not while it is under way.
        drop(lock(&path.join(RUN))?);
    }
    Ok(true)
}

/// What in the folders of a run no run has written, if there is anything: where no `run.toml` says what it froze, that is all.
fn foreign_within(path: &Path) -> Option<String> {
    let sources = asked(path).map(|asked| asked.sources).unwrap_or_default();
    let is_source = |name: &str| sources.iter().any(|source| source.file == name);
    let is_page = |folder: &str, name: &str| {
        // Pages and drawings of single designs.
        is_as_written(&path.join(folder).join(name))
    };
    let is_kept = |name: &str| {
        archive::is_kind(name) && path.join(archive::TABLE).exists() || is_page(archive::FOLDER, name)
    };
    let within = |folder: &str, is_own: &dyn Fn(&str) -> bool| {
        let names = entries(&path.join(folder)).unwrap_or_default();
        let foreign = names.into_iter().find(|name| !is_own(name) && !is_unfinished(name))?;
        Some(format!("{folder}/{foreign}"))
    };
    let is_on_front = |name: &str| {
        front::is_design(name) && path.join(front::TABLE).exists() || is_page(front::FOLDER, name)
    };
    let foreign = within(SOURCES, &is_source).or_else(|| within(archive::FOLDER, &is_kept));
    foreign.or_else(|| within(front::FOLDER, &is_on_front)).or_else(|| {
        let lacks_its_order = sources.is_empty();
        let first = entries(path).unwrap_or_default().into_iter().find(|name| !is_unfinished(name));
        first.filter(|_| lacks_its_order)
    })
}

/// Something in a folder, or in the place of one, that no run writes.
#[must_use]
pub fn foreign_in(path: &Path) -> Option<String> {
    match entries(path) {
        Ok(entries) => entries.into_iter().find(|name| !is_own(path, name)),
        Err(_) if path.exists() => Some(path.file_name().unwrap_or_default().to_string_lossy().into_owned()),
        Err(_) => None,
    }
}

/// Whether what has this name in a folder was written by a run, or of it.
fn is_own(path: &Path, name: &str) -> bool {
    let of_run = [RUN, SOURCES, EVALS, LEARNING, CHECKPOINT, BEST, RESULT, PROCESSES, processes::BEFORE];
    let kept = [archive::FOLDER, archive::TABLE, front::FOLDER, front::TABLE];
    // Pages and drawings are ours as long as nobody has edited them, whatever they are called.
    let is_page = [".html", ".svg"].iter().any(|ending| name.ends_with(ending));
    let is_drawn = is_page && is_as_written(&path.join(name));
    of_run.contains(&name)
        || kept.contains(&name)
        || is_drawn
        || is_unfinished(name)
        || report::is_own(path, name)
}
