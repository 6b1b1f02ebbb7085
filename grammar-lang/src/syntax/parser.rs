//! The parser that pest makes of the grammar, and what it finds.

use pest_derive::Parser;

use super::ast::Module;
use crate::diagnostics::Diagnostic;

/// The parser that pest derives.
#[derive(Parser)]
#[grammar = "syntax/grammar.pest"]
pub(super) struct SgrParser;

/// What a text holds, and what is wrong with it.
#[derive(Default)]
pub(super) struct Found {
    pub(super) module: Module,
    pub(super) errors: Vec<Diagnostic>,
}
