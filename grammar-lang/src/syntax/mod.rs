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
mod parse;
mod parser;
mod recover;
mod slip;
mod strange;
mod tokens;
mod tree;

use crate::diagnostics::Diagnostic;
use crate::source::{FileId, SourceMap};

pub use direction::Direction;
pub use tokens::{Token, TokenKind, tokens};
pub(crate) use tree::{Node, Tree, tree};

/// Reads a text: always a tree, and every error that its form has.
pub fn parse(sources: &SourceMap, file: FileId) -> (ast::Module, Vec<Diagnostic>) {
    let text = sources.get(file).map_or("", |s| s.text.as_str());
    parse::module(text, file)
}
