//! What is wrong with measurements, and where.

use std::fmt;

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// The file, as the user called it.
    pub file: String,
    /// The line, counted from 1.
    pub line: usize,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// Something that keeps measurements from being used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Where.
    pub place: Location,
    /// What, and what would do instead.
    pub message: String,
    /// Whether the measurement contradicts itself or the grammar; else the file is not as it should be.
    pub is_contradiction: bool,
}

impl Problem {
    /// A file that is not as it should be.
    pub(super) fn unreadable(place: &Location, message: impl Into<String>) -> Self {
        Self { place: place.clone(), message: message.into(), is_contradiction: false }
    }

    /// A measurement that contradicts itself or the grammar.
    pub(super) fn contradiction(place: &Location, message: impl Into<String>) -> Self {
        Self { place: place.clone(), message: message.into(), is_contradiction: true }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

/// Words with backquotes and commas: `` `a`, `b` ``.
pub(super) fn listed<S: AsRef<str>>(words: impl IntoIterator<Item = S>) -> String {
    words.into_iter().map(|w| format!("`{}`", w.as_ref())).collect::<Vec<_>>().join(", ")
}
