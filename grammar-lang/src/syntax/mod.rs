//! From text to syntax tree. The only place that names pest.

pub mod ast;
mod braces;
pub mod declarations;
mod direction;
pub(crate) mod earlier;
mod explain;
mod forms;
mod levels;
mod lower;
mod operators;
mod parse;
mod parser;
mod reads;
mod recover;
mod slip;
mod strange;
mod tokens;
mod tree;

use std::collections::BTreeMap;

use crate::diagnostics::Diagnostic;
use crate::source::{FileId, Source, SourceMap};

pub use direction::Direction;
pub use tokens::{Token, TokenKind, tokens};
pub(crate) use tree::{Node, Tree, tree};

/// Reads a text: always a tree, and every error that its form has.
pub fn parse(sources: &SourceMap, file: FileId) -> (ast::Module, Vec<Diagnostic>) {
    let text = sources.get(file).map_or("", |s| s.text.as_str());
    parse::module(text, file)
}

/// The trees of texts that are read again and again: each text is parsed once.
#[derive(Debug, Default)]
pub(crate) struct Trees {
    known: BTreeMap<FileId, (Source, ast::Module, Vec<Diagnostic>)>,
}

impl Trees {
    /// What [`parse`] gives.
    pub(crate) fn parse(&mut self, sources: &SourceMap, file: FileId) -> (ast::Module, Vec<Diagnostic>) {
        let source = sources.get(file);
        if let Some((known, tree, errors)) = self.known.get(&file)
            && source == Some(known)
        {
            return (tree.clone(), errors.clone());
        }
        let (tree, errors) = parse(sources, file);
        if let Some(source) = source {
            self.known.insert(file, (source.clone(), tree.clone(), errors.clone()));
        }
        (tree, errors)
    }
}
