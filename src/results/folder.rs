//! The run folder: what a run was asked, what it did, what it found, and how it goes on.

use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sha2::{Digest, Sha256};

use super::checkpoint::Checkpoint;
use super::edited::designs;
use super::elsewhere::{self, Tested};
use super::evals::{Evals, More};
use super::genuine;
use super::leftovers;
use super::place::check_place;
use super::processes::{self, PROCESSES};
use super::run_files::{
    Asked, BEST, CHECKPOINT, EVALS, Finished, RESULT, RUN, SOURCES, asked, finished, frozen, is_run,
};
use super::saved::{Grammar, SavedDesign, hex};
use super::verdict::kept;
use super::whole::{
    aside, check_no_link, is_same, lock, lock_again, make_folder, read, wait_for_best, wait_no_more,
    write_own, write_whole,
};
use super::{DesignError, FileError, Unfit};
use super::{archive, front, learning};
use crate::search::{Best, Outcome, Row, State};

/// A run folder that is being written. Another process cannot write it as long as this lives.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    evals: Evals,
    /// Hash of `run.toml`.
    run: String,
    /// `run.toml`, locked.
    lock: fs::File,
    /// The run that this one replaces, kept until there is a first best.
    replaced: RefCell<Option<PathBuf>>,
}

impl Reopened {
    /// Ends the run after so many evaluations, but not before it has come as far again as its table of moves says that it was: what was
    /// found since the last checkpoint is not lost.
    pub fn end_after(&mut self, evaluations: Option<u64>) {
        self.max_evals = evaluations.map(|most| most.max(self.folder.evals.reached()));
    }
}

/// A run that was stopped, read again.
#[derive(Debug)]
pub struct Reopened {
    /// Its folder, as it was at the last checkpoint.
    pub folder: RunFolder,
    /// What it was asked.
    pub asked: Asked,
    /// Its frozen texts.
    pub grammar: Grammar,
    /// What they say.
    pub rules: RuleSet,
    /// Them again, to show places in them.
    pub sources: SourceMap,
    /// Where its search stands.
    pub state: State,
    /// The bound on evaluations.
    pub max_evals: Option<u64>,
}

impl RunFolder {
    /// Makes a folder for a run that begins with a state: whole or not at all.
    ///
    /// # Errors
    ///
    /// A sentence: the folder exists and is not empty (unless `force`), or cannot be written.
    pub fn create(
        path: &Path,
        force: bool,
        asked: &Asked,
        grammar: &Grammar,
        rules: &RuleSet,
        state: &State,
    ) -> Result<Self, FileError> {
        // A link is followed: what it points to is replaced, not the link.
        let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let aside = check_place(path, force)?.then(|| aside(path));
        leftovers::clear_unfinished(path);
        let check = || check_place(path, force).map(drop);
        let fill = |path: &Path| Self::fill(path, asked, grammar, rules, state);
        let mut folder = make_folder(path, aside.as_deref(), check, fill)?;
        // A process may have been killed when it had just moved the older run away.
        let replaced = aside.or_else(|| if force { leftovers::older(path) } else { None });
        folder.path = path.to_owned();
        folder.evals.moved(path.join(EVALS));
        if let Some(older) = &replaced {
            wait_for_best(older, path);
        }
        folder.replaced = RefCell::new(replaced);
        Ok(folder)
    }

    fn fill(
        path: &Path,
        asked: &Asked,
        grammar: &Grammar,
        rules: &RuleSet,
        state: &State,
    ) -> Result<Self, FileError> {
        let text = toml::to_string(asked).map_err(FileError::write(&path.join(RUN)))?;
        write_whole(&path.join(RUN), &text)?;
        let lock = lock(&path.join(RUN))?;
        let sources = path.join(SOURCES);
        let own = || asked.sources.iter().filter(|source| !source.is_shared());
        if own().next().is_some() {
            fs::create_dir_all(&sources).map_err(FileError::write(&sources))?;
        }
        for source in own() {
            let text = grammar.sources.get(&source.name).map_or("", String::as_str);
            write_whole(&sources.join(&source.file), text)?;
        }
        let evals = Evals::create(&path.join(EVALS), More::of(rules))?;
        let folder = Self {
            path: path.to_owned(),
            evals,
            run: hex(&Sha256::digest(&text)),
            lock,
            replaced: RefCell::new(None),
        };
        folder.checkpoint(rules, state, asked.max_evals)?;
        Ok(folder)
    }

