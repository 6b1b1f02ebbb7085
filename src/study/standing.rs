//! How far the runs of a study are.

use std::fs;

use super::folder::{Run, Study};
use crate::results::run_files::{RUN, has_result, is_run};
use crate::results::whole::is_locked;

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// It has a result.
    Complete,
    /// A process holds it.
    UnderWay,
    /// It was stopped, or its process died: it goes on from its checkpoint.
    Stopped,
    /// It ended with an error, and is left alone until `sgc study retry`.
    Failed,
    /// Nobody has begun it.
    Waiting,
}

impl Standing {
    /// All, in the order of tables.
    pub const ALL: [Self; 5] = [Self::Complete, Self::UnderWay, Self::Stopped, Self::Failed, Self::Waiting];

    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::UnderWay => "under way",
            Self::Stopped => "stopped",
            Self::Failed => "failed",
            Self::Waiting => "waiting",
        }
    }
}

/// How far one run is.
#[must_use]
pub fn standing(study: &Study, run: Run) -> Standing {
    let folder = study.folder(run);
    if has_result(&folder) {
        Standing::Complete
    } else if is_run(&folder) && is_locked(&folder.join(RUN)) {
        Standing::UnderWay
    } else if study.note_of(run).exists() {
        Standing::Failed
    } else if is_run(&folder) {
        Standing::Stopped
    } else {
        Standing::Waiting
    }
}

/// Why a run failed.
#[must_use]
pub fn reason(study: &Study, run: Run) -> Option<String> {
    fs::read_to_string(study.note_of(run)).ok().map(|text| text.trim().to_owned())
}
