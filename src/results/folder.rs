//! The run folder: what a run was asked, what it did, what it found.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::saved::{Grammar, SavedDesign};
use crate::search::{Outcome, Row};

/// What a run was asked; the content of `run.toml`.
#[derive(Clone, Debug, Serialize)]
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
    /// Parameters that were set from outside.
    pub parameters: std::collections::BTreeMap<String, String>,
}

/// What a complete run says in `result.json`.
#[derive(Clone, Debug, Serialize)]
struct Finished<'a> {
    grammar: &'a str,
    seed: u64,
    value: Option<f64>,
    unit: &'a str,
    evaluations: u64,
    moves: usize,
    /// Evaluations without a value, by reason.
    invalid: BTreeMap<&'static str, u64>,
    /// Would-be bests that lost their value at half the step.
    unstable: u64,
    end: &'a str,
}

/// A run folder that is being written.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    evals: fs::File,
    /// The run that this one replaces, kept until there is a first best.
    replaced: std::cell::RefCell<Option<PathBuf>>,
}

/// Writes a file so that it is there whole or not at all: beside it first,
/// flushed to the disk, then renamed.
///
/// # Errors
///
/// A sentence with the path and the system's reason.
pub fn write_whole(path: &Path, text: &str) -> Result<(), String> {
    write_with(path, text, None)
}

/// Replaces the text of a file that exists, as [`write_whole`] does; who may read
/// and write it stays as it is.
///
/// # Errors
///
/// A sentence with the path and the reason: also if the file may not be written.
pub fn rewrite(path: &Path, text: &str) -> Result<(), String> {
    let fault = |e: &dyn std::fmt::Display| format!("cannot write {}: {e}", path.display());
    let permissions = fs::metadata(path).map_err(|e| fault(&e))?.permissions();
    // A rename would replace even a file that may not be written.
    if permissions.readonly() {
        return Err(fault(&"it is read-only"));
    }
    write_with(path, text, Some(permissions))
}

fn write_with(path: &Path, text: &str, permissions: Option<fs::Permissions>) -> Result<(), String> {
    let fault = |e: &dyn std::fmt::Display| format!("cannot write {}: {e}", path.display());
    // A link is followed; a device or pipe is no file to be replaced.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if path.exists() && !path.is_file() {
        return Err(format!("cannot write {}: it is not a regular file", path.display()));
    }
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    // As any other file: readable by whom the user's mask allows.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(parent).map_err(|e| fault(&e))?;
    if let Ok(old) = fs::metadata(path) {
        // What replaces a file is open to the same people.
        file.as_file().set_permissions(old.permissions()).map_err(|e| fault(&e))?;
    }
    file.write_all(text.as_bytes()).map_err(|e| fault(&e))?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions).map_err(|e| fault(&e))?;
    }
    file.as_file().sync_all().map_err(|e| fault(&e))?;
    file.persist(path).map_err(|e| fault(&e.error))?;
    Ok(())
}

/// The columns of `evals.csv`.
const COLUMNS: &str = "move,iteration,rule,blocked,parts,actuators,value,accepted,best,temperature,evaluations,invalid,unstable,why_invalid\n";

impl RunFolder {
    /// Makes a folder for a run.
    ///
    /// # Errors
    ///
    /// A sentence: the folder exists and is not empty (unless `force`), or cannot be written.
    pub fn create(path: &Path, force: bool, asked: &Asked, grammar: &Grammar) -> Result<Self, String> {
        let fault = |what: &Path, e: &dyn std::fmt::Display| format!("cannot write {}: {e}", what.display());
        // A link is followed: what it points to is replaced, not the link.
        let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let mut replaced = None;
        if path.exists() {
            let entries =
                if path.is_dir() { entries(path).map_err(|e| fault(path, &e))? } else { vec![String::new()] };
            if !entries.is_empty() {
                if !force {
                    return Err(format!(
                        "{} exists already; choose another folder with --out, another --seed, or replace it with --force",
                        path.display()
                    ));
                }
                // Only what a run has written is ever replaced.
                if let Some(foreign) = entries.iter().find(|e| !is_own(e)) {
                    return Err(format!(
                        "{} is not only a run folder: \"{foreign}\" in it was not written by a run; --force replaces only run folders",
                        path.display()
                    ));
                }
                let aside = path.with_file_name(format!(
                    "{}.replaced-{}",
                    path.file_name().unwrap_or_default().to_string_lossy(),
                    std::process::id()
                ));
                fs::rename(path, &aside).map_err(|e| fault(path, &e))?;
                replaced = Some(aside);
            }
        }
        let folder = Self::fill(path, asked, grammar).map(|evals| Self {
            path: path.to_owned(),
            evals,
            replaced: std::cell::RefCell::new(replaced.clone()),
        });
        if folder.is_err()
            && let Some(aside) = replaced
        {
            // Nothing was gained: put the old run back.
            let _ = fs::remove_dir_all(path);
            let _ = fs::rename(aside, path);
        }
        folder
    }

