//! Several runs of one grammar in one folder, a seed each.

use std::fs;
use std::path::{Path, PathBuf};

use grammar_lang::ir::RuleSet;
use serde::{Deserialize, Serialize};

use super::FileError;
use super::describe;
use super::elsewhere::{self, Tested};
use super::evals::quoted;
use super::genuine;
use super::leftovers;
use super::place::{RUNS, SUMMARY, check_place, check_series, is_series};
use super::run_files::{self, finished};
use super::saved::SavedDesign;
use super::verdict::{kept, stands_still};
use super::whole::{aside, lock, lock_again, make_folder, read, write_whole};

const COLUMNS: &str = "seed,value,unit,evaluations,end,checks_kept,checks,nine_of_ten,over_worlds\n";

/// What several runs were asked; the content of `runs.toml`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Series {
    /// The command line.
    pub command: String,
    /// The version of sgc.
    pub sgc: String,
    /// The grammar's name.
    pub grammar: String,
    /// The seeds.
    pub seeds: Vec<u64>,
}

/// The folder of several runs. Another process cannot go on with them as long as this lives.
#[derive(Debug)]
pub struct SeriesFolder {
    path: PathBuf,
    series: Series,
    _lock: fs::File,
}

/// One run in a summary.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its seed.
    pub seed: u64,
    /// The value of its best design.
    pub value: Option<f64>,
    unit: String,
    evaluations: Option<u64>,
    end: String,
    /// Whether the best does no better than a body that stands still.
    pub is_still: bool,
    /// Of how many cross-checks the value was kept in how many.
    checks: Option<(usize, usize)>,
    /// What nine of ten worlds are at least as good as that the search never saw, where it was tested in some.
    tenth: Option<f64>,
    /// What it comes to over all those worlds, where they do not tell it one by one.
    whole: Option<f64>,
}

/// What several runs in a folder were asked.
///
/// # Errors
///
/// A sentence: `runs.toml` cannot be read, or is damaged.
pub fn series(path: &Path) -> Result<Series, FileError> {
    let path = path.join(RUNS);
    toml::from_str(&read(&path)?).map_err(FileError::damaged(&path))
}

/// The folders of the runs in a folder of several, in the order of their seeds.
///
/// # Errors
///
/// A sentence: `runs.toml` cannot be read, or is damaged.
pub fn runs(path: &Path) -> Result<Vec<PathBuf>, FileError> {
    Ok(series(path)?.seeds.iter().map(|seed| run_folder(path, *seed)).collect())
}

/// The folder of one of several runs.
pub(super) fn run_folder(path: &Path, seed: u64) -> PathBuf {
    path.join(format!("seed-{seed}"))
}

impl SeriesFolder {
    /// Makes the folder, whole or not at all; `begin` makes that of each run.
    ///
    /// # Errors
    ///
    /// A sentence: the folder exists and is not empty (unless `force`), or cannot be written.
    pub fn create(
        path: &Path,
        force: bool,
        series: Series,
        begin: impl Fn(u64, &Path) -> Result<(), FileError>,
    ) -> Result<Self, FileError> {
        let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let check = || {
            if is_series(path) && force {
                check_series(path).map(|()| true)
            } else {
                check_place(path, force)
            }
        };
        let replaced = check()?.then(|| aside(path));
        let lock = make_folder(
            path,
            replaced.as_deref(),
            || check().map(drop),
            |path| {
                let file = path.join(RUNS);
                let text = toml::to_string(&series).map_err(FileError::write(&file))?;
                write_whole(&file, &text)?;
                for &seed in &series.seeds {
                    begin(seed, &run_folder(path, seed))?;
                }
                lock(&file)
            },
        )?;
        leftovers::clear_unfinished(path);
        Ok(Self { path: path.to_owned(), series, _lock: lock })
    }

    /// Removes what these runs replaced, now that one of them has a design. What somebody has put into it meanwhile stays.
    pub fn settle(&self) {
        leftovers::clear(&self.path, leftovers::replaces(&self.series.command));
    }

