//! The loops of a search, as those who check it and its methods know them.

use crate::ir::{self, SearchMethod};

/// A loop of a search.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Loop {
    Bodies,
    Curves,
}

/// What a loop came to: its schedule, and its method among all.
pub(super) struct Looped<'a> {
    pub(super) which: Loop,
    pub(super) schedule: &'a ir::Schedule,
    pub(super) method: SearchMethod<'a>,
}

/// What is there must be right; what is not there may be missing.
pub(super) fn whole<T>(given: Option<Option<T>>) -> Option<Option<T>> {
    match given {
        Some(value) => Some(Some(value?)),
        None => Some(None),
    }
}
