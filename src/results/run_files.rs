//! The files of a run, read: what it was asked, what it froze, what it came to.

use crate::score::Observed;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::evals::Mark;
use super::learning::LEARNING;
use super::processes::{self, PROCESSES};
use super::saved::{Grammar, hex};
use super::whole::read;
use super::{Damage, FileError, Unfit, archive, front};
use crate::reading;

pub(crate) const RUN: &str = "run.toml";
pub(super) const SOURCES: &str = "sources";
pub(super) const EVALS: &str = "evals.csv";
pub(crate) const CHECKPOINT: &str = "checkpoint";
pub(super) const BEST: &str = "best.design.json";
pub(super) const RESULT: &str = "result.json";

/// What a run was asked; the content of `run.toml`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Asked {
    /// The command line.
    pub command: String,
    /// The version of sgc.
    pub sgc: String,
    /// The grammar's name.
    pub grammar: String,
    /// Hash of the typed rule set.
    pub rules: String,
    /// The seed.
    pub seed: u64,
    /// The solver.
    pub solver: String,
    /// The bound on evaluations.
    pub max_evals: Option<u64>,
    /// The bound on time, as it was written.
    pub time: Option<String>,
    /// The example that it started from, if it was not the initial design.
    pub from: Option<String>,
    /// The saved design that it started from, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub design: Option<String>,
    /// The text that declares the grammar.
    pub entry: String,
    /// Parameters that were set from outside.
    pub parameters: Vec<(String, String)>,
    /// The texts in `sources/`.
    pub sources: Vec<Source>,
}

/// Whether a file is one of those that a run in its folder, or in the folder above, cannot do without.
#[must_use]
pub fn is_of_run(file: &Path) -> bool {
    let is_in = |folder: &Path, names: &[&str]| {
        folder.parent().is_some_and(is_run)
            && folder.file_name().is_some_and(|name| names.iter().any(|own| name == *own))
    };
    let is_within =
        |names: &[&str]| file.parent().is_some_and(|folder| folder.is_dir() && is_in(folder, names));
    let is_design =
        file.file_name().and_then(|name| name.to_str()).is_some_and(|n| n.ends_with(".design.json"));
    is_in(
        file,
        &[
            RUN,
            EVALS,
            LEARNING,
            CHECKPOINT,
            BEST,
            RESULT,
            PROCESSES,
            processes::BEFORE,
            archive::TABLE,
            front::TABLE,
        ],
    ) || is_within(&[SOURCES])
        || is_design && is_within(&[archive::FOLDER, front::FOLDER])
}

/// Evaluations of a run that was not told how many.
pub const EVALUATIONS: u64 = 8000;

impl Asked {
    /// Hash of all that decides what comes of a run: the same for any command line that asks for it, and for any bound, as a
    /// run that was stopped goes on with another one.
    #[must_use]
    pub fn identity(&self) -> String {
        let decisive = Self { command: String::new(), max_evals: None, time: None, ..self.clone() };
        hex(&Sha256::digest(serde_json::to_string(&decisive).unwrap_or_default()))
    }
}

/// A text of the grammar, frozen in `sources/`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// What the grammar calls it.
    pub name: String,
    /// Its file.
    pub file: String,
    /// The hash of its text.
    pub sha256: String,
}

impl Source {
    /// Whether its file is no copy of this run, but one that the runs of a study share: it is named from the run's folder.
    pub(super) fn is_shared(&self) -> bool {
        self.file.starts_with("../")
    }
}

/// What a complete run says in `result.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Finished {
    /// The grammar's name.
    pub grammar: String,
    /// The seed.
    pub seed: u64,
    /// The value of the best design; none if there is none.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// What was observed of it, in SI units.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub observed: IndexMap<String, Option<Observed>>,
    /// Evaluations spent.
    pub evaluations: u64,
    /// Outer moves made.
    pub moves: usize,
    /// Evaluations without a value, by reason.
    pub invalid: BTreeMap<String, u64>,
    /// Would-be bests that lost their value at half the step.
    pub unstable: u64,
    /// Of how many cross-checks its best kept its value in how many. Earlier versions did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checks: Option<(usize, usize)>,
    /// What its best reaches in nine of ten worlds that the search never saw, where its task names some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nine_of_ten: Option<f64>,
    /// What its best comes to over those worlds, where they do not tell that one by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_worlds: Option<f64>,
    /// Why it ended.
    pub end: String,
    /// The bound on evaluations that it ended with: a run that goes on may be given another one. Earlier versions did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_evals: Option<u64>,
    /// Hash of all else that it says. Earlier versions did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sum: Option<String>,
    /// The table of its moves. Earlier versions did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evals: Option<Mark>,
    /// What it is the result of: a hash of it. Earlier versions did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<String>,
}

