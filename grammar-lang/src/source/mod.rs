//! Source texts: spans, the source map, and the loader that gets texts by their names.

use serde::{Deserialize, Serialize};
use std::io;
use thiserror::Error;

/// Identifies a text in a [`SourceMap`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FileId(pub u32);

/// A stretch of one text, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Span {
    /// The text.
    pub file: FileId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// Makes a span from byte offsets.
    #[must_use]
    pub fn new(file: FileId, start: usize, end: usize) -> Self {
        let clip = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Self { file, start: clip(start), end: clip(end) }
    }

    /// The smallest span that holds both; `self` if they lie in different texts.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        if self.file != other.file {
            return self;
        }
        Self { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// The byte range.
    #[must_use]
    pub fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A text with the name that messages use for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// What messages call it: a path as the user wrote it, or `std.blocks`.
    pub name: String,
    /// The text.
    pub text: String,
}

/// Every text that a compilation has read, in the order of reading.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    sources: Vec<Source>,
    /// The places of each text.
    places: Vec<Places>,
}

/// Where lines begin and how many characters precede a place, so that neither is counted from the
/// start of the text for every finding.
#[derive(Clone, Debug, Default)]
struct Places {
    /// Where each line begins.
    lines: Vec<usize>,
    /// How many characters begin before each stretch of so many bytes.
    characters: Vec<usize>,
}

/// How many bytes are counted at once.
const STRETCH: usize = 1024;

/// How many characters begin in some bytes.
fn beginnings(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| **b & 0xC0 != 0x80).count()
}

impl Places {
    fn of(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        let lines = [0].into_iter().chain(ends.map(|(i, _)| i + 1)).collect();
        let mut before = 0;
        let characters = text.as_bytes().chunks(STRETCH).map(|stretch| {
            let here = before;
            before += beginnings(stretch);
            here
        });
        Self { lines, characters: characters.collect() }
    }

    /// How many characters precede a place.
    fn characters_before(&self, text: &str, place: usize) -> usize {
        let stretch = (place / STRETCH).min(self.characters.len().saturating_sub(1));
        let known = self.characters.get(stretch).copied().unwrap_or(0);
        known + text.as_bytes().get(stretch * STRETCH..place).map_or(0, beginnings)
    }
}

impl SourceMap {
    /// Adds a text.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> FileId {
        let id = FileId(u32::try_from(self.sources.len()).unwrap_or(u32::MAX));
        let text = text.into();
        self.places.push(Places::of(&text));
        self.sources.push(Source { name: name.into(), text });
        id
    }

    /// A text by its identifier.
    #[must_use]
    pub fn get(&self, id: FileId) -> Option<&Source> {
        self.sources.get(id.0 as usize)
    }

    /// All texts in the order of reading.
    pub fn iter(&self) -> impl Iterator<Item = (FileId, &Source)> {
        self.sources.iter().enumerate().map(|(i, s)| (FileId(i as u32), s))
    }

    /// The text under a span; empty if there is none.
    #[must_use]
    pub fn slice(&self, span: Span) -> &str {
        self.get(span.file).and_then(|s| s.text.get(span.range())).unwrap_or("")
    }

    /// Line and column (both from 1, columns in characters) of a span's start.
    #[must_use]
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let Some(source) = self.get(span.file) else { return (1, 1) };
        let start = span.start as usize;
        let place = if source.text.is_char_boundary(start) { start } else { source.text.len() };
        let Some(places) = self.places.get(span.file.0 as usize) else { return (1, 1) };
        let line = places.lines.partition_point(|begin| *begin <= place);
        let begin = line.checked_sub(1).and_then(|i| places.lines.get(i)).copied().unwrap_or(0);
        let before = |place| places.characters_before(&source.text, place);
        (line, before(place) - before(begin) + 1)
    }

    /// How many characters of its text precede a place, which is the start of a character.
    #[must_use]
    pub fn characters_before(&self, file: FileId, place: usize) -> usize {
        let text = self.get(file).map_or("", |s| s.text.as_str());
        self.places.get(file.0 as usize).map_or(0, |p| p.characters_before(text, place))
    }

    /// How many bytes the line has in which a span begins.
    #[must_use]
    pub fn line_length(&self, span: Span) -> usize {
        let text = self.get(span.file).map_or("", |s| s.text.as_str());
        let Some(places) = self.places.get(span.file.0 as usize) else { return 0 };
        let line = places.lines.partition_point(|begin| *begin <= span.start as usize);
        let begin = line.checked_sub(1).and_then(|i| places.lines.get(i)).copied().unwrap_or(0);
        places.lines.get(line).copied().unwrap_or(text.len()) - begin
    }
}

/// Why there is no text of a module.
#[derive(Debug, Error)]
pub enum NoModule {
    /// It is no file, and of no library.
    #[error("not in the standard library")]
    NotInLibrary,
    /// A module of a library asks for a file.
    #[error("the standard library imports no files")]
    FromLibrary,
    /// Only some texts are given, and it is none of them.
    #[error("not among these texts")]
    NotGiven,
    /// There is no file of this name.
    #[error("there is no such file")]
    NoFile,
    /// This user may not read the file.
    #[error("the file exists, but you have no permission to read it")]
    NotPermitted,
    /// The file cannot be read for another reason.
    #[error(transparent)]
    System(io::Error),
}

impl From<io::Error> for NoModule {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::NotFound => Self::NoFile,
            io::ErrorKind::PermissionDenied => Self::NotPermitted,
            _ => Self::System(error),
        }
    }
}

/// Where the text of a module comes from. The language itself reads no files.
pub trait Loader {
    /// The text of a module.
    ///
    /// `module` is what a `use` says: `std.blocks`, or a path such as
    /// `./legs.sgr`; `from` is the name of the source that says it. The answer's
    /// name identifies the module: equal names are one module.
    ///
    /// # Errors
    ///
    /// Why there is no such text.
    fn load(&self, module: &str, from: &str) -> Result<Source, NoModule>;

    /// Whether two names of sources lead to one text: through a link, a file can have several. What imports itself under ever new
    /// names would never end.
    fn leads_to_one(&self, one: &str, other: &str) -> bool {
        one == other
    }

    /// The files that lie beside a module, as paths from the same source, for suggestions.
    fn beside(&self, _module: &str, _from: &str) -> Vec<String> {
        Vec::new()
    }

    /// The modules of the standard library, for suggestions.
    fn library(&self) -> Vec<String> {
        Vec::new()
    }
}
