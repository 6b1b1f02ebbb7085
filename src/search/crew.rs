//! The threads that work for one search, and how many of them there are now.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::Failure;

/// How many threads a search may use. Of several runs that share them, each gets more when others have ended.
#[derive(Clone, Debug)]
pub struct Jobs {
    all: usize,
    /// How many searches share them.
    sharers: Arc<AtomicUsize>,
}

impl Jobs {
    /// So many threads, for one search.
    #[must_use]
    pub fn new(all: usize) -> Self {
        Self::shared(all, Arc::new(AtomicUsize::new(1)))
    }

    /// So many threads for as many searches as a number says that somebody else keeps.
    #[must_use]
    pub fn shared(all: usize, sharers: Arc<AtomicUsize>) -> Self {
        Self { all: all.max(1), sharers }
    }

    /// How many a search may use in the end.
    pub(super) fn most(&self) -> usize {
        self.all
    }

    /// How many a search may use now; at least one.
    #[must_use]
    pub fn now(&self) -> usize {
        (self.all / self.sharers.load(Ordering::Relaxed).max(1)).max(1)
    }
}

/// Those that make a batch of evaluations.
pub(super) struct Crew {
    pool: Option<rayon::ThreadPool>,
    jobs: Jobs,
    /// How many of them are at other work.
    away: AtomicUsize,
}

impl Crew {
    /// As many as a search may use.
    ///
    /// # Errors
    ///
    /// [`Failure::Threads`].
    pub(super) fn new(jobs: &Jobs) -> Result<Self, Failure> {
        let most = jobs.most();
        let pool = (most > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(most).build()).transpose();
        let pool = pool.map_err(|e| Failure::Threads(format!("cannot start {most} threads: {e}")))?;
        Ok(Self { pool, jobs: jobs.clone(), away: AtomicUsize::new(0) })
    }

    /// The thread that calls, alone.
    pub(super) fn alone() -> Self {
        Self { pool: None, jobs: Jobs::new(1), away: AtomicUsize::new(0) }
    }

    /// How many threads a batch may use now; at least one.
    pub(super) fn threads(&self) -> usize {
        self.jobs.now().saturating_sub(self.away.load(Ordering::Relaxed)).max(1)
    }

    /// Says how many are at other work.
    pub(super) fn miss(&self, away: usize) {
        self.away.store(away, Ordering::Relaxed);
    }

    /// Does something on these threads.
    pub(super) fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}
