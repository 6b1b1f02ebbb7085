//! When simulations are to be given up.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Asks those who work to end soon: a flag that is set from outside, or a time.
#[derive(Clone, Copy, Debug)]
pub struct Stop<'a> {
    flag: &'a AtomicBool,
    deadline: Option<Instant>,
}

/// A flag that nobody sets.
static NEVER: AtomicBool = AtomicBool::new(false);

impl<'a> Stop<'a> {
    /// Work is to the end.
    pub const NEVER: Stop<'static> = Stop { flag: &NEVER, deadline: None };

    /// Asked for by a flag, or when a time has come.
    #[must_use]
    pub fn new(flag: &'a AtomicBool, deadline: Option<Instant>) -> Self {
        Self { flag, deadline }
    }

    /// Asked for by another flag, or when the same time has come.
    #[must_use]
    pub fn by(self, flag: &AtomicBool) -> Stop<'_> {
        Stop { flag, deadline: self.deadline }
    }

    /// Whether the flag is set.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// Whether the time has come.
    #[must_use]
    pub fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Whether to end, for whatever reason.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.is_interrupted() || self.is_late()
    }
}
