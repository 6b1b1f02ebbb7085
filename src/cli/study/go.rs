//! Does runs of a study that are not complete, as far as there are threads.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::cli::output::{self, Fault};
use crate::cli::progress::span;
use crate::cli::session::Session;
use crate::cli::side_by_side::side_by_side;
use crate::cli::work::Work;
use crate::cli::{derive, exit};
use crate::results::folder::{Reopened, RunFolder};
use crate::results::place::foreign_in;
use crate::results::run_files::{has_result, is_run};
use crate::results::saved::Grammar;
use crate::results::whole::write_whole;
use crate::results::{FileError, Unfit, describe};
use crate::search::{Jobs, State};
use crate::simulate::Stop;
use crate::study::folder::{Run, Study};
use crate::study::shell_word;
use crate::study::standing::{Standing, standing};
use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;

/// Compiled cells that are kept: the runs of a cell are seldom far from each other.
const KEPT: usize = 16;

/// What a process does of a study.
pub(super) struct Going<'a> {
    pub(super) study: &'a Study,
    pub(super) work: Work,
    /// Whether nobody wants to hear of each run.
    pub(super) quiet: bool,
    pub(super) deadline: Option<Instant>,
    pub(super) flag: &'a AtomicBool,
}

/// How it ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Done {
    is_early: bool,
    /// Runs that another process holds.
    elsewhere: usize,
    failed: usize,
    /// Those of them whose reason could not be written down.
    unnoted: usize,
    /// Whether any of them was by a bug in sgc.
    worst: u8,
}

/// How one run ended here.
enum Ended {
    /// With its value, in words.
    Complete(String),
    /// Before its end: it can be gone on with.
    Early,
    /// It is another process's.
    Elsewhere,
}

/// A cell with what its runs begin with.
type Compiled = Arc<(Grammar, RuleSet, SourceMap, State)>;

