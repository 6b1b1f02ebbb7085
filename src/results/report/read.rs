//! Folders of runs, read for a report.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use grammar_lang::ir::{Direction, RuleSet};
use grammar_lang::source::SourceMap;

use super::error::{Lost, ReportError};
use super::moves::{Move, lineage, moves};
use crate::results::DesignError;
use crate::results::checkpoint;
use crate::results::elsewhere::{Tested, tested};
use crate::results::genuine;
use crate::results::learning;
use crate::results::place::{RUNS, is_series};
use crate::results::processes::{self, Process};
use crate::results::run_files::{self, Asked, BEST, EVALS, Finished, RUN};
use crate::results::saved::{Grammar, SavedDesign};
use crate::results::series::{self, run_folder};
use crate::results::verdict::{kept, silent};
use crate::results::whole::is_locked;

/// The rules of a grammar and their texts, or why this version of sgc cannot read them.
type Rules = Result<Rc<(RuleSet, SourceMap)>, Rc<DesignError>>;

/// Runs that belong together: those of a folder that was named.
#[derive(Debug)]
pub(crate) struct Group {
    /// What the report calls it; no other group of the report is called so.
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    pub(crate) runs: Vec<Run>,
    /// The unit of the values.
    pub(crate) unit: String,
    pub(crate) direction: Direction,
    pub(crate) rules: Rules,
}

/// One run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) path: PathBuf,
    pub(crate) asked: Asked,
    pub(crate) rules: Rules,
    pub(crate) standing: Standing,
    pub(crate) moves: Vec<Move>,
    /// The iterations of its learner; empty where nothing learns.
    pub(crate) learning: Vec<learning::Row>,
    /// The best design so far, or why it cannot be read; none if there is none.
    pub(crate) design: Option<Result<Found, Lost>>,
    /// None where nobody kept count.
    pub(crate) processes: Option<Vec<Process>>,
}

/// A saved design with the rules that made it.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) design: SavedDesign,
    pub(crate) rules: Rules,
}

/// How far a run is.
#[derive(Clone, Debug)]
pub(crate) enum Standing {
    Complete(Box<Finished>),
    /// Another process goes on with it.
    UnderWay,
    /// It can be gone on with.
    Stopped,
    /// It has not begun yet, and waits for its turn among several.
    Waiting,
}

impl Standing {
    /// In words.
    pub(crate) fn text(&self) -> &str {
        match self {
            Self::Complete(finished) => &finished.end,
            Self::UnderWay => "under way",
            Self::Stopped => "stopped before its end",
            Self::Waiting => "waiting for its turn",
        }
    }
}

impl Run {
    /// Evaluations spent, as far as is known.
    pub(crate) fn evaluations(&self) -> u64 {
        match &self.standing {
            Standing::Complete(finished) => finished.evaluations,
            _ => self.moves.last().map_or(0, |m| m.evaluations),
        }
    }

    /// The best value so far.
    pub(crate) fn value(&self) -> Option<f64> {
        self.moves.last().and_then(|m| m.best)
    }

    /// The row of the move that found the best: of several with the best value, as in a search for a front, the one that the design
    /// names.
    pub(crate) fn found(&self) -> Option<&Move> {
        let best = self.value()?;
        let number = self
            .design
            .as_ref()
            .and_then(|design| design.as_ref().ok())
            .map(|found| found.design.found_at as u64);
        let named = self.moves.iter().find(|m| Some(m.number) == number && m.value == Some(best));
        named.or_else(|| self.moves.iter().find(|m| m.best == Some(best)))
    }

    /// The bound on its evaluations.
    pub(crate) fn max_evals(&self) -> Option<u64> {
        match &self.standing {
            Standing::Complete(finished) => finished.max_evals.or(self.asked.max_evals),
            _ => self.asked.max_evals,
        }
    }

    pub(crate) fn is_complete(&self) -> bool {
        matches!(self.standing, Standing::Complete(_))
    }

    /// The moves that led to the best, the last first; none if that is not known.
    pub(crate) fn history(&self) -> Option<Vec<&Move>> {
        lineage(&self.moves, self.found()?)
    }

    /// Of how many cross-checks of a complete run the value was kept in how many.
    pub(crate) fn checks(&self) -> Option<(usize, usize)> {
        let Some(Ok(Found { design, rules: Ok(rules) })) = &self.design else { return None };
        self.is_complete().then(|| kept(&rules.0, design))
    }