    /// Opens the folder of a run that was stopped. Nothing in it is changed before all of it is
    /// known to be as the run left it; then what was written after the last checkpoint is cut off.
    ///
    /// # Errors
    ///
    /// A sentence: there is no run, it is complete, under way, changed, damaged or of another version.
    pub fn reopen(path: &Path) -> Result<Reopened, FileError> {
        if !is_run(path) {
            let older = if path.exists() { None } else { leftovers::older(path) };
            return Err(FileError::unfit(
                path,
                older.map_or(Unfit::NoRun { file: RUN }, |older| Unfit::MovedAway { older }),
            ));
        }
        let lock = lock_again(&path.join(RUN))?;
        if finished(path)?.is_some() {
            return Err(FileError::Complete { folder: path.to_owned() });
        }
        for own in [
            archive::FOLDER,
            archive::TABLE,
            front::FOLDER,
            front::TABLE,
            BEST,
            EVALS,
            learning::LEARNING,
            CHECKPOINT,
            PROCESSES,
            processes::BEFORE,
        ] {
            check_no_link(&path.join(own))?;
        }
        let text = read(&path.join(RUN))?;
        let run = hex(&Sha256::digest(&text));
        if !path.join(CHECKPOINT).exists() {
            return Err(FileError::unfit(path, Unfit::NoCheckpoint));
        }
        let checkpoint = Checkpoint::read(&path.join(CHECKPOINT), &run)?;
        let asked = asked(path)?;
        let grammar = frozen(path, &asked)?;
        let (rules, sources) = grammar.compile_with_sources(&asked.sgc).map_err(FileError::inside(path))?;
        let state =
            checkpoint.state.restore(&rules).map_err(DesignError::Step).map_err(FileError::inside(path))?;
        let of_front: Vec<PathBuf> = state.front().map(|best| front::place(path, best)).collect();
        let is_on_front =
            |file: &PathBuf| file.parent() != Some(&*path.join(front::FOLDER)) || of_front.contains(file);
        for file in designs(path).into_iter().filter(is_on_front) {
            // The run would write its own over it.
            let of_run = |design: &SavedDesign| genuine::check_run(design, &asked, None);
            let own = SavedDesign::read_own(&file)
                .and_then(|design| of_run(&design).map_err(FileError::inside(&file)));
            own.map_err(|why| FileError::unfit(&file, Unfit::NotOwn { why: why.to_string() }))?;
        }
        let evals = Evals::reopen(&path.join(EVALS), &checkpoint.evals, More::of(&rules))?;
        leftovers::clear_within(path);
        // A process that was killed before its first best leaves the run that it was to replace: it goes
        // on waiting until there is a best.
        let waits = !path.join(BEST).exists() && leftovers::replaces(&asked.command);
        let replaced = if waits { leftovers::older(path) } else { None };
        if replaced.is_none() {
            leftovers::clear(path, leftovers::replaces(&asked.command));
        }
        if let Some(older) = &replaced {
            wait_for_best(older, path);
        }
        let replaced = RefCell::new(replaced);
        let folder = Self { path: path.to_owned(), evals, run, lock, replaced };
        let max_evals = checkpoint.max_evals;
        Ok(Reopened { folder, asked, grammar, rules, sources, state, max_evals })
    }

    /// Where the best design is.
    #[must_use]
    pub fn best_path(&self) -> PathBuf {
        self.path.join(BEST)
    }

    /// Where the folder is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether an older run waits to be given back, as there is no best yet.
    #[must_use]
    pub fn is_replacing(&self) -> bool {
        self.replaced.borrow().is_some()
    }

    /// Sees that the folder is still the one that was locked: it may have been moved, and another run begun in its place.
    ///
    /// # Errors
    ///
    /// A sentence: it is not.
    pub fn check_here(&self) -> Result<(), FileError> {
        if is_same(&self.path.join(RUN), &self.lock) {
            return Ok(());
        }
        Err(FileError::Elsewhere { folder: self.path.clone() })
    }

    /// Writes into the folder while it is the one that was locked. It can be moved at any time: where that is why a write
    /// fails, the error says so.
    fn write_here(&self, write: impl FnOnce() -> Result<(), FileError>) -> Result<(), FileError> {
        self.check_here()?;
        write().or_else(|error| self.check_here().and(Err(error)))
    }