    fn fill(path: &Path, asked: &Asked, grammar: &Grammar) -> Result<fs::File, String> {
        let fault = |what: &Path, e: &dyn std::fmt::Display| format!("cannot write {}: {e}", what.display());
        fs::create_dir_all(path).map_err(|e| fault(path, &e))?;
        let text = toml::to_string(asked).map_err(|e| fault(&path.join("run.toml"), &e))?;
        write_whole(&path.join("run.toml"), &text)?;
        fs::create_dir_all(path.join("sources")).map_err(|e| fault(path, &e))?;
        for (name, text) in &grammar.sources {
            write_whole(&path.join("sources").join(file_name(name)), text)?;
        }
        let evals_path = path.join("evals.csv");
        let mut evals = fs::File::create(&evals_path).map_err(|e| fault(&evals_path, &e))?;
        evals.write_all(COLUMNS.as_bytes()).map_err(|e| fault(&evals_path, &e))?;
        Ok(evals)
    }

    /// Where the best design is.
    #[must_use]
    pub fn best_path(&self) -> PathBuf {
        self.path.join("best.design.json")
    }

    /// Where the folder is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a row to `evals.csv`.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn row(&mut self, row: &Row) -> Result<(), String> {
        let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x}"));
        let blocked: Vec<String> = row.blocked.iter().map(|(rule, why)| format!("{rule}: {why}")).collect();
        let line = format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
            row.number,
            row.iteration,
            row.rule.as_deref().unwrap_or(""),
            quoted(&blocked.join("; ")),
            row.size.0,
            row.size.1,
            number(row.value),
            row.accepted,
            number(row.best),
            row.temperature,
            row.evaluations,
            row.tally.invalid(),
            row.tally.unstable,
            quoted(&row.tally.reasons()),
        );
        self.evals
            .write_all(line.as_bytes())
            .map_err(|e| format!("cannot write {}: {e}", self.path.join("evals.csv").display()))
    }

    /// Replaces the best design.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn best(&self, design: &SavedDesign) -> Result<(), String> {
        write_whole(&self.best_path(), &design.text())?;
        if let Some(old) = self.replaced.borrow_mut().take() {
            fs::remove_dir_all(&old).map_err(|e| format!("cannot remove {}: {e}", old.display()))?;
        }
        Ok(())
    }

    /// Says that the run is complete.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn finish(&self, asked: &Asked, unit: &str, outcome: &Outcome) -> Result<(), String> {
        let finished = Finished {
            grammar: &asked.grammar,
            seed: asked.seed,
            value: outcome.best.as_ref().map(|b| b.value),
            unit,
            evaluations: outcome.evaluations,
            moves: outcome.moves,
            invalid: outcome.tally.by_reason().collect(),
            unstable: outcome.tally.unstable,
            end: outcome.end.text(),
        };
        let text = serde_json::to_string_pretty(&finished).map_err(|e| e.to_string())? + "\n";
        write_whole(&self.path.join("result.json"), &text)
    }
}

impl Drop for RunFolder {
    /// A run that found nothing gives the folder back to the run it was to replace.
    fn drop(&mut self) {
        if let Some(old) = self.replaced.borrow_mut().take() {
            let _ = fs::remove_dir_all(&self.path);
            let _ = fs::rename(old, &self.path);
        }
    }
}

/// The names in a folder.
fn entries(path: &Path) -> std::io::Result<Vec<String>> {
    fs::read_dir(path)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

/// Whether a run writes files of this name.
fn is_own(name: &str) -> bool {
    let known = ["run.toml", "sources", "evals.csv", "best.design.json", "result.json", "view.html"];
    known.contains(&name) || name.starts_with(".tmp")
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

/// A text as a field of a csv file.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
