//! `sgc study submit`: hands the runs of a study over to a cluster.

use std::path::PathBuf;
use std::process::Command;

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::{Place, begin};
use crate::cli::exit;
use crate::cli::output::{self, Fault};
use crate::study::folder::Study;
use crate::study::submit::{Engine, Submission, earlier, to_do};

/// So many tasks at most, unless it is said how many runs each does: Slurm's own limit is 1001.
const MOST_TASKS: usize = 1000;

/// Write and print a script that lets Slurm or HyperQueue do the runs that are not complete; with --go, submit it
///
/// The tasks share only the folder of the study, which must be on a file system that every node can reach. If a
/// task was killed or ran out of time, submit again: only the runs that are not complete are done.
#[derive(Args)]
pub(super) struct Submit {
    /// The study: its file, or its folder
    #[arg(value_name = "FILE|DIR")]
    study: PathBuf,
    #[command(flatten)]
    place: Place,
    /// The engine
    #[arg(long, value_name = "ENGINE", value_parser = PossibleValuesParser::new(["slurm", "hq"]))]
    to: String,
    /// Submit the script
    #[arg(long)]
    go: bool,
    /// Runs per task [default: as few as make at most 1000 tasks]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    runs_per_task: Option<u32>,
    /// Cores for each task, which is also the number of its runs at a time
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// The time limit of each task in minutes, 2 or more [default: the engine's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    minutes: Option<u32>,
    /// The greatest number of tasks that run at the same time (Slurm)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    at_once: Option<u32>,
    /// A line for the script, before it starts sgc, such as "module load sgc"; if it fails, so does the task. May be given several times
    #[arg(long, value_name = "LINE")]
    line: Vec<String>,
    /// A further option of the engine, such as "--partition=short"; may be given several times
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    option: Vec<String>,
    /// The program that the nodes run [default: this one]
    #[arg(long, value_name = "PATH")]
    sgc: Option<PathBuf>,
}

impl Submit {
    pub(super) fn run(self) -> Result<u8, Fault> {
        if let Some(bad) = self.option.iter().find(|option| !option.starts_with('-')) {
            return Err(Fault::usage(format!(
                "`--option {bad}` lacks a leading `-`: write `--option=--{bad}`"
            )));
        }
        if self.at_once.is_some() && self.to == "hq" {
            return Err(Fault::usage(
                "--at-once is for Slurm; HyperQueue runs as many tasks as its workers have room for",
            ));
        }
        if let Some(sgc) = self.sgc.as_ref().filter(|sgc| !sgc.exists()) {
            output::note(&format!(
                "warning: there is no {} on this machine; every node must have it",
                sgc.display()
            ));
        }
        let engine = Engine::named(&self.to).ok_or_else(|| Fault::usage("--to must be slurm or hq"))?;
        let study = match self.study.is_dir() {
            true => Study::open(&self.study).map_err(Fault::usage)?,
            false => begin::begin(&self.study, &self.place)?,
        };
        let earlier = earlier(&study);
        if let Some(last) = earlier.last() {
            output::note(&format!(
                "submission {last} contains some of these runs, too. If you submitted it and its tasks still wait or run, cancel them first: no run is done \
                 twice, but tasks may find nothing to do"
            ));
        }
        let open = to_do(&study).len();
        let few = open.div_ceil(MOST_TASKS).max(1);
        let sgc = match self.sgc {
            Some(sgc) => sgc,
            None => std::env::current_exe().map_err(|why| {
                Fault::usage(format!("cannot find the program sgc: {why}; name it with --sgc"))
            })?,
        };
        let submission = Submission {
            engine,
            runs_per_task: self.runs_per_task.map_or(few, |n| n as usize),
            threads: usize::from(self.threads),
            minutes: self.minutes,
            at_once: self.at_once.map(|n| n as usize),
            lines: self.line,
            options: self.option,
            sgc,
        };
        let Some(written) = submission.write(&study).map_err(Fault::usage)? else {
            output::note("there is nothing to submit: no run waits or was stopped");
            return Ok(exit::DONE);
        };
        let command = engine.command(&written.script);
        let shown = command.iter().map(|word| output::typed(word.as_ref())).collect::<Vec<_>>().join(" ");
        output::note(&format!(
            "{} in {}: {}",
            output::counted(written.runs, "run"),
            output::counted(written.tasks, "task"),
            written.script.display()
        ));
        if !self.go {
            let text = std::fs::read_to_string(&written.script).unwrap_or_default();
            output::data(&text)?;
            output::note(&format!("to submit it: {shown}"));
            return Ok(exit::DONE);
        }
        let done = Command::new(&command[0]).args(&command[1..]).status();
        match done {
            Ok(status) if status.success() => Ok(exit::DONE),
            Ok(status) => Err(Fault::usage(format!("`{shown}` ended with {status}; the script is kept"))),
            Err(why) => Err(Fault::usage(format!(
                "cannot run `{shown}`: {why}; the script is kept: submit it on a machine that has {}",
                engine.program()
            ))),
        }
    }
}
