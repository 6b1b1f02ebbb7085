//! Scripts that have a cluster do the runs of a study: Slurm's arrays, or HyperQueue's.
//!
//! A submission is a folder `submissions/N` in the study: the list of its runs, and a script. Task K of it does the runs K, K + 1, ... of
//! its share, one after the other, and no two tasks share a run. What a task has begun and not ended goes on from its checkpoint when the task is
//! started again. There is no scheduler of our own: who does what and when is the engine's.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use super::folder::{Run, Study};
use super::standing::{Standing, standing};
use super::{StudyError, shell_word};
use crate::results::FileError;
use crate::results::whole::{entries, read, write_whole};

const SUBMISSIONS: &str = "submissions";
/// The names of the runs of a submission, a line each.
const LIST: &str = "runs.txt";
/// A task is told to stop so long before its time is over, s: a checkpoint takes less than a second.
const WARNING: u32 = 60;

/// Who does the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Slurm: one array job.
    Slurm,
    /// HyperQueue: one task array.
    Hq,
}

impl Engine {
    /// The engine of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [("slurm", Self::Slurm), ("hq", Self::Hq)]
            .into_iter()
            .find(|(own, _)| *own == name)
            .map(|(_, engine)| engine)
    }

    /// The program that takes a script.
    #[must_use]
    pub fn program(self) -> &'static str {
        match self {
            Self::Slurm => "sbatch",
            Self::Hq => "hq",
        }
    }

    /// The words that hand a script over.
    #[must_use]
    pub fn command(self, script: &Path) -> Vec<String> {
        let script = script.display().to_string();
        match self {
            Self::Slurm => vec!["sbatch".to_owned(), script],
            Self::Hq => vec!["hq".to_owned(), "submit".to_owned(), script],
        }
    }

    /// The variable that tells a task its number.
    fn task(self) -> &'static str {
        match self {
            Self::Slurm => "SLURM_ARRAY_TASK_ID",
            Self::Hq => "HQ_TASK_ID",
        }
    }

    fn script(self) -> &'static str {
        match self {
            Self::Slurm => "slurm.sh",
            Self::Hq => "hq.sh",
        }
    }
}

/// How the runs of a study are handed over.
#[derive(Clone, Debug)]
pub struct Submission {
    /// To whom.
    pub engine: Engine,
    /// Runs that a task does, one after the other.
    pub runs_per_task: usize,
    /// Threads of each.
    pub threads: usize,
    /// The limit of a task's time, in minutes; none is the engine's own.
    pub minutes: Option<u32>,
    /// Most tasks at once.
    pub at_once: Option<usize>,
    /// Lines that the script has before it starts sgc: modules, containers.
    pub lines: Vec<String>,
    /// Further options of the engine, such as `--partition=short`.
    pub options: Vec<String>,
    /// The program.
    pub sgc: PathBuf,
}

/// A submission that was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// Its script.
    pub script: PathBuf,
    /// How many runs are in it.
    pub runs: usize,
    /// How many tasks do them.
    pub tasks: usize,
}

/// The runs that are to be done: not those that are complete, or failed, or that a process of this or another machine holds.
#[must_use]
pub fn to_do(study: &Study) -> Vec<Run> {
    study
        .runs()
        .filter(|run| matches!(standing(study, *run), Standing::Waiting | Standing::Stopped))
        .collect()
}

