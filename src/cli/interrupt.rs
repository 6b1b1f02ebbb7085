//! Ctrl-C, SIGTERM and the loss of the terminal (SIGHUP): the first asks to stop, another leaves at once.
//!
//! A search asks often whether it is to stop, but not everywhere: one expression, one move of the rules or one step of a
//! large lattice may take long. Where nobody has heard a signal within a second, the process leaves by itself. What is
//! on the disk is whole at every moment, so nothing is lost but the work since the last checkpoint. The end of `--time` is heard
//! in the same way.

use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::{exit, output};
use crate::results::whole::abandon;

static STOP: AtomicBool = AtomicBool::new(false);
/// The command that goes on with what is on the disk, once something is.
static SAVED: OnceLock<String> = OnceLock::new();
/// What is said where nothing was saved, if that is not the point.
static UNDONE: OnceLock<&'static str> = OnceLock::new();
/// How much is under way that can be cut at any moment.
static CUTTABLE: AtomicUsize = AtomicUsize::new(0);
/// A terminal that is closed may send several signals: those that come so soon are one.
const ONE_EVENT: Duration = Duration::from_millis(500);
/// How long a signal may stay unheard.
const PATIENCE: Duration = Duration::from_millis(900);
/// How often it is asked then whether there is anything to cut.
const AGAIN: Duration = Duration::from_millis(50);

/// Sets the handler, and gives the flag that it sets.
pub(super) fn listen() -> &'static AtomicBool {
    let mut first: Option<Instant> = None;
    // Where no handler can be set, a signal ends the program at once; what was saved stays.
    let _ = ctrlc::set_handler(move || {
        STOP.store(true, Ordering::SeqCst);
        match first {
            None => {
                first = Some(Instant::now());
                std::thread::spawn(cut_what_hears_nothing);
            }
            Some(first) if first.elapsed() < ONE_EVENT => {}
            Some(_) => leave(),
        }
    });
    &STOP
}

/// Cuts what does not hear that the time is up, as it does with signals.
pub(super) fn cut_after(deadline: Instant) {
    std::thread::spawn(move || {
        std::thread::sleep(deadline.saturating_duration_since(Instant::now()));
        cut_what_hears_nothing();
    });
}

fn cut_what_hears_nothing() {
    std::thread::sleep(PATIENCE);
    loop {
        if CUTTABLE.load(Ordering::SeqCst) > 0 {
            leave();
        }
        std::thread::sleep(AGAIN);
    }
}

/// Lets a signal end the process at once: for commands that can be given again. Files are there whole or not at all.
pub(super) fn end_at_once() {
    // Where no handler can be set, the system ends the process, and may leave a file that was begun.
    let _ = ctrlc::set_handler(|| {
        abandon();
        std::process::exit(i32::from(exit::INTERRUPTED));
    });
}

fn leave() -> ! {
    let is_back = abandon();
    let code = match SAVED.get() {
        Some(command) => {
            output::note(&format!(
                "stopped during a long calculation; go on from the last checkpoint with: {command}"
            ));
            exit::STOPPED
        }
        None => {
            let older = if is_back { "; the older run is back" } else { "" };
            let undone = UNDONE.get().unwrap_or(&"stopped during a long calculation; nothing was saved");
            output::note(&format!("{undone}{older}"));
            exit::INTERRUPTED
        }
    };
    std::process::exit(i32::from(code))
}

/// Notes what to say if a signal ends this command before it has done anything.
pub(super) fn undone(told: &'static str) {
    UNDONE.get_or_init(|| told);
}

/// Notes that from now on a run, or several, can be gone on with.
pub(super) fn saved(run: &Path) {
    goes_on(&format!("sgc resume {}", output::typed(run)));
}

/// Notes which command goes on with what is on the disk; the first that is noted counts.
pub(super) fn goes_on(command: &str) {
    SAVED.get_or_init(|| command.to_owned());
}

/// Work that can be cut at any moment: while one of these lives, a signal that nobody hears ends the process.
pub(super) struct Cuttable(());

impl Cuttable {
    pub(super) fn begin() -> Self {
        CUTTABLE.fetch_add(1, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Cuttable {
    fn drop(&mut self) {
        CUTTABLE.fetch_sub(1, Ordering::SeqCst);
    }
}
