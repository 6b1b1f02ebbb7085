//! What the expressions of an actuation can read.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{Reference, Scope, Value};
use grammar_lang::ir::{RuleSet, SearchWord, Word};

use crate::derive::{Derivation, DesignScope};
use crate::design::PartId;

/// What sensors give and what is remembered, by its name and the part that has it.
pub(super) type Felt<'a> = BTreeMap<(&'a str, Option<PartId>), Value>;

/// The design, the time, what sensors give, and where a mutation stands in the annealing.
pub(super) struct DriveScope<'a> {
    design: DesignScope<'a>,
    pub(super) time: f64,
    pub(super) temperature: f64,
    pub(super) iteration: f64,
    /// Time between two control moments, s.
    control_interval: f64,
    pub(super) felt: Felt<'a>,
    /// How many operations may still be spent, if that is bounded.
    pub(super) left: Option<&'a AtomicU64>,
}

impl<'a> DriveScope<'a> {
    pub(super) fn new(rules: &'a RuleSet, derivation: &'a Derivation, control_interval: f64) -> Self {
        Self {
            design: DesignScope::new(rules, derivation),
            time: 0.0,
            temperature: 0.0,
            iteration: 0.0,
            control_interval,
            felt: Felt::new(),
            left: None,
        }
    }
}

impl Scope for DriveScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn left(&self) -> Option<&AtomicU64> {
        self.left
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Time => Some(Value::Number(self.time)),
            Word::ControlInterval => Some(Value::Number(self.control_interval)),
            Word::Search(SearchWord::Temperature) => Some(Value::Number(self.temperature)),
            Word::Search(SearchWord::Iteration) => Some(Value::Number(self.iteration)),
            _ => self.design.word(word),
        }
    }

    fn sensed(&self, sensor: &str, of: Option<&Value>) -> Option<Value> {
        let part = match of {
            None => None,
            Some(Value::Reference(Reference::Part(part))) => Some(*part),
            Some(_) => return None,
        };
        self.felt.get(&(sensor, part)).cloned()
    }
}
