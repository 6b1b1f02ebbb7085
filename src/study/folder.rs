//! The folder of a study: all that its runs need, and where they are.
//!
//! `study.toml` is a copy of the file, `plan.json` what it comes to, `texts/` holds the grammars once for all runs, and
//! `runs/CELL/seed-N` is the folder of a run. A run is begun by whoever makes its folder first, and its lock is that of any other run:
//! so several processes, on several machines, can work on one study.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use grammar_lang::ir::{Direction, RuleSet};
use grammar_lang::source::SourceMap;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::StudyError;
use super::plan::Wanted;
use crate::results::FileError;
use crate::results::run_files::{self, Asked, Source, listed};
use crate::results::saved::{Grammar, hex};
use crate::results::whole::{entries, is_unfinished, read, write_own, write_whole};

/// The copy of the file.
pub const STUDY: &str = "study.toml";
/// What it comes to.
pub const PLAN: &str = "plan.json";
const RUNS: &str = "runs";
const TEXTS: &str = "texts";
const FORMAT: &str = "sgc study";
/// How the message of a run that failed is named, after the run.
const FAILED: &str = ".failed";

/// A cell with all that its runs are asked, but for the seed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cell {
    /// Its name, which is that of its folder.
    pub name: String,
    /// Its value of each factor.
    pub levels: Vec<String>,
    /// The command that does one of its runs alone, without its seed.
    pub command: String,
    /// The name of the grammar or variant.
    pub grammar: String,
    /// Hash of the typed rule set.
    pub rules: String,
    /// The text that declares it.
    pub entry: String,
    /// Parameters that are set.
    pub parameters: Vec<(String, String)>,
    /// Its texts.
    pub sources: Vec<Source>,
    /// The simulation method.
    pub solver: String,
    /// The bound on evaluations.
    pub max_evals: Option<u64>,
    /// The example that its runs start from.
    pub from: Option<String>,
    /// What the values are in.
    pub unit: String,
    /// Whether a lower value is better.
    pub minimizes: bool,
}

/// What is in `plan.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Plan {
    format: String,
    sgc: String,
    /// Where the file was.
    file: String,
    question: String,
    factors: Vec<String>,
    cells: Vec<Cell>,
    seeds: Vec<u64>,
    /// Hash of `study.toml`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    copy: Option<String>,
    /// Hash of all the other fields: whether somebody changed them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sum: Option<String>,
}

impl Plan {
    fn checksum(&self) -> Result<String, serde_json::Error> {
        let text = serde_json::to_string(&Self { sum: None, ..self.clone() })?;
        Ok(hex(&Sha256::digest(text)))
    }
}

/// One run of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The place of its cell in the plan.
    pub cell: usize,
    /// Its seed.
    pub seed: u64,
}

/// A study, on the disk.
#[derive(Clone, Debug)]
pub struct Study {
    path: PathBuf,
    plan: Plan,
}

/// What a changed file of a study changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Runs that it asks for and that were not asked for before.
    pub new: usize,
    /// Runs that it does not ask for any more; their folders stay.
    pub left: usize,
}

/// Whether a file is one that the study in its folder, or in the folder above, cannot do without.
#[must_use]
pub fn is_of_study(file: &Path) -> bool {
    let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some(folder) = file.parent() else { return false };
    let is_study = |folder: &Path| folder.join(PLAN).is_file();
    is_study(folder) && [STUDY, PLAN].contains(&name)
        || folder.file_name().is_some_and(|own| own == TEXTS) && folder.parent().is_some_and(is_study)
}

impl Cell {
    /// What a checked grammar and a cell of the file come to.
    #[must_use]
    pub fn new(
        wanted: &Wanted,
        grammar: &Grammar,
        rules: &RuleSet,
        command: String,
        from: Option<String>,
    ) -> Self {
        let sources = listed(grammar).into_iter().map(|source| Source {
            file: format!("{}.sgr", source.sha256.chars().take(16).collect::<String>()),
            ..source
        });
        Self {
            name: wanted.name.clone(),
            levels: wanted.levels.clone(),
            command,
            grammar: grammar.name.clone(),
            rules: grammar.rules.clone(),
            entry: grammar.entry.clone(),
            parameters: grammar.parameters.clone(),
            sources: sources.collect(),
            solver: crate::search::solver(rules).text().to_owned(),
            max_evals: wanted.max_evals,
            from,
            unit: rules.objective.unit.clone(),
            minimizes: rules.objective.direction == Direction::Minimize,
        }
    }