    /// The cross-checks of a complete run that said nothing.
    pub(crate) fn silent_checks(&self) -> Vec<String> {
        let Some(Ok(Found { design, rules: Ok(rules) })) = &self.design else { return Vec::new() };
        let names = silent(&rules.0, design).map(str::to_owned).collect();
        if self.is_complete() { names } else { Vec::new() }
    }
}

impl Run {
    /// What its best is in worlds that the search never saw, once that was tested.
    pub(crate) fn tested(&self) -> Option<Tested> {
        let Some(Ok(Found { design, rules: Ok(rules) })) = &self.design else { return None };
        tested(&rules.0, design)
    }
}

impl Group {
    /// A value on a scale where more is better.
    pub(crate) fn fitness(&self, value: f64) -> f64 {
        self.direction.fitness(value)
    }

    /// The run with the best value so far; of several, the first.
    pub(crate) fn best(&self) -> Option<(usize, &Run)> {
        let valued = self.runs.iter().enumerate().filter_map(|(i, run)| Some((i, run, run.value()?)));
        valued
            .min_by(|a, b| self.fitness(b.2).total_cmp(&self.fitness(a.2)))
            .map(|(index, run, _)| (index, run))
    }

    /// The best values of the runs that have begun; none of one that has found nothing.
    pub(crate) fn outcomes(&self) -> Vec<Option<f64>> {
        self.runs.iter().filter(|run| !run.moves.is_empty()).map(Run::value).collect()
    }

    /// The best values of the runs that have one.
    pub(crate) fn values(&self) -> Vec<f64> {
        self.runs.iter().filter_map(Run::value).collect()
    }
}

/// Who asks for the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asker {
    /// Somebody outside: whether a run is under way is known by its lock.
    Anybody,
    /// The process that goes on with the runs: what is not complete is under way, and no lock is touched.
    Going,
    /// The same at its end: what is not complete is stopped.
    Gone,
}

/// Reads the groups of a report: a run folder or the folder of several runs for each.
///
/// # Errors
///
/// A folder holds no runs, is damaged or is named twice, or values cannot be compared.
pub(crate) fn groups(paths: &[PathBuf], asker: Asker) -> Result<Vec<Group>, ReportError> {
    let mut compiled = Compiled::default();
    let groups: Vec<Group> =
        paths.iter().map(|path| group(path, asker, &mut compiled)).collect::<Result<_, _>>()?;
    let real = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut known = BTreeSet::new();
    for run in groups.iter().flat_map(|group| &group.runs) {
        if !known.insert(real(&run.path)) {
            return Err(ReportError::Twice(run.path.clone()));
        }
    }
    comparable(&groups)?;
    Ok(named(groups))
}

fn comparable(groups: &[Group]) -> Result<(), ReportError> {
    let sense = |group: &Group| {
        let unit = if group.unit.is_empty() { "no unit" } else { &group.unit };
        let verb = match group.direction {
            Direction::Maximize => "maximises",
            Direction::Minimize => "minimises",
        };
        format!("{verb} in {unit}")
    };
    let Some((first, others)) = groups.split_first() else { return Ok(()) };
    match others.iter().find(|other| sense(other) != sense(first)) {
        Some(other) => Err(ReportError::Incomparable {
            one: (first.path.clone(), sense(first)),
            other: (other.path.clone(), sense(other)),
        }),
        None => Ok(()),
    }
}

/// Gives each group a name of its own: the grammar's, the folder's where several share a grammar, or the path.
fn named(mut groups: Vec<Group>) -> Vec<Group> {
    let grammars: Vec<String> = groups.iter().map(|group| group.name.clone()).collect();
    let folder = |group: &Group| {
        let path = fs::canonicalize(&group.path).unwrap_or_else(|_| group.path.clone());
        path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
    };
    let folders: Vec<String> = groups.iter().map(folder).collect();
    let paths = groups.iter().map(|group| group.path.display().to_string()).collect();
    let distinct = |names: &[String]| (1..names.len()).all(|i| !names[..i].contains(&names[i]));
    let names = [grammars, folders].into_iter().find(|names| distinct(names)).unwrap_or(paths);
    for (group, name) in groups.iter_mut().zip(names) {
        group.name = name;
    }
    groups
}

