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

/// Writes the page and the tables of a study into a folder; what was written there before is replaced.
///
/// # Errors
///
/// The folder holds something else (unless `force`), or cannot be written.
pub fn write(gathered: &Gathered<'_>, out: &Path, force: bool) -> Result<PathBuf, ReportError> {
    let tables =
        [("runs.csv", gathered.runs()), ("cells.csv", gathered.cells()), ("effects.csv", gathered.effects())];
    Place { folder: out, command: "study", tables: tables.each_ref().map(|(name, _)| *name).to_vec() }.write(
        &page::page(gathered),
        &tables,
        force,
    )
}
