//! The threads that work for one search, and how many of them there are now.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Failure;
use crate::deep::STACK;

/// Threads that several searches share: each gets more when others have ended.
#[derive(Clone, Debug)]
pub struct Threads(Arc<Roster>);

#[derive(Debug)]
struct Roster {
    /// How many threads there are.
    all: usize,
    seats: Mutex<Seats>,
}

#[derive(Debug, Default)]
struct Seats {
    /// How many have ever been taken.
    taken: usize,
    /// Those of searches that have not ended.
    held: BTreeSet<usize>,
}

impl Roster {
    fn seats(&self) -> MutexGuard<'_, Seats> {
        // Every change is whole.
        self.seats.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Threads {
    /// So many threads; at least one.
    #[must_use]
    pub fn new(all: usize) -> Self {
        Self(Arc::new(Roster { all: all.max(1), seats: Mutex::default() }))
    }

    /// The share of one more search, until it and all its clones are dropped.
    #[must_use]
    pub fn share(&self) -> Jobs {
        let mut seats = self.0.seats();
        let number = seats.taken;
        seats.taken += 1;
        seats.held.insert(number);
        Jobs(Arc::new(Seat { table: Arc::clone(&self.0), number }))
    }
}

#[derive(Debug)]
struct Seat {
    table: Arc<Roster>,
    number: usize,
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.table.seats().held.remove(&self.number);
    }
}

/// How many threads a search may use.
#[derive(Clone, Debug)]
pub struct Jobs(Arc<Seat>);

impl Jobs {
    /// So many threads, for one search.
    #[must_use]
    pub fn new(all: usize) -> Self {
        Threads::new(all).share()
    }

    /// How many a search may use in the end.
    pub(super) fn most(&self) -> usize {
        self.0.table.all
    }

    /// How many a search may use now; at least one. Those that do not divide evenly go to the first searches.
    #[must_use]
    pub fn now(&self) -> usize {
        let Seat { table, number } = &*self.0;
        let seats = table.seats();
        let (sharers, before) = (seats.held.len().max(1), seats.held.range(..number).count());
        (table.all / sharers + usize::from(before < table.all % sharers)).max(1)
    }

    /// Does something on as many threads as there are now.
    ///
    /// # Errors
    ///
    /// [`Failure::Threads`].
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        Ok(pool(self.now())?.install(work))
    }
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
    pool.map_err(|why| Failure::Threads { wanted: threads, why })
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
        let pool = (most > 1).then(|| pool(most)).transpose()?;
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

#[cfg(test)]
mod tests {
    use super::{Jobs, Threads};

    #[test]
    fn searches_share_all_threads() {
        let threads = Threads::new(5);
        let mut shares: Vec<Jobs> = (0..3).map(|_| threads.share()).collect();
        let now = |shares: &[Jobs]| shares.iter().map(Jobs::now).collect::<Vec<_>>();
        assert_eq!(now(&shares), [2, 2, 1]);
        let clone = shares[0].clone();
        shares.remove(0);
        assert_eq!(now(&shares), [2, 1], "a clone holds its share");
        drop(clone);
        assert_eq!(now(&shares), [3, 2]);
        shares.push(threads.share());
        assert_eq!(now(&shares), [2, 2, 1]);
        shares.truncate(1);
        assert_eq!(now(&shares), [5]);
        // More searches than threads have one each.
        shares.extend((0..9).map(|_| threads.share()));
        assert!(now(&shares).iter().all(|&jobs| jobs == 1));
        assert_eq!(Jobs::new(0).now(), 1);
    }
}
