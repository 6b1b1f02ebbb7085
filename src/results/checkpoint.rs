//! The file from which a run goes on.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::evals::Mark;
use super::run_files::{CHECKPOINT, EVALS, RUN};
use super::saved::hex;
use super::whole::read;
use super::{Damage, FileError, Unfit};
use crate::derive::Steps;
use crate::reading;
use crate::search::State;

const FORMAT: &str = "sgc checkpoint";
const VERSION: u32 = 1;

/// All that a run needs to go on, beside what it was asked and its sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    format: String,
    version: u32,
    /// The version of sgc that wrote it.
    sgc: String,
    /// Hash of `run.toml`.
    run: String,
    /// The bound on evaluations: a resumed run may have been given another one.
    pub(super) max_evals: Option<u64>,
    /// The rows of `evals.csv` that belong to it.
    pub(super) evals: Mark,
    /// Hash of the file with nothing here.
    sum: String,
    /// Where the search stands.
    pub(super) state: State<Steps>,
}

impl Checkpoint {
    /// # Errors
    ///
    /// A sentence: the state cannot be written down.
    pub(super) fn new(
        run: &str,
        max_evals: Option<u64>,
        evals: Mark,
        state: &State,
    ) -> Result<Self, serde_json::Error> {
        let mut checkpoint = Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            sgc: env!("CARGO_PKG_VERSION").to_owned(),
            run: run.to_owned(),
            max_evals,
            evals,
            sum: String::new(),
            state: state.kept(),
        };
        checkpoint.sum = hash(&checkpoint.text()?);
        Ok(checkpoint)
    }

    /// The text of the file.
    ///
    /// # Errors
    ///
    /// A sentence: the state cannot be written down.
    pub(super) fn text(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self).map(|text| text + "\n")
    }

    /// Reads the checkpoint of the run that `run.toml` of this hash began.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong with it.
    pub(super) fn read(path: &Path, run: &str) -> Result<Self, FileError> {
        let bytes = reading::own(path).map_err(FileError::read(path))?;
        let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(FileError::damaged(path))?;
        let field = |name: &str| value.get(name).and_then(serde_json::Value::as_str).unwrap_or("");
        if field("format") != FORMAT {
            return Err(FileError::unfit(path, Unfit::NotCheckpoint));
        }
        let version = value.get("version").and_then(serde_json::Value::as_u64);
        if version != Some(u64::from(VERSION)) && field("sgc") == env!("CARGO_PKG_VERSION") {
            return Err(FileError::unfit(path, Unfit::OtherFormat { wanted: VERSION }));
        }
        if version != Some(u64::from(VERSION)) || field("sgc") != env!("CARGO_PKG_VERSION") {
            return Err(FileError::unfit(path, Unfit::OtherProgram { theirs: field("sgc").to_owned() }));
        }
        let mut checkpoint: Self = serde_json::from_value(value).map_err(FileError::damaged(path))?;
        let sum = std::mem::take(&mut checkpoint.sum);
        if hash(&checkpoint.text().map_err(FileError::damaged(path))?) != sum {
            return Err(FileError::damaged(path)(Damage::Sum));
        }
        if checkpoint.run != run {
            return Err(FileError::unfit(&path.with_file_name("run.toml"), Unfit::OtherOrder));
        }
        checkpoint.sum = sum;
        Ok(checkpoint)
    }
}

fn hash(text: &str) -> String {
    hex(&Sha256::digest(text))
}

/// How many rows of moves the checkpoint of a stopped run counts; none where there is no checkpoint that this program can read.
///
/// # Errors
///
/// A sentence: the rows that it counts were changed.
pub(super) fn counted_rows(path: &Path) -> Result<Option<usize>, FileError> {
    let run = hex(&Sha256::digest(read(&path.join(RUN))?));
    match Checkpoint::read(&path.join(CHECKPOINT), &run) {
        // Its first line names the columns.
        Ok(checkpoint) => Ok(Some(checkpoint.evals.rows(&path.join(EVALS))?.saturating_sub(1))),
        Err(_) => Ok(None),
    }
}