    /// Whether its runs are those of another one: from where its grammar was named does not matter.
    fn is_same(&self, other: &Self) -> bool {
        let decisive = |cell: &Self| Self { levels: Vec::new(), command: String::new(), ..cell.clone() };
        decisive(self) == decisive(other)
    }

    /// What differs from the same cell of the plan, whose texts are in a folder.
    fn changed_since(&self, other: &Self, texts: &Path) -> String {
        let known = |own: &Source| other.sources.iter().find(|other| other.name == own.name);
        for own in &self.sources {
            match known(own) {
                Some(other) if other.sha256 != own.sha256 => {
                    let text = texts.join(&other.file);
                    return format!("{} was changed (its earlier text is {})", own.name, text.display());
                }
                Some(_) => {}
                None => return format!("it uses {}, which it did not use before", own.name),
            }
        }
        if let Some(gone) =
            other.sources.iter().find(|other| self.sources.iter().all(|own| own.name != other.name))
        {
            return format!("it does not use {} any more", gone.name);
        }
        match self.parameters == other.parameters {
            true => "it is run with other settings".to_owned(),
            false => "its parameters have other values".to_owned(),
        }
    }
}

/// A path from the root, as text.
fn absolute(path: &Path) -> String {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    path.to_string_lossy().into_owned()
}

impl Study {
    /// Opens the folder of a study.
    ///
    /// # Errors
    ///
    /// There is none, it is damaged, or of another version of sgc.
    pub fn open(path: &Path) -> Result<Self, StudyError> {
        let file = path.join(PLAN);
        if !file.is_file() {
            return Err(match path.is_file() {
                true => StudyError::NoFolder { path: path.to_owned() },
                false => StudyError::NoStudy { path: path.to_owned() },
            });
        }
        let text = read(&file)?;
        let damaged = |why| StudyError::Damaged { path: file.clone(), why };
        let plan: Plan = serde_json::from_str(&text).map_err(|why| damaged(why.to_string()))?;
        if plan.format != FORMAT {
            return Err(damaged(format!("it lacks \"format\": \"{FORMAT}\"")));
        }
        let is_plain = |name: &str| !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\']);
        let fits = |cell: &Cell| cell.levels.len() == plan.factors.len() && is_plain(&cell.name);
        if let Some(cell) = plan.cells.iter().find(|cell| !fits(cell)) {
            return Err(damaged(format!("its cell \"{}\" is not as sgc writes one", cell.name)));
        }
        if plan.sgc != env!("CARGO_PKG_VERSION") {
            return Err(StudyError::OtherVersion { path: path.to_owned(), theirs: plan.sgc });
        }
        let is_as_written = plan.sum.is_none() || plan.checksum().ok() == plan.sum;
        if !is_as_written {
            return Err(damaged("it was changed since sgc wrote it".to_owned()));
        }
        Ok(Self { path: path.to_owned(), plan })
    }

