//! The parser that pest makes of the grammar, and what it finds.

use pest_derive::Parser;

use super::ast::Module;
use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;

/// The parser that pest derives.
#[derive(Parser)]
#[grammar = "syntax/grammar.pest"]
pub(super) struct SgrParser;

/// What a text holds, and what is wrong with it.
#[derive(Default)]
pub(super) struct Found {
    pub(super) module: Module,
    pub(super) errors: Vec<Diagnostic>,
    /// Whether so much is wrong that the rest is not looked at.
    is_given_up: bool,
}

/// How many errors of syntax are reported of one text: with more, it is no grammar.
const MOST_ERRORS: usize = 1000;

impl Found {
    /// Whether so much is wrong that the text is not looked at from a place on; an error says so.
    pub(super) fn gives_up(&mut self, rest: Span) -> bool {
        if self.errors.len() >= MOST_ERRORS && !self.is_given_up {
            self.is_given_up = true;
            // What the rest declares is not known.
            self.module.headless = true;
            let message =
                format!("there are {MOST_ERRORS} errors before this place: the rest was not checked");
            let error = Diagnostic::new(Code::SYNTAX, Span { end: rest.start, ..rest }, message);
            self.errors.push(error.help("is this a grammar?"));
        }
        self.is_given_up
    }
}
