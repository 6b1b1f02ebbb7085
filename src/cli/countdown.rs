//! Says how far something is whose steps are counted.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use super::output;

/// How often that is said on a terminal, and elsewhere.
const ON_A_TERMINAL: Duration = Duration::from_secs(2);
const ELSEWHERE: Duration = Duration::from_secs(20);

/// Says now and then how much is done; nothing of what is done soon.
pub(super) struct Countdown {
    every: Duration,
    last: Instant,
}

impl Countdown {
    pub(super) fn begin() -> Self {
        let every = if std::io::stderr().is_terminal() { ON_A_TERMINAL } else { ELSEWHERE };
        Self { every, last: Instant::now() }
    }

    /// So many are done of so many.
    pub(super) fn tell(&mut self, what: &str, done: usize, of: usize) {
        if self.last.elapsed() >= self.every {
            self.last = Instant::now();
            output::note(&format!("{done} of {of} {what}"));
        }
    }
}
