//! What the expressions of an actuation can read.

use grammar_lang::eval::{Scope, Value};
use grammar_lang::ir::{Expr, Function, Group, RuleSet, Word};

use crate::derive::{Derivation, DesignScope};

/// The design, the time, and where a mutation stands in the annealing.
pub(super) struct DriveScope<'a> {
    design: DesignScope<'a>,
    rules: &'a RuleSet,
    pub(super) time: f64,
    pub(super) temperature: f64,
    pub(super) iteration: f64,
}

impl<'a> DriveScope<'a> {
    pub(super) fn new(rules: &'a RuleSet, derivation: &'a Derivation) -> Self {
        Self {
            design: DesignScope::new(rules, derivation),
            rules,
            time: 0.0,
            temperature: 0.0,
            iteration: 0.0,
        }
    }
}

impl Scope for DriveScope<'_> {
    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Time => Some(Value::Number(self.time)),
            Word::Temperature => Some(Value::Number(self.temperature)),
            Word::Iteration => Some(Value::Number(self.iteration)),
            _ => self.design.word(word),
        }
    }
    fn param(&self, name: &str) -> Option<Value> {
        self.design.param(name)
    }
    fn placed(&self, name: &str) -> Option<Value> {
        self.design.placed(name)
    }
    fn group(&self, group: &Group) -> Option<Vec<Value>> {
        self.design.group(group)
    }
    fn belongs(&self, part: &Value, group: &Group) -> Option<bool> {
        self.design.belongs(part, group)
    }
    fn attribute(&self, of: &Value, name: &str) -> Option<Value> {
        self.design.attribute(of, name)
    }
    fn call(&self, function: Function, arguments: &[Value]) -> Option<Value> {
        self.design.call(function, arguments)
    }
    fn pattern(&self, name: &str) -> Option<&Expr> {
        self.rules.patterns.get(name)
    }
}
