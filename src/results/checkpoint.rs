//! The file from which a run goes on.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::evals::Mark;
use super::saved::hex;
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
    pub(super) fn new(run: &str, max_evals: Option<u64>, evals: Mark, state: &State) -> Result<Self, String> {
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
    pub(super) fn text(&self) -> Result<String, String> {
        serde_json::to_string(self).map(|text| text + "\n").map_err(|e| format!("no checkpoint: {e}"))
    }

    /// Reads the checkpoint of the run that `run.toml` of this hash began.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong with it.
    pub(super) fn read(path: &Path, run: &str) -> Result<Self, String> {
        let damaged = |why: &dyn std::fmt::Display| format!("{} is damaged: {why}", path.display());
        let bytes = reading::own(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(|e| damaged(&e))?;
        let field = |name: &str| value.get(name).and_then(serde_json::Value::as_str).unwrap_or("");
        if field("format") != FORMAT {
            return Err(format!("{} is not a checkpoint", path.display()));
        }
        let version = value.get("version").and_then(serde_json::Value::as_u64);
        if version != Some(u64::from(VERSION)) || field("sgc") != env!("CARGO_PKG_VERSION") {
            return Err(format!(
                "{} was written by sgc {}; this is {}, which would not go on in the same way: use the other one, or begin anew",
                path.display(),
                field("sgc"),
                env!("CARGO_PKG_VERSION")
            ));
        }
        let mut checkpoint: Self = serde_json::from_value(value).map_err(|e| damaged(&e))?;
        let sum = std::mem::take(&mut checkpoint.sum);
        if checkpoint.text().map(|text| hash(&text)) != Ok(sum.clone()) {
            return Err(damaged(&"its contents do not fit its checksum"));
        }
        if checkpoint.run != run {
            return Err(format!(
                "{} was changed after the run began: a run goes on only as it was asked",
                path.with_file_name("run.toml").display()
            ));
        }
        checkpoint.sum = sum;
        Ok(checkpoint)
    }
}

fn hash(text: &str) -> String {
    hex(&Sha256::digest(text))
}
