//! Threads with stacks that hold every expression that is allowed: hundreds of levels, within declarations that build on each other.

use std::io;
use std::thread::{Builder, Scope, ScopedJoinHandle};

/// The size of a stack in bytes. What a thread does not use of it takes no memory. The limits of the language multiply to some
/// 30,000 levels, and a level takes up to 4 kB.
pub const STACK: usize = 256 << 20;

/// Does something on a thread of its own; where there is no room for one, on this.
pub fn on_deep_stack<T: Send>(work: impl Fn() -> T + Sync) -> T {
    std::thread::scope(|scope| match spawn(scope, &work) {
        Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
        Err(_) => work(),
    })
}

/// A thread of a scope.
///
/// # Errors
///
/// The system's reason.
pub fn spawn<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    work: impl FnOnce() -> T + Send + 'scope,
) -> io::Result<ScopedJoinHandle<'scope, T>> {
    Builder::new().stack_size(STACK).spawn_scoped(scope, work)
}