    /// What a file comes to in a folder, in which there may be a study of it already: how it changes that. Nothing is written.
    ///
    /// # Errors
    ///
    /// The folder holds something else, or the study of another file, or a cell of the study had another grammar so far.
    pub fn planned(
        path: &Path,
        (file, text): (&Path, &str),
        question: &str,
        factors: Vec<String>,
        cells: &[(Cell, Grammar)],
        seeds: Vec<u64>,
    ) -> Result<(Self, Change), StudyError> {
        let before = match Self::open(path) {
            Ok(study) => Some(study),
            Err(StudyError::NoStudy { .. }) => None,
            Err(other) => return Err(other),
        };
        if before.is_none()
            && let Some(foreign) = entries(path).unwrap_or_default().into_iter().find(|name| !is_begun(name))
        {
            return Err(StudyError::Foreign { path: path.to_owned(), foreign });
        }
        // The plan is written before it: without one, this is somebody's, or of a process that begins the same study.
        let known = path.join(STUDY);
        if before.is_none()
            && fs::symlink_metadata(&known).is_ok()
            && read(&known).ok().as_deref() != Some(text)
        {
            return Err(StudyError::Foreign { path: path.to_owned(), foreign: STUDY.to_owned() });
        }
        let mut change = Change::default();
        if let Some(study) = &before {
            let known: BTreeMap<&str, &Cell> =
                study.plan.cells.iter().map(|c| (c.name.as_str(), c)).collect();
            let file = absolute(file);
            if study.plan.file != file && read(&path.join(STUDY)).ok().as_deref() != Some(text) {
                return Err(StudyError::OtherFile { path: path.to_owned(), theirs: study.plan.file.clone() });
            }
            for (cell, _) in cells {
                if let Some(other) = known.get(cell.name.as_str())
                    && !cell.is_same(other)
                {
                    return Err(StudyError::OtherCell {
                        path: path.to_owned(),
                        cell: cell.name.clone(),
                        what: cell.changed_since(other, &path.join(TEXTS)),
                    });
                }
            }
            let names = |study: &Self| -> BTreeSet<(String, u64)> {
                study.runs().map(|run| (study.cell(run).name.clone(), run.seed)).collect()
            };
            let now: BTreeSet<(String, u64)> = cells
                .iter()
                .flat_map(|(cell, _)| seeds.iter().map(|seed| (cell.name.clone(), *seed)))
                .collect();
            let then = names(study);
            change = Change { new: now.difference(&then).count(), left: then.difference(&now).count() };
        }
        let plan = Plan {
            format: FORMAT.to_owned(),
            sgc: env!("CARGO_PKG_VERSION").to_owned(),
            file: absolute(file),
            question: question.to_owned(),
            factors,
            cells: cells.iter().map(|(cell, _)| cell.clone()).collect(),
            seeds,
            copy: None,
            sum: None,
        };
        let study = Self { path: path.to_owned(), plan };
        if let Some(before) = &before {
            study.check_returned(before)?;
        }
        Ok((study, change))
    }

    /// Checks runs of cells that a plan before did not have. They may be of a plan before that.
    fn check_returned(&self, before: &Self) -> Result<(), StudyError> {
        let known: BTreeSet<&str> = before.plan.cells.iter().map(|cell| cell.name.as_str()).collect();
        for run in self.runs().filter(|run| !known.contains(self.cell(*run).name.as_str())) {
            let folder = self.folder(run);
            if run_files::is_run(&folder)
                && run_files::asked(&folder)?.identity() != self.asked(run).identity()
            {
                return Err(StudyError::OtherRun { path: folder });
            }
        }
        Ok(())
    }

    /// Writes the folder, or brings it up to the plan. Runs that it has done stay.
    ///
    /// # Errors
    ///
    /// A file cannot be written.
    pub fn write(&self, text: &str, cells: &[(Cell, Grammar)]) -> Result<(), StudyError> {
        self.check_copy(text)?;
        let texts = self.path.join(TEXTS);
        fs::create_dir_all(&texts).map_err(FileError::write(&texts))?;
        // Two processes that begin a study at once write the same.
        let mut written = BTreeSet::new();
        for (cell, grammar) in cells {
            for source in &cell.sources {
                let file = texts.join(&source.file);
                if written.insert(source.file.clone()) && !file.exists() {
                    write_whole(&file, grammar.sources.get(&source.name).map_or("", String::as_str))?;
                }
            }
        }
        let file = self.path.join(PLAN);
        let mut plan = Plan { copy: Some(hex(&Sha256::digest(text))), ..self.plan.clone() };
        plan.sum = Some(plan.checksum().map_err(FileError::write(&file))?);
        let json = serde_json::to_string_pretty(&plan).map_err(FileError::write(&file))? + "\n";
        for (file, text) in [(file, json.as_str()), (self.path.join(STUDY), text)] {
            if read(&file).ok().as_deref() != Some(text) {
                write_own(&file, text)?;
            }
        }
        Ok(())
    }