impl Finished {
    /// The hash of all that it says but for the hash itself.
    fn checksum(&self) -> Result<String, serde_json::Error> {
        let text = serde_json::to_string(&Self { sum: None, ..self.clone() })?;
        Ok(hex(&Sha256::digest(text)))
    }

    /// The text of the file.
    ///
    /// # Errors
    ///
    /// It cannot be written down.
    pub(super) fn text(&self) -> Result<String, serde_json::Error> {
        let whole = Self { sum: Some(self.checksum()?), ..self.clone() };
        Ok(serde_json::to_string_pretty(&whole)? + "\n")
    }
}

/// The texts of a grammar as [`Asked`] lists them.
#[must_use]
pub fn listed(grammar: &Grammar) -> Vec<Source> {
    let mut taken = BTreeSet::new();
    let list = grammar.sources.iter().map(|(name, text)| {
        let mut file = file_name(name);
        while !taken.insert(file.clone()) {
            file = format!("again-{file}");
        }
        Source { name: name.clone(), file, sha256: hex(&Sha256::digest(text)) }
    });
    list.collect()
}

/// Whether there is a run in a folder.
#[must_use]
pub fn is_run(path: &Path) -> bool {
    path.join(RUN).is_file()
}

/// Whether the run in a folder is complete, by the name of its result alone.
#[must_use]
pub fn has_result(path: &Path) -> bool {
    path.join(RESULT).is_file()
}

/// Where a run in a folder keeps its best design.
#[must_use]
pub fn best(path: &Path) -> PathBuf {
    path.join(BEST)
}

/// What a complete run says; none if it is not complete.
///
/// # Errors
///
/// A sentence: the result cannot be read.
pub fn finished(path: &Path) -> Result<Option<Finished>, FileError> {
    let path = path.join(RESULT);
    match reading::own(&path) {
        Ok(bytes) => {
            let finished: Finished = serde_json::from_slice(&bytes).map_err(FileError::damaged(&path))?;
            let sum = finished.checksum().map_err(FileError::damaged(&path))?;
            match finished.sum.as_ref().is_none_or(|own| *own == sum) {
                true => Ok(Some(finished)),
                false => Err(FileError::damaged(&path)(Damage::Sum)),
            }
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(FileError::read(&path)(e)),
    }
}

/// What the run in a folder was asked.
///
/// # Errors
///
/// A sentence: `run.toml` cannot be read, or is damaged.
pub fn asked(path: &Path) -> Result<Asked, FileError> {
    let path = path.join(RUN);
    toml::from_str(&read(&path)?).map_err(FileError::damaged(&path))
}

/// The texts that a run froze when it began.
///
/// # Errors
///
/// A sentence: a text is gone or was changed.
pub fn frozen(path: &Path, asked: &Asked) -> Result<Grammar, FileError> {
    texts(asked, |source| match source.is_shared() {
        true => path.join(&source.file),
        false => path.join(SOURCES).join(&source.file),
    })
}

/// The texts that a run was asked with, each from its file.
///
/// # Errors
///
/// A sentence: a text is gone or was changed.
pub fn texts(asked: &Asked, place: impl Fn(&Source) -> PathBuf) -> Result<Grammar, FileError> {
    let mut sources = BTreeMap::new();
    for source in &asked.sources {
        let file = place(source);
        let text = read(&file)?;
        if hex(&Sha256::digest(&text)) != source.sha256 {
            return Err(FileError::unfit(&file, Unfit::OtherText));
        }
        sources.insert(source.name.clone(), text);
    }
    Ok(Grammar {
        name: asked.grammar.clone(),
        rules: asked.rules.clone(),
        entry: asked.entry.clone(),
        parameters: asked.parameters.clone(),
        sources,
    })
}

/// A file name for a source: `std.blocks` becomes `std.blocks.sgr`, folders become dashes.
fn file_name(name: &str) -> String {
    let flat: String = name
        .chars()
        .map(|c| if c.is_alphanumeric() || matches!(c, '.' | '_' | '-') { c } else { '-' })
        .collect();
    let flat = flat.trim_start_matches(['-', '.']).to_owned();
    if flat.ends_with(".sgr") { flat } else { format!("{flat}.sgr") }
}
