//! A page that follows a run, or several, while they go on (`--live`).

use crate::results::report::ReportError;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::output;
use super::work::Work;
use crate::results::report::{Asker, FOLDER, PAGE, Reload, Report};

/// The page is written again after so long at the earliest.
const EVERY: Duration = Duration::from_secs(5);
/// And not before so many times what writing it took: less than a hundredth of the time goes into it.
const REST: u32 = 150;

/// The page of some runs.
pub(super) struct Live {
    /// The folder of the runs.
    runs: PathBuf,
    turn: Mutex<Turn>,
}

/// When it is to be written again.
struct Turn {
    next: Instant,
    /// Whether people have been told that it could not be written.
    told: bool,
}

impl Live {
    /// Follows the runs in a folder, if that is wanted.
    pub(super) fn begin(work: &Work, runs: &Path) -> Option<Self> {
        if !work.live {
            return None;
        }
        let live = Self {
            runs: runs.to_owned(),
            turn: Mutex::new(Turn { next: Instant::now() + EVERY, told: false }),
        };
        live.write();
        if !work.quiet {
            let page = live.place().join(PAGE);
            output::note(&format!("follow it in a browser: {}", page.display()));
        }
        Some(live)
    }

    fn place(&self) -> PathBuf {
        self.runs.join(FOLDER)
    }

    /// Writes the page again if it is time to.
    pub(super) fn follow(&self) {
        // One of several runs at a time, and the others do not wait for it.
        if let Ok(turn) = self.turn.try_lock()
            && Instant::now() >= turn.next
        {
            drop(turn);
            self.write();
        }
    }

    fn write(&self) {
        let Ok(mut turn) = self.turn.try_lock() else { return };
        let began = Instant::now();
        let report = Report::read(std::slice::from_ref(&self.runs), Asker::Going);
        self.tell(
            report.and_then(|report| report.write_page(&self.place(), Reload::WhileRunning, false)),
            &mut turn,
        );
        turn.next = Instant::now() + EVERY.max(began.elapsed() * REST);
    }

    /// Writes the page for the last time, and the tables.
    pub(super) fn end(self) {
        if !self.runs.exists() {
            // The run found nothing, and gave its folder back.
            return;
        }
        let report = Report::read(std::slice::from_ref(&self.runs), Asker::Gone);
        let written = report.and_then(|report| report.write(&self.place(), false));
        if let Ok(mut turn) = self.turn.lock() {
            self.tell(written, &mut turn);
        }
    }

    /// Says once that there is no page: the run does not depend on it.
    fn tell(&self, written: Result<PathBuf, ReportError>, turn: &mut Turn) {
        if let Err(why) = written
            && !turn.told
        {
            turn.told = true;
            output::note(&format!("warning: the page that follows the run is not up to date: {why}"));
        }
    }
}
