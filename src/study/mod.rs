//! Studies: many runs that answer one question.
//!
//! `file` reads what somebody wrote, `plan` expands it, `folder` keeps it with its runs, `standing` and `outcome` say how far the runs are
//! and what they came to, `effects` which factor matters; `tables` and `page` write that down, `submit` makes scripts for clusters.

pub mod effects;
mod error;
pub mod file;
pub mod folder;
pub mod outcome;
mod page;
pub mod plan;
pub mod standing;
pub mod submit;
pub mod tables;

use std::path::{Path, PathBuf};

pub use error::StudyError;

use crate::results::report::ReportError;
use crate::results::report::written::Place;
use tables::Gathered;

/// What the folder of the page and the tables is called in the folder of a study.
pub const FOLDER: &str = "report";
/// The command that writes them.
const COMMAND: &str = "study";

/// A path as a shell takes it.
#[must_use]
pub fn shell_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    let is_plain = |c: char| c.is_alphanumeric() || "._-+/:,@%=~".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.into_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// Writes the page and the tables of a study into a folder, that of the study unless another is named; what was written there
/// before, and is as it was written, is replaced.
///
/// # Errors
///
/// The folder holds something else (unless `force`), or cannot be written.
pub fn write(gathered: &Gathered<'_>, out: Option<&Path>, force: bool) -> Result<PathBuf, ReportError> {
    let own = gathered.study.path().join(FOLDER);
    let shared = out.is_none();
    let out = out.unwrap_or(&own);
    let tables =
        [("runs.csv", gathered.runs()), ("cells.csv", gathered.cells()), ("effects.csv", gathered.effects())];
    Place { folder: out, command: COMMAND, tables: tables.each_ref().map(|(name, _)| *name).to_vec(), shared }
        .write(|| page::page(gathered), &tables, force)
}
