//! What the expressions of an actuation can read.

use grammar_lang::eval::{Scope, Value};
use grammar_lang::ir::{RuleSet, SearchWord, Word};

use crate::derive::{Derivation, DesignScope};

/// The design, the time, and where a mutation stands in the annealing.
pub(super) struct DriveScope<'a> {
    design: DesignScope<'a>,
    pub(super) time: f64,
    pub(super) temperature: f64,
    pub(super) iteration: f64,
}

impl<'a> DriveScope<'a> {
    pub(super) fn new(rules: &'a RuleSet, derivation: &'a Derivation) -> Self {
        Self { design: DesignScope::new(rules, derivation), time: 0.0, temperature: 0.0, iteration: 0.0 }
    }
}

impl Scope for DriveScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Time => Some(Value::Number(self.time)),
            Word::Search(SearchWord::Temperature) => Some(Value::Number(self.temperature)),
            Word::Search(SearchWord::Iteration) => Some(Value::Number(self.iteration)),
            _ => self.design.word(word),
        }
    }
}
