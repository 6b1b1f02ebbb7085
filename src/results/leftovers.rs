//! What a process that was killed at the wrong moment leaves beside a run: the older run that was to
//! be replaced, and folders that were not filled to their end.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::place::{RUNS, check_place, check_series};
use super::run_files::RUN;
use super::whole::{clear_unfinished_files, entries, is_locked, replaced, unfinished};
use super::{archive, front};

/// An empty folder may be one that another process has just made and not yet locked, unless it is older.
const FILLED_WITHIN: Duration = Duration::from_secs(600);

/// The older run that this one was to replace when its process was killed: the newest, if there are several.
pub(super) fn older(path: &Path) -> Option<PathBuf> {
    let mut found = beside(path, &replaced(path), true);
    found.retain(|folder| matches!(check_place(folder, true), Ok(true)));
    found.into_iter().max_by_key(|folder| changed(folder))
}

/// Removes what is of no use once the run has a best design: unfinished folders, and older runs if it was to replace them; but
/// nothing that a process holds or in which there is anything that no run writes.
pub fn clear(path: &Path, replaces: bool) {
    if replaces {
        for folder in beside(path, &replaced(path), true) {
            remove(&folder);
        }
    }
    clear_unfinished(path);
}

/// Whether a command was to replace the run that was there.
#[must_use]
pub fn replaces(command: &str) -> bool {
    command.split_whitespace().any(|word| word == "--force")
}

/// Removes folders that were to become this one and were not filled to their end.
pub(super) fn clear_unfinished(path: &Path) {
    for folder in beside(path, &unfinished(path), false) {
        let has_begun = super::run_files::is_run(&folder) || super::place::is_series(&folder);
        let age = changed(&folder).and_then(|then| then.elapsed().ok());
        if !is_locked(&folder) && (has_begun || age.is_some_and(|age| age > FILLED_WITHIN)) {
            remove(&folder);
        }
    }
}

/// Removes the files of a run that a killed process had begun to write.
pub(super) fn clear_within(run: &Path) {
    for folder in [run.to_owned(), run.join(archive::FOLDER), run.join(front::FOLDER)] {
        clear_unfinished_files(&folder);
    }
}

/// What is left after all: for people to look at.
#[must_use]
pub fn left(path: &Path) -> Vec<PathBuf> {
    beside(path, &replaced(path), true)
}

fn changed(folder: &Path) -> Option<SystemTime> {
    fs::metadata(folder).and_then(|data| data.modified()).ok()
}

/// The folders beside a run whose names begin so, and go on with a number if they must.
fn beside(path: &Path, prefix: &str, numbered: bool) -> Vec<PathBuf> {
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_number = |rest: &str| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit());
    let mut names = entries(parent).unwrap_or_default();
    names.retain(|name| name.strip_prefix(prefix).is_some_and(|rest| !numbered || is_number(rest)));
    names.sort_unstable();
    names.iter().map(|name| parent.join(name)).filter(|folder| folder.is_dir()).collect()
}

/// Removes a folder if all in it was written by runs and no process holds it.
pub(super) fn remove(folder: &Path) {
    let is_ours = if super::place::is_series(folder) {
        check_series(folder).is_ok()
    } else {
        check_place(folder, true).is_ok()
    };
    if is_ours {
        // What cannot be removed stays, and does no harm.
        let _ = remove_run(folder);
    }
}

/// Removes the folder of a run or of several; what says that it is one goes last, so that what is left of it is still known
/// as ours if the process is killed meanwhile.
///
/// # Errors
///
/// The system's reason.
fn remove_run(folder: &Path) -> std::io::Result<()> {
    for name in entries(folder)?.into_iter().filter(|name| name != RUN && name != RUNS) {
        let path = folder.join(name);
        let is_folder = fs::symlink_metadata(&path)?.is_dir();
        if is_folder { fs::remove_dir_all(path)? } else { fs::remove_file(path)? }
    }
    fs::remove_dir_all(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_begun_within_a_run_goes_and_all_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path();
        fs::create_dir(run.join(archive::FOLDER)).unwrap();
        let ours = [".sgc-run.toml-Ab12Cd.part", "archive/.sgc-0-1.design.json-Ef34Gh.part"];
        let others = [
            "best.design.json",
            "archive/0-1.design.json",
            ".tmpnotes.txt",
            ".sgc-backup",
            ".sgc-notes.txt.part",
        ];
        ours.iter().chain(&others).for_each(|name| fs::write(run.join(name), "").unwrap());
        fs::create_dir(run.join(".sgc-Folder")).unwrap();
        clear_within(run);
        assert!(others.iter().chain(&[".sgc-Folder"]).all(|name| run.join(name).exists()));
        assert!(!ours.iter().any(|name| run.join(name).exists()));
    }
}
