//! `sgc resume`: goes on with a run that was stopped.

use crate::results::genuine;
use crate::results::place;
use crate::results::run_files;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use super::live::Live;
use super::output::{self, Fault};
use super::session::Session;
use super::several::Several;
use super::work::{Work, duration};
use super::{exit, interrupt};
use crate::results::folder::{self, RunFolder};
use crate::results::leftovers;
use crate::results::series::SeriesFolder;
use crate::search::Jobs;

/// Continue a run that was stopped or killed, from its last checkpoint
///
/// The result is the same as that of an uninterrupted run, bit for bit, with any number of threads.
#[derive(Args)]
pub(super) struct Resume {
    /// The run folder, or the folder of several runs; sgc then continues those that are not complete
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// End after this many simulated motions in all, or a few more: what has begun is finished. With 0, only the grammar's schedule ends the run
    /// [default: as before]
    #[arg(long, value_name = "N")]
    max_evals: Option<u64>,
    /// Stop again after this time, such as 90s, 30m or 2h [default: no limit]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Option<(String, Duration)>,
    #[command(flatten)]
    work: Work,
}

impl Resume {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let flag = interrupt::listen();
        let deadline = self.time.as_ref().map(|(_, time)| Instant::now() + *time);
        let path = &self.folder;
        let finished = if run_files::is_run(path) { run_files::finished(path) } else { Ok(None) };
        if let Some(finished) = finished.map_err(Fault::usage)? {
            let complete = format!("the run in {} is complete", path.display());
            if self.max_evals.is_some() {
                return Err(Fault::usage(format!(
                    "{complete}; for a longer run, begin anew with: sgc run --max-evals"
                )));
            }
            let asked = run_files::asked(path).map_err(Fault::usage)?;
            genuine::check_finished(path, &asked, &finished).map_err(Fault::usage)?;
            run_files::frozen(path, &asked).map_err(Fault::usage)?;
            folder::clear(path);
            leftovers::clear(path, leftovers::replaces(&asked.command));
            output::note(&format!("{complete}: nothing is left to do"));
            return Ok(exit::DONE);
        }
        let max_evals = self.max_evals.map(|max| Some(max).filter(|max| *max > 0));
        if place::is_series(path) {
            let folder = SeriesFolder::open(path).map_err(Fault::usage)?;
            return Several { folder, work: self.work, max_evals, deadline, flag }.go();
        }
        let mut run = RunFolder::reopen(path).map_err(Fault::usage)?;
        if let Some(max) = max_evals {
            run.end_after(max);
        }
        let live = Live::begin(&self.work, run.folder.path());
        let jobs = Jobs::new(self.work.jobs());
        let session = Session { run, work: self.work, jobs, deadline, told: true, live: live.as_ref() };
        let ended = session.go(flag);
        if let Some(live) = live {
            live.end();
        }
        ended?.tell()
    }
}