impl Going<'_> {
    /// Does these runs, but for those that are complete, failed, or held by another process.
    pub(super) fn go(&self, runs: Vec<Run>) -> Result<Done, Fault> {
        let stop = Stop::new(self.flag, self.deadline);
        let all = runs.len();
        let mut done = Done::default();
        let mut complete = 0;
        let mut elsewhere = Vec::new();
        let mut waiting = std::collections::VecDeque::new();
        for run in runs {
            match standing(self.study, run) {
                Standing::Complete => complete += 1,
                Standing::Failed => done.failed += 1,
                Standing::UnderWay => elsewhere.push(run),
                Standing::Stopped | Standing::Waiting => waiting.push_back(run),
            }
        }
        let (begun, before) = (Instant::now(), complete);
        let kept = Mutex::new(BTreeMap::new());
        side_by_side(
            self.work.jobs(),
            stop,
            &mut waiting,
            |run, jobs| self.one(*run, jobs, &kept),
            |run, outcome| {
                let name = self.study.name(run);
                match outcome {
                    Ok(Ended::Complete(value)) => {
                        complete += 1;
                        if !self.quiet {
                            let here = (complete - before) as f64;
                            let left = begun.elapsed().as_secs_f64() / here * (all - complete) as f64;
                            let left = match all - complete {
                                0 => String::new(),
                                _ => format!(", about {} left", span(Duration::from_secs_f64(left.min(1e9)))),
                            };
                            output::note(&format!("{complete} of {all}{left}: {name}: {value}"));
                        }
                    }
                    Ok(Ended::Early) => done.is_early = true,
                    Ok(Ended::Elsewhere) => elsewhere.push(run),
                    Err(fault) => {
                        done.failed += 1;
                        done.unnoted += usize::from(!self.study.note_of(run).exists());
                        done.worst = done.worst.max(fault.code);
                        output::note(&format!("{name} failed: {}", fault.message));
                    }
                }
            },
        );
        // Some of these may have come to their end meanwhile.
        elsewhere.retain(|run| standing(self.study, *run) != Standing::Complete);
        done.elsewhere = elsewhere.len();
        done.is_early |= !waiting.is_empty();
        Ok(done)
    }

    fn one(&self, run: Run, jobs: Jobs, kept: &Mutex<BTreeMap<usize, Compiled>>) -> Result<Ended, Fault> {
        // A run of a study is begun anew by the study.
        let again = format!("begin it anew with sgc study retry {}", shell_word(self.study.path()));
        let ended = self.session(run, jobs, kept).map_err(|fault| Fault {
            message: fault.message.replace("begin anew with sgc run --force", &again),
            ..fault
        });
        if let Err(fault) = &ended {
            // It is left alone until somebody has mended the cause. Where even this cannot be written, it is tried again.
            let note = self.study.note_of(run);
            let _ = note.parent().map(std::fs::create_dir_all);
            let _ = write_whole(&note, &format!("{}\n", fault.message));
        }
        ended
    }

    fn session(&self, run: Run, jobs: Jobs, kept: &Mutex<BTreeMap<usize, Compiled>>) -> Result<Ended, Fault> {
        let folder = self.study.folder(run);
        let opened = if is_run(&folder) { RunFolder::reopen(&folder) } else { self.create(run, kept)? };
        let run = match opened {
            Ok(run) => run,
            Err(FileError::UnderWay { .. }) => return Ok(Ended::Elsewhere),
            // Another process begins it at this moment, or somebody put something of theirs into its place.
            Err(FileError::Unfit { why: Unfit::Exists, .. }) => match foreign_in(&folder) {
                None => return Ok(Ended::Elsewhere),
                Some(foreign) => {
                    return Err(Fault::usage(format!(
                        "{} must become the folder of a run, but contains \"{foreign}\": move this elsewhere",
                        folder.display()
                    )));
                }
            },
            Err(FileError::Complete { .. }) => return Ok(Ended::Elsewhere),
            Err(other) => return Err(Fault::usage(other)),
        };
        let session =
            Session { run, work: self.work.clone(), jobs, deadline: self.deadline, told: false, live: None };
        match session.go(self.flag) {
            Ok(ended) if ended.is_early => Ok(Ended::Early),
            Ok(ended) => Ok(Ended::Complete(
                ended
                    .design
                    .map_or("nothing".to_owned(), |design| describe::quantity(design.value, &design.unit)),
            )),
            // A search that finds no robot has come to its end, too.
            Err(fault) if fault.code == exit::INPUT && has_result(&folder) => {
                Ok(Ended::Complete(fault.message))
            }
            Err(fault) => Err(fault),
        }
    }

    /// Begins a run, if nobody else has.
    fn create(
        &self,
        run: Run,
        kept: &Mutex<BTreeMap<usize, Compiled>>,
    ) -> Result<Result<Reopened, FileError>, Fault> {
        let compiled = self.compiled(run.cell, kept)?;
        let (grammar, rules, sources, state) = &*compiled;
        let asked = self.study.asked(run);
        let folder = RunFolder::create(&self.study.folder(run), false, &asked, grammar, rules, state);
        let max_evals = asked.max_evals;
        Ok(folder.map(|folder| Reopened {
            folder,
            asked,
            grammar: grammar.clone(),
            rules: rules.clone(),
            sources: sources.clone(),
            state: state.clone(),
            max_evals,
        }))
    }

    fn compiled(&self, cell: usize, kept: &Mutex<BTreeMap<usize, Compiled>>) -> Result<Compiled, Fault> {
        let known = || kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(compiled) = known().get(&cell) {
            return Ok(Arc::clone(compiled));
        }
        let (grammar, rules, sources) = self.study.compile(cell).map_err(Fault::usage)?;
        let from = self.study.cells().get(cell).and_then(|cell| cell.from.clone());
        let first = derive::start(&rules, &sources, from.as_deref())?;
        let state = State::begin_with(first, Vec::new());
        let compiled: Compiled = Arc::new((grammar, rules, sources, state));
        let mut known = known();
        if known.len() >= KEPT {
            known.pop_first();
        }
        known.insert(cell, Arc::clone(&compiled));
        Ok(compiled)
    }
}

impl Done {
    /// Tells people how it ended, and how it goes on where it was stopped; the exit code.
    pub(super) fn tell(self, again: &str) -> Result<u8, Fault> {
        if self.failed > 0 {
            let noted = self.failed - self.unnoted;
            if noted > 0 {
                output::note(&format!(
                    "{} failed: `sgc study status DIR` says why. When the cause is fixed, `sgc study retry DIR` tries it again: from its checkpoint, or from its \
                     beginning if it has none (or with --anew)",
                    output::counted(noted, "run")
                ));
            }
            if self.unnoted > 0 {
                output::note(&format!(
                    "{} failed, and sgc could not write the reason (above) into the folder: the next command tries again without `retry`",
                    output::counted(self.unnoted, "run")
                ));
            }
        }
        if self.elsewhere > 0 {
            output::note(&format!("{} under way in other processes", output::counted(self.elsewhere, "run")));
        }
        if self.is_early {
            output::note(&format!("stopped; {again}"));
            return Ok(exit::STOPPED);
        }
        Ok(match self.failed {
            // Who waits for this waits for all of the runs.
            0 if self.elsewhere > 0 => exit::STOPPED,
            0 => exit::DONE,
            _ => self.worst.max(exit::INPUT),
        })
    }
}