fn group(path: &Path, asker: Asker, compiled: &mut Compiled) -> Result<Group, ReportError> {
    let runs: Vec<Run> = if is_series(path) {
        let series = series::series(path)?;
        // Its runs are not asked one by one: one may be about to begin.
        let asker = if asker == Asker::Anybody && is_locked(&path.join(RUNS)) { Asker::Going } else { asker };
        let mut runs = Vec::with_capacity(series.seeds.len());
        for &seed in &series.seeds {
            let run = run(&run_folder(path, seed), asker, compiled)?;
            genuine::check_seed(&run.path, &run.asked, seed)?;
            runs.push(run);
        }
        runs
    } else if run_files::is_run(path) {
        vec![run(path, asker, compiled)?]
    } else if path.is_dir() {
        return Err(ReportError::NoRun(path.to_owned()));
    } else {
        return Err(ReportError::NoFolder(path.to_owned()));
    };
    let Some(first) = runs.first() else {
        return Err(ReportError::NoSeeds(path.join(RUNS)));
    };
    genuine::check_one_grammar(runs.iter().map(|run| (run.path.as_path(), &run.asked)))?;
    let rules = first.rules.clone();
    let unit = match (&rules, runs.iter().find_map(|run| run.design.as_ref()?.as_ref().ok())) {
        (Ok(rules), _) => rules.0.objective.unit.clone(),
        (Err(_), Some(found)) => found.design.unit.clone(),
        (Err(_), None) => String::new(),
    };
    let direction = rules.as_ref().map_or_else(|_| tendency(&runs), |rules| rules.0.objective.direction);
    Ok(Group { name: first.asked.grammar.clone(), path: path.to_owned(), runs, unit, direction, rules })
}

/// What is better, as far as the bests tell.
fn tendency(runs: &[Run]) -> Direction {
    let bests = |run: &Run| run.moves.iter().filter_map(|m| m.best).collect::<Vec<_>>();
    let falls = |run: &Run| bests(run).windows(2).any(|pair| pair[1] < pair[0]);
    if runs.iter().any(falls) { Direction::Minimize } else { Direction::Maximize }
}

fn run(path: &Path, asker: Asker, compiled: &mut Compiled) -> Result<Run, ReportError> {
    if !run_files::is_run(path) {
        return Err(ReportError::NotBegun(path.to_owned()));
    }
    let asked = run_files::asked(path)?;
    let finished = run_files::finished(path)?;
    let rules = compiled.get(&run_files::frozen(path, &asked)?, &asked.sgc);
    let mut moves = moves(&path.join(EVALS), finished.is_none())?;
    if let Some(finished) = &finished {
        genuine::check_finished(path, &asked, finished)?;
    }
    let standing = match (finished, asker) {
        (Some(finished), _) => Standing::Complete(Box::new(finished)),
        (None, Asker::Going) if moves.is_empty() => Standing::Waiting,
        (None, Asker::Going) => Standing::UnderWay,
        (None, Asker::Anybody) if is_locked(&path.join(RUN)) => Standing::UnderWay,
        (None, Asker::Anybody | Asker::Gone) => Standing::Stopped,
    };
    if let Standing::Stopped = &standing
        && let Some(rows) = checkpoint::counted_rows(path)?
    {
        // What was written after the checkpoint is made again.
        moves.truncate(rows);
    }
    if let Standing::Complete(finished) = &standing
        && let Some(last) = moves.last()
        && last.best.map(f64::to_bits) != finished.value.map(f64::to_bits)
    {
        return Err(ReportError::OtherBest(path.to_owned()));
    }
    let best = path.join(BEST);
    let found = || -> Result<Found, Lost> {
        let design = SavedDesign::read_own(&best)?;
        let finished = match &standing {
            Standing::Complete(finished) => Some(&**finished),
            Standing::UnderWay | Standing::Stopped | Standing::Waiting => None,
        };
        genuine::check_run(&design, &asked, finished)?;
        let rules = compiled.get(&design.grammar, &design.sgc);
        Ok(Found { design, rules })
    };
    let design = best.exists().then(found);
    let (learning, processes) = (learning::rows(path)?, processes::read(path));
    Ok(Run { path: path.to_owned(), asked, rules, standing, moves, learning, design, processes })
}

/// Grammars that have been compiled already: runs share them.
#[derive(Default)]
struct Compiled {
    all: Vec<(Grammar, String, Rules)>,
}

impl Compiled {
    /// The rules of a grammar that a version of sgc froze.
    fn get(&mut self, grammar: &Grammar, sgc: &str) -> Rules {
        if let Some((_, _, known)) = self.all.iter().find(|(known, by, _)| known == grammar && by == sgc) {
            return known.clone();
        }
        let rules = grammar.compile_with_sources(sgc).map(Rc::new).map_err(Rc::new);
        self.all.push((grammar.clone(), sgc.to_owned(), rules.clone()));
        rules
    }
}