    /// Adds a row to `evals.csv`.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn row(&mut self, row: &Row) -> Result<(), FileError> {
        self.evals.row(row)
    }

    /// Replaces the checkpoint. It and the rows that it counts are on the disk when this returns.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason; then the last checkpoint is as it was.
    pub fn checkpoint(
        &self,
        rules: &RuleSet,
        state: &State,
        max_evals: Option<u64>,
    ) -> Result<(), FileError> {
        let path = self.path.join(CHECKPOINT);
        self.write_here(|| {
            learning::write(&self.path, rules, &state.learned())?;
            let checkpoint = Checkpoint::new(&self.run, max_evals, self.evals.mark()?, state);
            let text =
                checkpoint.and_then(|checkpoint| checkpoint.text()).map_err(FileError::write(&path))?;
            write_own(&path, &text)
        })
    }

    /// Replaces the best design of a kind, and the table of all kinds.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn kept(
        &self,
        rules: &RuleSet,
        archive: &[(Vec<usize>, Best)],
        cell: &[usize],
        design: &SavedDesign,
    ) -> Result<(), FileError> {
        self.write_here(|| archive::write(&self.path, rules, archive, cell, design))
    }

    /// Which kinds of an archive have to be written again: somebody took away or changed their files.
    #[must_use]
    pub fn lost(&self, rules: &RuleSet, archive: &[(Vec<usize>, Best)]) -> Vec<usize> {
        archive::lost(&self.path, rules, archive)
    }

    /// Whether a design on the front has its file.
    #[must_use]
    pub fn has_on_front(&self, best: &Best) -> bool {
        front::is_there(&self.path, best)
    }

    /// Writes a design on the front.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn on_front(&self, best: &Best, design: &SavedDesign) -> Result<(), FileError> {
        self.write_here(|| front::write_design(&self.path, best, design))
    }

    /// Replaces the table of the front, and removes the designs that left it: those of this seed and of rules with this hash.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn front(&self, rules: &RuleSet, designs: &[Best], own: (u64, &str)) -> Result<(), FileError> {
        self.write_here(|| front::write_table(&self.path, rules, designs, own))
    }

    /// Which designs on the front have to be written again; none inside if nothing has.
    #[must_use]
    pub fn lost_of_front(&self, rules: &RuleSet, designs: &[Best]) -> Option<Vec<usize>> {
        front::lost(&self.path, rules, designs)
    }

    /// Replaces the best design.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn best(&self, design: &SavedDesign) -> Result<(), FileError> {
        self.write_here(|| {
            design.check_replaces(&self.best_path())?;
            write_own(&self.best_path(), &design.text())
        })?;
        if let Some(old) = self.replaced.borrow_mut().take() {
            wait_no_more(&old);
            // Somebody may have put something into it meanwhile: then it stays.
            leftovers::remove(&old);
            leftovers::clear(&self.path, true);
        }
        Ok(())
    }

    /// Says that the run is complete; `checked` is its best with what the cross-checks found.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn finish(
        &self,
        asked: &Asked,
        rules: &RuleSet,
        outcome: &Outcome,
        (max_evals, checked): (Option<u64>, Option<&SavedDesign>),
    ) -> Result<(), FileError> {
        let tested = checked.and_then(|design| elsewhere::tested(rules, design));
        let observed = outcome.best.as_ref().map(|best| best.observed());
        self.check_here()?;
        let finished = Finished {
            sum: None,
            evals: Some(self.evals.mark()?),
            asked: Some(asked.identity()),
            grammar: asked.grammar.clone(),
            seed: asked.seed,
            value: outcome.best.as_ref().map(|b| b.value),
            unit: rules.objective.unit.clone(),
            observed: rules
                .observed
                .iter()
                .cloned()
                .zip(observed.unwrap_or_default().iter().cloned())
                .collect(),
            evaluations: outcome.evaluations,
            moves: outcome.moves,
            invalid: outcome.tally.by_reason().map(|(why, n)| (why.to_owned(), n)).collect(),
            unstable: outcome.tally.unstable,
            checks: checked.map(|design| kept(rules, design)),
            nine_of_ten: tested.as_ref().and_then(|tested| tested.each()?.tenth),
            over_worlds: tested.as_ref().and_then(Tested::whole),
            end: outcome.end.text().to_owned(),
            max_evals,
        };
        let path = self.path.join(RESULT);
        let text = finished.text().map_err(FileError::write(&path))?;
        let learned: Vec<_> = outcome.learned.iter().map(|(task, all)| (*task, all.as_slice())).collect();
        self.write_here(|| {
            learning::write(&self.path, rules, &learned)?;
            write_own(&path, &text)
        })?;
        clear(&self.path);
        Ok(())
    }
}

/// Takes the checkpoint of a complete run away: nobody goes on from there. A process that is killed at
/// the very end leaves it.
pub fn clear(path: &Path) {
    let _ = fs::remove_file(path.join(CHECKPOINT));
}

impl Drop for RunFolder {
    /// A run that found nothing gives the folder back to the run it was to replace.
    fn drop(&mut self) {
        let Some(old) = self.replaced.borrow_mut().take() else { return };
        wait_no_more(&old);
        if self.check_here().is_ok() {
            let _ = fs::remove_dir_all(&self.path);
            let _ = fs::rename(old, &self.path);
        }
    }
}