impl Submission {
    /// Writes the list and the script of the runs that are to be done; none if nothing is.
    ///
    /// # Errors
    ///
    /// A file cannot be written.
    pub fn write(&self, study: &Study) -> Result<Option<Written>, StudyError> {
        let runs = to_do(study);
        if runs.is_empty() {
            return Ok(None);
        }
        let all = fs::canonicalize(study.path()).map_err(FileError::read(study.path()))?;
        if all.to_string_lossy().contains(|c: char| c.is_control() || c == '"') {
            return Err(StudyError::NoScript { path: all });
        }
        let tasks = runs.len().div_ceil(self.runs_per_task.max(1));
        let list: String = runs.iter().map(|run| study.name(*run) + "\n").collect();
        let (number, folder) = next(&all)?;
        write_whole(&folder.join(LIST), &list)?;
        let script = folder.join(self.engine.script());
        write_whole(&script, &self.text(&all, number, tasks))?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // A script that cannot be made executable can still be handed over.
            let _ = fs::set_permissions(&script, fs::Permissions::from_mode(0o755));
        }
        Ok(Some(Written { script, runs: runs.len(), tasks }))
    }

    /// The script.
    fn text(&self, study: &Path, number: usize, tasks: usize) -> String {
        let folder = study.join(SUBMISSIONS).join(number.to_string());
        let name = study.file_name().unwrap_or_default().to_string_lossy();
        let mut text = String::from("#!/bin/bash\n");
        let directive = if self.engine == Engine::Slurm { "#SBATCH" } else { "#HQ" };
        // Writing to a String never fails.
        let mut add = |option: &str| {
            let _ = writeln!(text, "{directive} {option}");
        };
        // In names of logs `%` is for the number of the task, and a space ends a word.
        let log = |file: &str| format!("\"{}/{file}\"", folder.display().to_string().replace('%', "%%"));
        match self.engine {
            Engine::Slurm => {
                add(&format!("--job-name=\"{name}\""));
                let limit = self.at_once.map_or(String::new(), |most| format!("%{most}"));
                add(&format!("--array=0-{}{limit}", tasks - 1));
                add(&format!("--cpus-per-task={}", self.threads));
                if let Some(minutes) = self.minutes {
                    add(&format!("--time={minutes}"));
                }
                add(&format!("--signal=B:USR1@{WARNING}"));
                add("--requeue");
                add("--open-mode=append");
                add(&format!("--output={}", log("task-%a.log")));
            }
            Engine::Hq => {
                add(&format!("--name=\"{name}\""));
                add(&format!("--array=0-{}", tasks - 1));
                add(&format!("--cpus={}", self.threads));
                if let Some(minutes) = self.minutes {
                    add(&format!("--time-request={minutes}m"));
                }
                add(&format!("--stdout={}", log("task-%{TASK_ID}.log")));
                add(&format!("--stderr={}", log("task-%{TASK_ID}.log")));
            }
        }
        for option in &self.options {
            add(option);
        }
        // Directives behind a command are not read. A line that fails ends the task: what it was to load is not there.
        let (directives, lines): (Vec<&String>, Vec<&String>) =
            self.lines.iter().partition(|line| line.trim_start().starts_with(directive));
        let lines = match lines.is_empty() {
            true => lines.into_iter().map(String::as_str).collect(),
            false => [
                &["set -eo pipefail"],
                lines.into_iter().map(String::as_str).collect::<Vec<_>>().as_slice(),
                &["set +eo pipefail"],
            ]
            .concat(),
        };
        for line in directives.into_iter().map(String::as_str).chain(lines) {
            text.push_str(line);
            text.push('\n');
        }
        let [sgc, study] = [self.sgc.as_path(), study].map(shell_word);
        let limit = match (self.engine, self.minutes) {
            // Slurm sends a signal; here the program looks at the time by itself.
            (Engine::Hq, Some(minutes)) => {
                format!(" --time {}s", (minutes * 60).saturating_sub(WARNING).max(1))
            }
            _ => String::new(),
        };
        let task = self.engine.task();
        let work = format!(
            "{sgc} study work {study} --submission {number} --task \"${task}\" --runs-per-task {} --jobs {}{limit}",
            self.runs_per_task.max(1),
            self.threads
        );
        let _ = match self.engine {
            // The shell hears that the time is over, has the worker stop, and the task queued again; who cancels a task sends SIGTERM.
            Engine::Slurm => write!(
                text,
                "{work} &\nworker=$!\nover=\ntrap 'over=1; kill -TERM $worker' USR1\ntrap 'kill -TERM $worker' TERM\nwait $worker\ncode=$?\n\
                 # A signal ends the first wait, not the worker.\nwhile kill -0 $worker 2>/dev/null; do wait $worker; code=$?; done\n\
                 if [ $code = 75 ] && [ -n \"$over\" ]; then\n  scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\" || exit 75\nfi\nexit $code\n"
            ),
            Engine::Hq => writeln!(text, "exec {work}"),
        };
        text
    }
}

/// The number and the folder of the next submission.
fn next(study: &Path) -> Result<(usize, PathBuf), StudyError> {
    let all = study.join(SUBMISSIONS);
    fs::create_dir_all(&all).map_err(FileError::write(&all))?;
    let taken = entries(&all).map_err(FileError::read(&all))?;
    let mut number =
        taken.iter().filter_map(|name| name.parse::<usize>().ok()).max().map_or(1, |last| last + 1);
    loop {
        let folder = all.join(number.to_string());
        match fs::create_dir(&folder) {
            Ok(()) => return Ok((number, folder)),
            // Somebody else was faster.
            Err(why) if why.kind() == std::io::ErrorKind::AlreadyExists => number += 1,
            Err(why) => return Err(FileError::write(&folder)(why).into()),
        }
    }
}

/// The earlier submissions that have runs which are to be done, too: their tasks may still wait or run.
#[must_use]
pub fn earlier(study: &Study) -> Vec<String> {
    let open: Vec<String> = to_do(study).into_iter().map(|run| study.name(run)).collect();
    let all = study.path().join(SUBMISSIONS);
    let mut found = entries(&all).unwrap_or_default();
    found.retain(|number| {
        let list = read(&all.join(number).join(LIST)).unwrap_or_default();
        list.lines().any(|name| open.iter().any(|own| own == name))
    });
    found.sort_by_key(|number| number.parse::<usize>().unwrap_or(usize::MAX));
    found
}

/// The runs of one task of a submission.
///
/// # Errors
///
/// There is no such submission or task, or its list names a run that the study does not have.
pub fn share(
    study: &Study,
    submission: usize,
    task: usize,
    runs_per_task: usize,
) -> Result<Vec<Run>, StudyError> {
    let list = study.path().join(SUBMISSIONS).join(submission.to_string()).join(LIST);
    let text = read(&list)?;
    let all = text.lines().count();
    if task.saturating_mul(runs_per_task) >= all {
        let last = all.div_ceil(runs_per_task.max(1)).saturating_sub(1);
        return Err(StudyError::Wrong {
            path: list,
            why: format!(
                "there is no task {task}: {all} runs, {runs_per_task} for each task, make the tasks 0 to {last}"
            ),
        });
    }
    let own = text.lines().skip(task.saturating_mul(runs_per_task)).take(runs_per_task);
    own.map(|name| {
        study.named(name).ok_or_else(|| StudyError::Wrong {
            path: list.clone(),
            why: format!("the study has no run {name} any more: its file was changed; submit again"),
        })
    })
    .collect()
}
