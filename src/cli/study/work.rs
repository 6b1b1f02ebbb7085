//! `sgc study work`: one task of a submission. Scripts call it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use super::Threads;
use super::go::Going;
use crate::cli::output::Fault;
use crate::cli::work::duration;
use crate::cli::{interrupt, output};
use crate::study::folder::Study;
use crate::study::submit::share;

/// Do the runs of one task of a submission; the scripts of `sgc study submit` call this
#[derive(Args)]
pub(super) struct Task {
    /// The folder of the study
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The number of the submission
    #[arg(long, value_name = "N")]
    submission: usize,
    /// The number of the task, from 0
    #[arg(long, value_name = "K")]
    task: usize,
    /// Runs per task
    #[arg(long, value_name = "N", default_value = "1")]
    runs_per_task: usize,
    /// Stop after this time, such as 90s, 30m or 2h, with checkpoints
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Option<(String, Duration)>,
    #[command(flatten)]
    going: Threads,
}

impl Task {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let flag = interrupt::listen();
        let deadline = self.time.as_ref().map(|(_, time)| Instant::now() + *time);
        let study = Study::open(&self.folder).map_err(Fault::usage)?;
        let folder = output::typed(&self.folder);
        let again = format!(
            "start its task again to go on; or submit the runs that are not complete: sgc study submit {folder} --to ENGINE"
        );
        interrupt::goes_on(&format!("sgc study submit {folder} --to ENGINE"));
        let runs = share(&study, self.submission, self.task, self.runs_per_task).map_err(Fault::usage)?;
        let going = Going { study: &study, work: self.going.work(), quiet: self.going.quiet, deadline, flag };
        going.go(runs)?.tell(&again)
    }
}
