//! Why there is no report of some runs.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::results::place::RUNS;
use crate::results::run_files::{EVALS, RESULT, RUN};
use crate::results::{DesignError, FileError};

/// Why there is no report. Each is a sentence that names a folder or file.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A file of a run cannot be used, or the report cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no such folder.
    #[error("there is no folder {}", .0.display())]
    NoFolder(PathBuf),
    /// There are no runs in it.
    #[error(
        "{} holds no run: it has neither {RUN} (one run) nor {RUNS} (several); name a folder that sgc run wrote",
        .0.display()
    )]
    NoRun(PathBuf),
    /// The report would replace what a run needs.
    #[error("{} is a file of a run, and the run needs it: write the report into another folder with --out", .0.display())]
    OfRun(PathBuf),
    /// Its list of runs is empty.
    #[error("{} names no seeds", .0.display())]
    NoSeeds(PathBuf),
    /// One of several runs has lost its beginning.
    #[error("{} is damaged: it has no {RUN}", .0.display())]
    NotBegun(PathBuf),
    /// Two of its files contradict each other.
    #[error(
        "{} is damaged: {EVALS} and {RESULT} name different bests; restore it, or leave this run out of the report",
        .0.display()
    )]
    OtherBest(PathBuf),
    /// Its table of moves cannot be read.
    #[error("{} is damaged: {why}; restore it, or leave this run out of the report", path.display())]
    Moves {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        why: BadMoves,
    },
    /// A run would be compared with itself.
    #[error("{} is named twice, by itself or within its folder: name each run once", .0.display())]
    Twice(PathBuf),
    /// Their objectives have other directions or units.
    #[error(
        "{} {}, {} {}: their values cannot be compared; report them one by one",
        one.0.display(), one.1, other.0.display(), other.1
    )]
    Incomparable {
        /// A folder, and what its objective does.
        one: (PathBuf, String),
        /// Another.
        other: (PathBuf, String),
    },
    /// What is told would be written over.
    #[error("{} is a file that this report is made of: choose another folder with --out", .0.display())]
    Read(PathBuf),
    /// There is something where the report should be.
    #[error(
        "{} holds \"{name}\", which no report wrote there, or which was edited since: move it away, choose another \
         folder with --out, or write the report among it with --force",
        folder.display()
    )]
    Foreign {
        /// Where.
        folder: PathBuf,
        /// What.
        name: String,
    },
    /// The system does not let the folder be read.
    #[error("cannot write a report to {}: {why}", folder.display())]
    NoPlace {
        /// Which.
        folder: PathBuf,
        /// The system's reason.
        why: io::Error,
    },
}

/// What is wrong with a table of moves.
#[derive(Debug, Error)]
pub enum BadMoves {
    /// There is nothing in it.
    #[error("it is empty")]
    Empty,
    /// It was cut.
    #[error("its last row is not complete")]
    Cut,
    /// It lacks what every such table has.
    #[error("it has no column `{0}`")]
    NoColumn(&'static str),
    /// A row is longer or shorter than the others.
    #[error("line {line} has {found} fields, where its first line names {wanted} columns")]
    OtherLength {
        /// Which, from 1.
        line: u64,
        /// Its fields.
        found: u64,
        /// The columns.
        wanted: u64,
    },
    /// A field does not say what such a column says.
    #[error("line {line} has `{text}` in the column `{column}`")]
    Field {
        /// Which, from 1.
        line: u64,
        /// What stands there.
        text: String,
        /// The column's name.
        column: &'static str,
    },
    /// Moves and evaluations are counted upwards.
    #[error(
        "line {line} tells of move {number} after move {before}, out of their order or with fewer evaluations"
    )]
    Order {
        /// Which, from 1.
        line: u64,
        /// Its move.
        number: u64,
        /// That of the line before.
        before: u64,
    },
    /// It is no table at all.
    #[error(transparent)]
    Csv(csv::Error),
}

/// Why the best design of a run is not known: the run is reported all the same.
#[derive(Debug, Error)]
pub(crate) enum Lost {
    /// Its file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is none of its grammar.
    #[error(transparent)]
    Design(#[from] DesignError),
}
