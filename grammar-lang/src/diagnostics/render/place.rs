//! A span as programs read it.

use serde::Serialize;

use crate::source::{SourceMap, Span};

/// A stretch of a text: in bytes from 0, and where it begins in lines and characters from 1.
#[derive(Serialize)]
pub(super) struct LineColumn<'a> {
    pub(super) file: &'a str,
    pub(super) line: usize,
    pub(super) column: usize,
    pub(super) start: u32,
    pub(super) end: u32,
}

impl<'a> LineColumn<'a> {
    pub(super) fn of(span: Span, sources: &'a SourceMap) -> Self {
        let (line, column) = sources.line_column(span);
        let file = sources.get(span.file).map_or("", |s| s.name.as_str());
        Self { file, line, column, start: span.start, end: span.end }
    }
}
