//! A list that keeps its places when it is emptied.

use std::ops::{Deref, DerefMut};

/// A list of large entries, filled anew in every step: they are written where they stay, never moved there.
#[derive(Clone, Debug)]
pub(super) struct Places<T> {
    all: Vec<T>,
    used: usize,
}

impl<T: Copy> Places<T> {
    /// Room for so many entries; it grows if it must.
    pub(super) fn new(capacity: usize) -> Self {
        Self { all: Vec::with_capacity(capacity), used: 0 }
    }

    /// Forgets all entries.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.used = 0;
    }

    /// So many more places, to be written to: they hold what they held before, or `blank`.
    #[inline(always)]
    pub(super) fn more(&mut self, count: usize, blank: T) -> &mut [T] {
        let start = self.used;
        self.used += count;
        if self.all.len() < self.used {
            self.all.resize(self.used, blank);
        }
        &mut self.all[start..self.used]
    }

    /// Writes an entry to the next place.
    #[inline(always)]
    pub(super) fn push(&mut self, entry: T) {
        if let Some(place) = self.all.get_mut(self.used) {
            *place = entry;
        } else {
            self.all.push(entry);
        }
        self.used += 1;
    }
}

impl<T> Deref for Places<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.all[..self.used]
    }
}

impl<T> DerefMut for Places<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.all[..self.used]
    }
}
