//! Tunes bodies that are likely to come, on threads that have nothing else to do.
//!
//! Whether a body is accepted is known only when its curves are tuned, but what the next body would be in either
//! case is known at once. While one thread tunes the body at hand, others tune those. What they evaluate is
//! remembered ([`Cache`]), and when the search comes to such a body it finds its evaluations made. If a helper is still at it
//! then, the thread of the search tunes another one meanwhile. What turns out
//! not to be needed is neither counted nor used: nothing here changes what is found, only how soon.

use std::collections::{BTreeMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use grammar_lang::ir::RuleSet;

use super::super::Bounds;
use super::super::aim::Aim;
use super::super::body::{Known, Tasks};
use super::super::cache::{self, Subject};
use super::super::crew::{Crew, Jobs};
use super::super::curves::Progress;
use super::super::evaluator::Engine;
use super::super::fidelity::Fidelity;
use super::super::state::{Body, Trial, Tune, Tuned, Worth};
use crate::derive::{Candidate, Derivation};
use crate::drive::Parameters;

/// Helpers look this often whether there are more threads now.
const LOOK: Duration = Duration::from_millis(200);

/// Names a body that may come: the number of its move, and what it is.
pub(super) type Key = (usize, Subject);

/// What was found for a body: its curves and its value; none if no evaluation was valid.
pub(super) type Found = Option<(Vec<Tune>, f64)>;

/// A body that is worth tuning.
#[derive(Clone)]
pub(super) struct Order {
    pub(super) key: Key,
    derivation: Arc<Derivation>,
    warm: Vec<Parameters>,
    further: Option<Tuned>,
    aim: Option<Aim>,
    parent: Vec<Worth>,
    known: Known,
}

impl Order {
    /// The body that is tried as a move of a number.
    pub(super) fn of(number: usize, trial: &Trial<Arc<Derivation>>, known: Known) -> Self {
        let Trial { derivation, warm, further, aim, parent, .. } = trial;
        let mut bits = Vec::new();
        warm.iter().flatten().for_each(|x| bits.extend(x.to_bits().to_le_bytes()));
        if let Some(further) = further {
            bits.extend(further.times.to_le_bytes());
        }
        bits.extend(aim.iter().flat_map(Aim::bits));
        let of = cache::subject(derivation, "", Fidelity::Model);
        let key = if bits.is_empty() { of } else { cache::named(&of, &bits) };
        Self {
            key: (number, key),
            derivation: Arc::clone(derivation),
            warm: warm.clone(),
            further: further.clone(),
            aim: aim.clone(),
            parent: parent.clone(),
            known,
        }
    }
}

/// What helpers need to know of a search; it does not change.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) rules: &'a RuleSet,
    /// What the search evaluates with; helpers have threads of their own.
    pub(super) engine: Engine<'a>,
    pub(super) seed: u64,
    pub(super) bounds: Bounds<'a>,
}

/// The thread of the search, among those that tune.
const OWN: usize = 0;

/// The helpers of a search.
pub(super) struct Ahead<'a> {
    crew: &'a Crew,
    jobs: Jobs,
    /// The thread of the search is the first.
    threads: Vec<Helper>,
    shared: Mutex<Shared>,
    changed: Condvar,
}

/// How a thread is told to leave its work.
#[derive(Default)]
struct Helper {
    /// At once: it is in vain.
    recalled: AtomicBool,
    /// After a batch of evaluations: the search is there.
    relieved: AtomicBool,
}

#[derive(Default)]
struct Shared {
    /// Those that nobody has begun, the likeliest first.
    wanted: VecDeque<Order>,
    /// What each thread is at ahead of time.
    active: Vec<Option<Key>>,
    done: BTreeMap<Key, Found>,
    /// What the search has come to while a helper is at it.
    awaited: Option<Key>,
    /// How often any of these changed.
    changes: u64,
    is_over: bool,
}

impl<'a> Ahead<'a> {
    /// As many helpers as there may be threads beside that of the search.
    pub(super) fn new(jobs: &Jobs, crew: &'a Crew) -> Self {
        let threads: Vec<Helper> = (0..jobs.most().max(1)).map(|_| Helper::default()).collect();
        let shared = Shared { active: vec![None; threads.len()], ..Shared::default() };
        Self { crew, jobs: jobs.clone(), threads, shared: Mutex::new(shared), changed: Condvar::new() }
    }

