//! Runs that go on at once, as far as there are threads.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;

use super::exit;
use super::output::Fault;
use crate::deep;
use crate::search::{Jobs, Threads};
use crate::simulate::Stop;

/// Does `one` for each that waits, with `threads` in all; what is not begun when it is asked to stop goes on waiting. `ended`
/// hears of each as it ends.
pub(super) fn side_by_side<T: Clone + Send, O: Send>(
    threads: usize,
    stop: Stop<'_>,
    waiting: &mut VecDeque<T>,
    one: impl Fn(&T, Jobs) -> Result<O, Fault> + Sync,
    mut ended: impl FnMut(T, Result<O, Fault>),
) {
    let shared = Threads::new(threads);
    // As many runs as there are threads; fewer share what there is, also when others have ended.
    let mut shares: Vec<Jobs> = (0..threads.min(waiting.len())).map(|_| shared.share()).collect();
    let mut under_way = 0;
    std::thread::scope(|scope| {
        let (send, outcomes) = mpsc::channel();
        loop {
            while under_way < threads
                && !stop.is_asked()
                && let Some(next) = waiting.pop_front()
            {
                under_way += 1;
                let jobs = shares.pop().unwrap_or_else(|| shared.share());
                let (send, one, which) = (send.clone(), &one, next.clone());
                let begun = deep::spawn(scope, move || {
                    // The others go on if one breaks down.
                    let outcome = catch_unwind(AssertUnwindSafe(|| one(&next, jobs)));
                    let outcome = outcome.unwrap_or_else(|_| {
                        Err(Fault { code: exit::BUG, message: "a bug in sgc ended it".to_owned() })
                    });
                    // The receiver lives as long as runs are under way.
                    let _ = send.send((next, outcome));
                });
                if let Err(why) = begun {
                    under_way -= 1;
                    ended(which, Err(Fault::usage(format!("cannot start a thread for it: {why}"))));
                }
            }
            if under_way == 0 {
                break;
            }
            let Ok((which, outcome)) = outcomes.recv() else { break };
            under_way -= 1;
            ended(which, outcome);
        }
    });
}
