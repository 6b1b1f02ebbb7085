//! Declarations: a file checks each kind, and gives what it comes to; none if something is wrong.

mod actuations;
mod actuators;
mod examples;
mod fields;
mod items;
mod lattice;
mod loops;
mod methods;
mod models;
mod novelty;
mod observe;
mod parts;
mod rules;
mod searches;
pub(super) mod singles;
mod targets;
pub(super) mod tasks;

use indexmap::IndexSet;

use super::environment::Environment;
use super::expressions::Expressions;
use crate::diagnostics::Diagnostic;
use crate::source::Span;

/// Checks declarations.
pub(super) struct Declarations<'a> {
    pub(super) environment: &'a Environment<'a>,
    pub(super) expressions: Expressions<'a>,
    /// Rules in which something is wrong: what they match and choose is not certain.
    faulty: IndexSet<Span>,
}

impl<'a> Declarations<'a> {
    pub(super) fn new(expressions: Expressions<'a>) -> Self {
        Self { environment: expressions.environment, expressions, faulty: IndexSet::new() }
    }

    pub(super) fn report(&mut self, found: Diagnostic) {
        self.expressions.report(found);
    }
}
