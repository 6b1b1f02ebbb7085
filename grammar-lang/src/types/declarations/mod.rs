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
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast::{Item, ItemKind};
use crate::syntax::declarations::BlockKind;

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
    /// Checks every declaration for its own sake, whether or not anything uses
    /// it; gives what only such checks have read. The library has its own tests.
    pub(in crate::types) fn check_all(&mut self) -> IndexSet<Declaration> {
        let program = self.environment.program;
        let before = self.expressions.touched.clone();
        for (declaration, item) in program.items() {
            let library = program.modules.get(declaration.module).is_some_and(|m| m.name.starts_with("std."));
            let own = declaration.module == 0 || !library;
            if own && !program.dropped.contains_key(&declaration) {
                self.check_own(declaration, item);
            }
        }
        std::mem::replace(&mut self.expressions.touched, before)
    }

    // The compiler asks for a block that is not checked here.
    fn check_own(&mut self, declaration: Declaration, item: &Item) {
        match &item.kind {
            ItemKind::Block(kind, block) => match kind {
                BlockKind::Part => drop(self.part(block, item.damaged)),
                BlockKind::Actuator => drop(self.actuator(block, item.damaged)),
                BlockKind::Cell => drop(self.cell(block, item.damaged)),
                BlockKind::Model => drop(self.model(block, None, item.damaged)),
                BlockKind::Search => drop(self.search(block, item.damaged)),
            },
            ItemKind::Pattern(_, value) => drop(self.fixed_pattern(value, item.damaged)),
            ItemKind::Table(table) => drop(self.expressions.table(table, item.damaged)),
            ItemKind::Target { block, backend, kind } => {
                drop(self.target(block, backend, kind, item.damaged));
            }
            ItemKind::Prototype(block, backend) => drop(self.prototype(block, backend, item.damaged)),
            ItemKind::Observe(names) => drop(self.observed(names)),
            ItemKind::Novelty(name, clauses) => drop(self.novelty(name, clauses, item.damaged)),
            ItemKind::Term(_, ty, value) => drop(self.term(ty, value, item.damaged)),
            ItemKind::Actuation { name, binder, kind, clauses } => {
                drop(self.actuation(name, binder, kind, clauses, item.damaged));
            }
            ItemKind::Let(_, None, value) => drop(self.expressions.inline(declaration, value)),
            ItemKind::Let(_, Some(parameters), value) => {
                self.distinct(parameters.iter().map(|p| &p.name), "parameter");
                self.expressions.own_body(declaration, parameters, value);
            }
            ItemKind::Enum(name, values) => self.enumeration(name, values),
            ItemKind::Record(name, fields) => {
                self.distinct(fields.iter().map(|f| &f.name), "field");
                // That a record is read to be checked does not mean that something uses it.
                let used = self.expressions.touched.contains(&declaration);
                self.expressions.type_named(name);
                if !used {
                    self.expressions.touched.shift_remove(&declaration);
                }
            }
            _ => {}
        }
    }
}
