//! Whether somebody has changed the files of a run since they were written: such files are not removed.

use std::path::{Path, PathBuf};

use crate::reading;

use super::run_files::{BEST, CHECKPOINT, EVALS, RESULT, RUN, SOURCES, asked, finished, frozen};
use super::saved::SavedDesign;
use super::whole::entries;
use super::{FileError, Unfit, archive, checkpoint, front, genuine};

/// Refuses a run of which a file was changed since it was written, as far as checksums tell: a design, a frozen text, the table of
/// moves, the settings or the result. The other tables have none.
///
/// # Errors
///
/// A sentence that names the file.
pub(super) fn check_untouched(run: &Path) -> Result<(), FileError> {
    match edited(run) {
        Some(file) => Err(FileError::unfit(&file, Unfit::Touched)),
        None => Ok(()),
    }
}

/// The first file of a run that was changed, if there is one.
pub(super) fn edited(run: &Path) -> Option<PathBuf> {
    reading::only_looking(|| edited_file(run))
}

fn edited_file(run: &Path) -> Option<PathBuf> {
    let is_damaged = |design: &PathBuf| match SavedDesign::read_own(design) {
        // What another version wrote it can tell.
        Ok(_) | Err(FileError::Unfit { why: Unfit::OtherVersion { .. }, .. }) => false,
        Err(_) => true,
    };
    if let Some(design) = designs(run).into_iter().find(is_damaged) {
        return Some(design);
    }
    let Ok(asked) = asked(run) else { return Some(run.join(RUN)) };
    if let Err(FileError::Unfit { path, why: Unfit::OtherText }) = frozen(run, &asked) {
        // A text of another folder stays where it is.
        if path.starts_with(run.join(SOURCES)) {
            return Some(path);
        }
    }
    if !run.join(EVALS).exists() {
        return None;
    }
    let checked = match finished(run) {
        Ok(Some(finished)) => genuine::check_finished(run, &asked, &finished),
        // What is gone cannot be lost.
        Ok(None) if !run.join(CHECKPOINT).exists() => Ok(()),
        Ok(None) => checkpoint::counted_rows(run).map(drop),
        Err(_) => return Some(run.join(RESULT)),
    };
    match checked {
        Ok(()) => None,
        Err(FileError::Unfit { path, .. }) => Some(path),
        Err(_) => Some(run.join(EVALS)),
    }
}

/// Refuses a run in whose folder somebody has put a design of another run.
///
/// # Errors
///
/// A sentence that names the file.
pub(super) fn check_own_designs(run: &Path) -> Result<(), FileError> {
    let foreign = reading::only_looking(|| {
        let asked = asked(run).ok()?;
        let is_foreign = |path: &PathBuf| {
            SavedDesign::read_own(path).is_ok_and(|design| genuine::check_run(&design, &asked, None).is_err())
        };
        designs(run).into_iter().find(is_foreign)
    });
    match foreign {
        Some(file) => Err(FileError::unfit(&file, Unfit::OtherRunsDesign)),
        None => Ok(()),
    }
}

/// The designs of a run that are there.
pub(super) fn designs(run: &Path) -> Vec<PathBuf> {
    let within = |folder: &str, is_design: fn(&str) -> bool| {
        let folder = run.join(folder);
        let names = entries(&folder).unwrap_or_default().into_iter().filter(move |name| is_design(name));
        names.map(|name| folder.join(name)).collect::<Vec<_>>()
    };
    let best = run.join(BEST);
    let mut all: Vec<PathBuf> = best.is_file().then_some(best).into_iter().collect();
    all.extend(within(archive::FOLDER, archive::is_kind));
    all.extend(within(front::FOLDER, front::is_design));
    all
}
