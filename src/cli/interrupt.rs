//! Ctrl-C, SIGTERM and the loss of the terminal (SIGHUP): the first asks to stop, another leaves at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::exit;

static STOP: AtomicBool = AtomicBool::new(false);
/// Whether there is something on the disk to go on from.
static SAVED: AtomicBool = AtomicBool::new(false);
/// A terminal that is closed may send several signals: those that come so soon are one.
const ONE_EVENT: Duration = Duration::from_millis(500);

/// Sets the handler, and gives the flag that it sets.
pub(super) fn listen() -> &'static AtomicBool {
    let mut first: Option<Instant> = None;
    // Where no handler can be set, a signal ends the program at once; what was saved stays.
    let _ = ctrlc::set_handler(move || {
        STOP.store(true, Ordering::SeqCst);
        match first {
            None => first = Some(Instant::now()),
            Some(first) if first.elapsed() < ONE_EVENT => {}
            Some(_) => {
                let code = if SAVED.load(Ordering::SeqCst) { exit::STOPPED } else { exit::INTERRUPTED };
                std::process::exit(i32::from(code));
            }
        }
    });
    &STOP
}

/// Notes that from now on a run can be gone on with.
pub(super) fn saved() {
    SAVED.store(true, Ordering::SeqCst);
}