    /// Opens the folder, to go on with those that are not complete.
    ///
    /// # Errors
    ///
    /// A sentence: another process goes on with them, or a file is damaged.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let file = path.join(RUNS);
        let lock = lock_again(&file)?;
        let series = series(path)?;
        leftovers::clear_unfinished(path);
        Ok(Self { path: path.to_owned(), series, _lock: lock })
    }

    /// Where the folder is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The seeds.
    #[must_use]
    pub fn seeds(&self) -> &[u64] {
        &self.series.seeds
    }

    /// The folder of one run.
    #[must_use]
    pub fn run(&self, seed: u64) -> PathBuf {
        run_folder(&self.path, seed)
    }

    /// What is known of all runs, and the rules that they share; also written to `summary.csv`.
    ///
    /// # Errors
    ///
    /// A sentence: a result or design cannot be read, or the summary cannot be written.
    pub fn summary(&self) -> Result<(Vec<Line>, Option<RuleSet>), FileError> {
        let mut rules: Option<RuleSet> = None;
        let mut lines = Vec::new();
        let paths = || self.series.seeds.iter().map(|&seed| self.run(seed));
        let runs: Vec<_> = paths()
            .map(|path| run_files::asked(&path).map(|asked| (path, asked)))
            .collect::<Result<_, _>>()?;
        genuine::check_one_grammar(runs.iter().map(|(path, asked)| (path.as_path(), asked)))?;
        for (&seed, (path, asked)) in self.series.seeds.iter().zip(&runs) {
            genuine::check_seed(path, asked, seed)?;
            let best = run_files::best(path);
            let design = if best.exists() { Some(SavedDesign::read_own(&best)?) } else { None };
            if let (None, Some(design)) = (&rules, &design) {
                rules = Some(design.grammar.compile(&design.sgc).map_err(FileError::inside(&best))?);
            }
            let finished = finished(path)?;
            if let Some(design) = &design {
                genuine::check_run(design, asked, finished.as_ref()).map_err(FileError::inside(&best))?;
            }
            let is_complete = finished.is_some();
            let checks = design
                .as_ref()
                .zip(rules.as_ref())
                .filter(|_| is_complete)
                .map(|(design, rules)| kept(rules, design));
            let is_still = design
                .as_ref()
                .zip(rules.as_ref())
                .is_some_and(|(design, rules)| stands_still(rules, design));
            let tested = design.as_ref().zip(rules.as_ref());
            let tested = tested.and_then(|(design, rules)| elsewhere::tested(rules, design));
            lines.push(Line {
                tenth: tested.as_ref().and_then(|tested| tested.each()?.tenth),
                whole: tested.as_ref().and_then(Tested::whole),
                seed,
                is_still,
                value: design.as_ref().map(|d| d.value),
                unit: design.map(|d| d.unit).unwrap_or_default(),
                evaluations: finished.as_ref().map(|f| f.evaluations),
                end: finished.map_or("not complete".to_owned(), |f| f.end),
                checks,
            });
        }
        let rows: String = lines.iter().map(Line::row).collect();
        write_whole(&self.path.join(SUMMARY), &(COLUMNS.to_owned() + &rows))?;
        Ok((lines, rules))
    }
}

impl Line {
    fn row(&self) -> String {
        let or_empty = |text: Option<String>| text.unwrap_or_default();
        format!(
            "{},{},{},{},{},{},{},{},{}\n",
            self.seed,
            or_empty(self.value.map(|v| v.to_string())),
            quoted(&self.unit),
            or_empty(self.evaluations.map(|n| n.to_string())),
            quoted(&self.end),
            or_empty(self.checks.map(|(kept, _)| kept.to_string())),
            or_empty(self.checks.map(|(_, all)| all.to_string())),
            or_empty(self.tenth.map(|tenth| tenth.to_string())),
            or_empty(self.whole.map(|whole| whole.to_string())),
        )
    }
}

/// The lines as a table for people.
#[must_use]
pub fn table(lines: &[Line]) -> String {
    let cells = |line: &Line| {
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        [
            line.seed.to_string(),
            or_dash(line.value.map(|value| describe::quantity(value, &line.unit))),
            or_dash(line.tenth.or(line.whole).map(|value| describe::quantity(value, &line.unit))),
            or_dash(line.evaluations.map(|n| n.to_string())),
            or_dash(line.checks.map(|(kept, all)| format!("{kept} of {all}"))),
            line.end.clone(),
        ]
    };
    // All are runs of one grammar.
    let elsewhere = match lines.iter().any(|line| line.whole.is_some()) {
        true => "over other worlds",
        false => "nine of ten worlds",
    };
    let head = ["seed", "value", elsewhere, "evaluations", "checks kept", "end"].map(str::to_owned);
    let rows: Vec<_> = std::iter::once(head).chain(lines.iter().map(cells)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = [0, 1, 2, 3, 4].map(width);
    let line = |row: &[String; 6]| {
        let cells: Vec<_> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        format!("{}  {}\n", cells.join("  "), row[5])
    };
    rows.iter().map(line).collect()
}
