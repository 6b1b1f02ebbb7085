//! How long a run was worked on, `processes.csv`: a row for each process that went on with it.
//!
//! The one file of a run folder that a clock is in: two runs that are the same in all else differ here.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::FileError;
use super::whole::{self, write_own};

/// Its name in the run folder.
pub(super) const PROCESSES: &str = "processes.csv";
/// The same in runs of versions before 0.3: it is read where the other is not there.
pub(super) const BEFORE: &str = "sittings.csv";
const COLUMNS: &str = "begin,end,seconds,threads\n";

/// One process's work on a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Process {
    /// Evaluations that were spent when it began.
    pub begin: u64,
    /// Evaluations that were spent when it ended, or when this was last written.
    pub end: u64,
    /// How long it took in s, cross-checks left out.
    pub seconds: f64,
    /// With how many threads.
    pub threads: usize,
}

/// The process that goes on now, and the rows of those before it.
#[derive(Debug)]
pub struct Processes {
    path: PathBuf,
    before: String,
    begin: u64,
    threads: usize,
    started: Instant,
}

impl Processes {
    /// Begins a process in a run folder, with so many evaluations spent already. Nothing is written yet.
    #[must_use]
    pub fn begin(folder: &Path, spent: u64, threads: usize) -> Self {
        let path = folder.join(PROCESSES);
        let before = read_text(folder).unwrap_or_default();
        // Nothing else depends on this file: one that makes no sense is begun anew.
        let before =
            if before.starts_with(COLUMNS) && before.ends_with('\n') { before } else { COLUMNS.to_owned() };
        Self { path, before, begin: spent, threads, started: Instant::now() }
    }

    /// Writes how far the process is; call it after the checkpoint, so that none is counted twice.
    ///
    /// # Errors
    ///
    /// A sentence with the system's reason.
    pub fn note(&self, spent: u64) -> Result<(), FileError> {
        let seconds = self.started.elapsed().as_secs_f64();
        let Self { path, before, begin, threads, .. } = self;
        write_own(path, &format!("{before}{begin},{spent},{seconds:.3},{threads}\n"))
    }
}

/// The processes of a run; none if it has no such file, or one that makes no sense.
#[must_use]
pub fn read(folder: &Path) -> Option<Vec<Process>> {
    let text = read_text(folder)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let processes: Vec<Process> = reader.deserialize().collect::<Result<_, _>>().ok()?;
    let sound = |s: &Process| s.end >= s.begin && s.seconds >= 0.0 && s.seconds.is_finite();
    (!processes.is_empty() && processes.iter().all(sound)).then_some(processes)
}

/// The text of the file, under its name or the one that it had.
fn read_text(folder: &Path) -> Option<String> {
    [PROCESSES, BEFORE].iter().find_map(|name| whole::read(&folder.join(name)).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_of_an_earlier_version_go_on_under_the_new_name() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(BEFORE), "begin,end,seconds,threads\n0,30,2.5,2\n").unwrap();
        assert_eq!(read(folder.path()).unwrap().len(), 1);
        Processes::begin(folder.path(), 25, 1).note(40).unwrap();
        let ends: Vec<_> = read(folder.path()).unwrap().iter().map(|p| (p.begin, p.end)).collect();
        assert_eq!(ends, [(0, 30), (25, 40)]);
    }

    #[test]
    fn a_process_replaces_its_own_row_and_keeps_those_before() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(read(folder.path()), None);
        let first = Processes::begin(folder.path(), 0, 2);
        assert_eq!(read(folder.path()), None, "nothing is written yet");
        first.note(10).unwrap();
        first.note(30).unwrap();
        let second = Processes::begin(folder.path(), 25, 1);
        second.note(40).unwrap();
        let processes = read(folder.path()).unwrap();
        let ends: Vec<_> = processes.iter().map(|s| (s.begin, s.end, s.threads)).collect();
        assert_eq!(ends, [(0, 30, 2), (25, 40, 1)]);
    }

    #[test]
    fn what_makes_no_sense_is_unknown_and_begun_anew() {
        let folder = tempfile::tempdir().unwrap();
        for text in ["", COLUMNS, "begin,end\n1,2\n", "begin,end,seconds,threads\n9,2,1.0,1\n"] {
            std::fs::write(folder.path().join(PROCESSES), text).unwrap();
            assert_eq!(read(folder.path()), None, "{text}");
        }
        std::fs::write(folder.path().join(PROCESSES), "begin,end,seconds,threads\n0,2,1.0").unwrap();
        Processes::begin(folder.path(), 2, 1).note(3).unwrap();
        assert_eq!(read(folder.path()).unwrap().len(), 1);
    }
}