    /// How many helpers there are at most.
    pub(super) fn helpers(&self) -> usize {
        self.threads.len() - 1
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        // Whoever breaks down breaks down between two changes.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells everybody of a change.
    fn change(&self, shared: &mut Shared) {
        shared.changes += 1;
        self.crew.miss(shared.helping());
        self.changed.notify_all();
    }

    /// How often anything changed: as long as it is the same, there is nothing new to plan.
    pub(super) fn changes(&self) -> u64 {
        self.lock().changes
    }

    /// What is known of a body.
    pub(super) fn found(&self, key: &Key) -> Option<Found> {
        self.lock().done.get(key).cloned()
    }

    /// Says what is worth tuning, the likeliest first, after the move of a number. Helpers that are at anything else leave it.
    pub(super) fn want(&self, now: usize, orders: Vec<Order>) {
        let mut shared = self.lock();
        for (helper, at) in self.threads.iter().zip(&shared.active) {
            if at.is_some_and(|at| orders.iter().all(|order| order.key != at)) {
                helper.recalled.store(true, Ordering::Relaxed);
            }
        }
        let Shared { wanted, active, done, .. } = &mut *shared;
        done.retain(|(number, _), _| *number >= now);
        *wanted = orders
            .into_iter()
            .filter(|order| !active.contains(&Some(order.key)) && !done.contains_key(&order.key))
            .collect();
        // Not a change that asks for another plan.
        self.changed.notify_all();
    }

    /// Takes a body over that the search has come to: what a helper has of it by then, the search finds made. As long as a
    /// helper is at it, this thread tunes what else is worth it, which `plan` says; but not where all that comes depends
    /// on this body.
    pub(super) fn take_over(&self, key: &Key, search: Search<'_>, mut plan: impl FnMut()) {
        let depends = search.rules.search.annealing().is_some();
        loop {
            let mut shared = self.lock();
            shared.wanted.retain(|order| order.key != *key);
            let place = shared.active.iter().position(|at| *at == Some(*key));
            shared.awaited = place.map(|_| *key);
            let Some(place) = place else { return };
            if search.bounds.stop.is_asked() {
                self.recall();
            } else if let Some(order) = (!depends).then(|| shared.wanted.pop_front()).flatten() {
                drop(self.tune(OWN, order, search, shared));
                plan();
                continue;
            } else {
                self.threads[place].relieved.store(true, Ordering::Relaxed);
            }
            drop(self.changed.wait_timeout(shared, LOOK).unwrap_or_else(PoisonError::into_inner));
        }
    }

    /// Tunes a body on a thread, and keeps what comes of it.
    fn tune<'s>(
        &'s self,
        thread: usize,
        order: Order,
        search: Search<'_>,
        mut shared: MutexGuard<'s, Shared>,
    ) -> MutexGuard<'s, Shared> {
        let (own, key) = (&self.threads[thread], order.key);
        shared.active[thread] = Some(key);
        own.recalled.store(false, Ordering::Relaxed);
        own.relieved.store(false, Ordering::Relaxed);
        self.change(&mut shared);
        drop(shared);
        // What breaks down here breaks down where the search comes to it.
        let alone = Crew::alone();
        let bounds = if thread == OWN { search.bounds } else { search.bounds.by(&own.recalled) };
        let search = Search { bounds: bounds.unbounded(), ..search };
        let found = catch_unwind(AssertUnwindSafe(|| own.tune(order, search, &alone))).unwrap_or(None);
        let mut shared = self.lock();
        shared.active[thread] = None;
        if shared.awaited == Some(key) {
            // What it is at may be in vain.
            self.threads[OWN].relieved.store(true, Ordering::Relaxed);
        }
        if let Some(found) = found {
            shared.done.insert(key, found);
        }
        self.change(&mut shared);
        shared
    }

    fn recall(&self) {
        self.threads.iter().for_each(|thread| thread.recalled.store(true, Ordering::Relaxed));
    }

    /// Sends all helpers home.
    pub(super) fn end(&self) {
        let mut shared = self.lock();
        shared.is_over = true;
        // Nobody begins anything after this.
        self.recall();
        self.change(&mut shared);
    }

    /// What a helper does until it is sent home.
    pub(super) fn help(&self, number: usize, search: Search<'_>) {
        let mut shared = self.lock();
        while !shared.is_over {
            let is_free = shared.helping() + 1 < self.jobs.now();
            if let Some(order) = is_free.then(|| shared.wanted.pop_front()).flatten() {
                shared = self.tune(number, order, search, shared);
            } else {
                let waited = self.changed.wait_timeout(shared, LOOK);
                shared = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

impl Shared {
    /// How many helpers are at work.
    fn helping(&self) -> usize {
        self.active.iter().skip(OWN + 1).flatten().count()
    }
}

impl Helper {
    /// Tunes a body; what came of it, if that was not stopped.
    fn tune(&self, order: Order, search: Search<'_>, alone: &Crew) -> Option<Found> {
        let Search { rules, engine, seed, bounds } = search;
        let Order { key: (number, _), derivation, warm, further, aim, parent, known } = order;
        let mut tasks = Tasks {
            candidate: Candidate::new(rules, Arc::clone(&derivation)),
            engine: Engine { crew: alone, ..engine },
            streams: super::curves(seed, number),
            warm,
            is_given: false,
            further,
            aim,
            parent,
            bounds,
            known,
            tuner: None,
        };
        // It is not the first: what has no value counts as such.
        let (mut body, mut spent) = (Body::default(), 2);
        loop {
            match tasks.advance(&mut body, &mut spent) {
                Ok(Progress::More) if self.relieved.load(Ordering::Relaxed) => return None,
                Ok(Progress::More) => {}
                Ok(Progress::Done) => return Some(body.found(rules, &derivation).0),
                // The search itself will come to the same error, if it comes there.
                Ok(Progress::Cut(_)) | Err(_) => return None,
            }
        }
    }
}

/// Sends the helpers home, however the search ends.
pub(super) struct Home<'a, 'b>(pub(super) &'a Ahead<'b>);

impl Drop for Home<'_, '_> {
    fn drop(&mut self) {
        self.0.end();
    }
}
