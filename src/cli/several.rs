//! Several runs, side by side as far as there are threads.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use grammar_lang::ir::Direction;

use super::live::Live;
use super::output::{self, Fault};
use super::session::{Ended, NOTHING_FOUND, Session};
use super::side_by_side::side_by_side;
use super::work::Work;
use super::{exit, interrupt};
use crate::results::describe;
use crate::results::folder::{RunFolder, clear};
use crate::results::leftovers;
use crate::results::run_files::finished;
use crate::results::series::{SeriesFolder, table};
use crate::search::Jobs;
use crate::simulate::Stop;

/// How several runs go on.
pub(super) struct Several<'a> {
    pub(super) folder: SeriesFolder,
    pub(super) work: Work,
    /// A new bound on evaluations, if one was given; the inner one is none where there is to be no bound.
    pub(super) max_evals: Option<Option<u64>>,
    pub(super) deadline: Option<Instant>,
    pub(super) flag: &'a AtomicBool,
}

impl Several<'_> {
    /// Goes on with those that are not complete, and sums all up.
    pub(super) fn go(self) -> Result<u8, Fault> {
        let stop = Stop::new(self.flag, self.deadline);
        interrupt::saved(self.folder.path());
        let live = Live::begin(&self.work, self.folder.path());
        let mut waiting = VecDeque::new();
        for &seed in self.folder.seeds() {
            let path = self.folder.run(seed);
            match finished(&path).map_err(Fault::usage)? {
                Some(_) => clear(&path),
                None => waiting.push_back(seed),
            }
        }
        if waiting.is_empty() {
            let complete = format!("all runs in {} are complete", self.folder.path().display());
            if self.max_evals.is_some() {
                return Err(Fault::usage(format!(
                    "{complete}; for longer runs, begin anew with: sgc run --max-evals"
                )));
            }
            output::note(&complete);
        }
        let (mut is_early, mut worst) = (false, exit::DONE);
        let all = self.work.jobs();
        let one = |seed: &u64, jobs| self.one(&self.folder.run(*seed), jobs, live.as_ref());
        side_by_side(all, stop, &mut waiting, one, |seed, outcome| match outcome {
            Ok(ended) => {
                is_early |= ended.is_early;
                tell(seed, &ended);
            }
            Err(fault) => {
                worst = worst.max(fault.code);
                output::note(&format!("seed {seed}: {}", fault.message));
            }
        });
        is_early |= !waiting.is_empty();
        if let Some(live) = live {
            live.end();
        }
        let (lines, rules) = self.folder.summary().map_err(Fault::usage)?;
        let written = output::data(&table(&lines));
        let path = output::typed(self.folder.path());
        if is_early {
            output::note(&format!("stopped; go on with: sgc resume {path}"));
        } else {
            written?;
        }
        let direction = rules.map_or(Direction::Maximize, |rules| rules.objective.direction);
        let valued = lines.iter().filter_map(|line| Some((line.seed, direction.fitness(line.value?))));
        let best = valued.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        if best.is_some() {
            self.folder.settle();
        }
        for older in leftovers::left(self.folder.path()) {
            output::note(&format!("the earlier contents are kept in {}", output::typed(&older)));
        }
        if let Some((seed, _)) = best {
            if lines.iter().any(|line| line.seed == seed && line.is_still) {
                output::note(NOTHING_FOUND);
            }
            output::note(&format!("look at the best: sgc view {}", output::typed(&self.folder.run(seed))));
        }
        Ok(match worst {
            exit::USAGE.. => worst,
            _ if is_early => exit::STOPPED,
            // A seed that finds nothing is no fault as long as another does.
            _ if best.is_some() => exit::DONE,
            worst => worst,
        })
    }

    fn one(&self, path: &Path, jobs: Jobs, live: Option<&Live>) -> Result<Ended, Fault> {
        let mut run = RunFolder::reopen(path).map_err(Fault::usage)?;
        if let Some(max) = self.max_evals {
            run.end_after(max);
        }
        let work = self.work.clone();
        Session { run, work, jobs, deadline: self.deadline, told: false, live }.go(self.flag)
    }
}

fn tell(seed: u64, ended: &Ended) {
    let value = ended
        .design
        .as_ref()
        .map_or("nothing yet".to_owned(), |design| describe::quantity(design.value, &design.unit));
    let Ended { outcome, .. } = ended;
    output::note(&format!(
        "seed {seed}: {value} after {} evaluations: {}",
        outcome.evaluations,
        outcome.end.text()
    ));
}