    /// Refuses to replace a copy of the file that is not as it was written.
    fn check_copy(&self, text: &str) -> Result<(), StudyError> {
        let known = self.path.join(STUDY);
        let Ok(there) = read(&known) else { return Ok(()) };
        let before = read(&self.path.join(PLAN)).ok();
        let before = before.and_then(|text| serde_json::from_str::<Plan>(&text).ok());
        let is_as_written = before.is_some_and(|plan| plan.copy == Some(hex(&Sha256::digest(&there))));
        if there == text || is_as_written { Ok(()) } else { Err(StudyError::Edited { path: known }) }
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it asks, in words.
    #[must_use]
    pub fn question(&self) -> &str {
        &self.plan.question
    }

    /// The names of its factors.
    #[must_use]
    pub fn factors(&self) -> &[String] {
        &self.plan.factors
    }

    /// Its cells.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.plan.cells
    }

    /// Its seeds.
    #[must_use]
    pub fn seeds(&self) -> &[u64] {
        &self.plan.seeds
    }

    /// The cell of a run.
    #[must_use]
    pub fn cell(&self, run: Run) -> &Cell {
        &self.plan.cells[run.cell]
    }

    /// All runs: the first seed of every cell, then the second of every cell, so that cells can be compared early.
    pub fn runs(&self) -> impl Iterator<Item = Run> + '_ {
        let cells = self.plan.cells.len();
        self.plan.seeds.iter().flat_map(move |&seed| (0..cells).map(move |cell| Run { cell, seed }))
    }

    /// The name of a run: its folder under `runs/`.
    #[must_use]
    pub fn name(&self, run: Run) -> String {
        format!("{}/seed-{}", self.cell(run).name, run.seed)
    }

    /// The run of a name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<Run> {
        let (cell, seed) = name.rsplit_once("/seed-")?;
        let cell = self.plan.cells.iter().position(|own| own.name == cell)?;
        let seed = seed.parse().ok().filter(|seed| self.plan.seeds.contains(seed))?;
        Some(Run { cell, seed })
    }

    /// The folder of a run.
    #[must_use]
    pub fn folder(&self, run: Run) -> PathBuf {
        self.path.join(RUNS).join(&self.cell(run).name).join(format!("seed-{}", run.seed))
    }

    /// Where it is noted why a run failed.
    #[must_use]
    pub fn note_of(&self, run: Run) -> PathBuf {
        self.path.join(RUNS).join(&self.cell(run).name).join(format!("seed-{}{FAILED}", run.seed))
    }

    /// The texts of a cell with what they say.
    ///
    /// # Errors
    ///
    /// A text is gone or was changed.
    pub fn compile(&self, cell: usize) -> Result<(Grammar, RuleSet, SourceMap), StudyError> {
        let asked = self.asked(Run { cell, seed: 0 });
        let texts = self.path.join(TEXTS);
        let grammar = run_files::texts(&asked, |source| {
            texts.join(Path::new(&source.file).file_name().unwrap_or_default())
        })?;
        let (rules, sources) = grammar.compile_with_sources(&asked.sgc).map_err(FileError::inside(&texts))?;
        Ok((grammar, rules, sources))
    }

    /// What a run is asked.
    #[must_use]
    pub fn asked(&self, run: Run) -> Asked {
        let cell = self.cell(run);
        Asked {
            command: format!("{} --seed {}", cell.command, run.seed),
            sgc: self.plan.sgc.clone(),
            grammar: cell.grammar.clone(),
            rules: cell.rules.clone(),
            seed: run.seed,
            solver: cell.solver.clone(),
            max_evals: cell.max_evals,
            time: None,
            from: cell.from.clone(),
            design: None,
            entry: cell.entry.clone(),
            parameters: cell.parameters.clone(),
            // Once for all runs: from the folder of a run.
            sources: cell
                .sources
                .iter()
                .map(|source| Source { file: format!("../../../{TEXTS}/{}", source.file), ..source.clone() })
                .collect(),
        }
    }
}

/// Whether a process that begins a study, or that was killed as it did, has made what has this name.
fn is_begun(name: &str) -> bool {
    name == TEXTS || name == STUDY || is_unfinished(name)
}
