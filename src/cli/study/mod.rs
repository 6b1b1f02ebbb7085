//! `sgc study`: many runs that answer one question.

mod begin;
mod gather;
mod go;
mod retry;
mod status;
mod submit;
mod work;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};

use self::go::Going;
use super::output::{self, Fault};
use super::work::{Work, duration};
use super::{exit, interrupt};
use crate::study::folder;

/// Do all runs of a study: every combination of its grammars, variants and parameters, with several seeds
///
/// FILE is a TOML file; docs/studies.md says what is in it. All of it is checked before anything runs. Run
/// the same command again to continue with the runs that are not complete. At the end, and by `sgc study gather`, it writes a page
/// that says which parameter matters and by how much.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct Study {
    #[command(subcommand)]
    command: Option<Command>,
    /// The study: its file, or its folder to continue it unchanged
    #[arg(value_name = "FILE|DIR", required = true)]
    file: Option<PathBuf>,
    #[command(flatten)]
    place: Place,
    /// Check the study and print its runs; run nothing, and write nothing
    #[arg(long)]
    plan: bool,
    /// Stop after this time, such as 90s, 30m or 2h, in the same way as Ctrl-C; the same command continues the study
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Option<(String, Duration)>,
    #[command(flatten)]
    going: Threads,
}

/// Where the folder of a study is.
#[derive(Args, Clone, Debug)]
struct Place {
    /// The folder of the study [default: studies/NAME, where NAME is the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// How the work is done; the results do not depend on it.
#[derive(Args, Clone, Debug)]
struct Threads {
    /// Threads to use: one for each run, while at least as many runs as threads are left [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Save a checkpoint of each run about this often
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = "5s")]
    checkpoint: (String, Duration),
    /// Print only the result, and no progress
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    Status(status::Status),
    Gather(gather::Gather),
    Retry(retry::Retry),
    Submit(submit::Submit),
    Work(work::Task),
}

impl Threads {
    fn work(&self) -> Work {
        Work { jobs: self.jobs, checkpoint: self.checkpoint.clone(), quiet: true, live: false }
    }
}

impl Study {
    pub(super) fn run(self) -> Result<u8, Fault> {
        match self.command {
            Some(Command::Status(command)) => at_once(|| command.run()),
            Some(Command::Gather(command)) => at_once(|| command.run()),
            Some(Command::Retry(command)) => at_once(|| command.run()),
            Some(Command::Submit(command)) => at_once(|| command.run()),
            Some(Command::Work(command)) => command.run(),
            None => {
                let file = self.file.unwrap_or_default();
                if self.plan {
                    return at_once(|| {
                        let planned = begin::plan(&file, &self.place)?;
                        let study = &planned.study;
                        begin::tell(study);
                        planned.tell_change();
                        if let Some(rules) = planned.first_rules() {
                            begin::price(study, &rules, &AtomicBool::new(false));
                        }
                        let names: String = study.runs().map(|run| study.name(run) + "\n").collect();
                        output::data(&names)?;
                        Ok(exit::DONE)
                    });
                }
                let flag = interrupt::listen();
                let deadline = self.time.as_ref().map(|(_, time)| Instant::now() + *time);
                let before = interrupt::Cuttable::begin();
                let study = match file.is_dir() {
                    true => folder::Study::open(&file).map_err(Fault::usage)?,
                    false => begin::begin(&file, &self.place)?,
                };
                let again = format!("sgc study {}", output::typed(&file));
                let again = match &self.place.out {
                    Some(out) => format!("{again} --out {}", output::typed(out)),
                    None => again,
                };
                interrupt::goes_on(&again);
                drop(before);
                let quiet = self.going.quiet;
                if !quiet {
                    begin::tell(&study);
                    if let Ok((_, rules, _)) = study.compile(0) {
                        begin::price(&study, &rules, flag);
                    }
                }
                let runs = study.runs().collect();
                let going = Going { study: &study, work: self.going.work(), quiet, deadline, flag };
                let done = going.go(runs)?;
                let code = gather::gather(&study, None, false)?;
                let end = done.tell(&format!("go on with: {again}"))?;
                Ok(if end == exit::DONE { code } else { end })
            }
        }
    }
}

/// Does what a signal may end at any moment.
fn at_once(work: impl FnOnce() -> Result<u8, Fault>) -> Result<u8, Fault> {
    interrupt::end_at_once();
    work()
}
