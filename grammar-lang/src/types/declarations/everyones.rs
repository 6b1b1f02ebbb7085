//! What actuations share that is declared outside of them: `shared` variables, and values that read some.

use indexmap::IndexSet;

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, Ty};
use crate::names::Declaration;
use crate::syntax::ast::{self, ActuationClause, ItemKind, Name};
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;

/// What an actuation reads that is declared outside of all of them. A variable stands before the values that read it.
pub(super) struct Everyones<'a>(Vec<&'a ItemKind>);

impl<'a> Everyones<'a> {
    /// The shared variables.
    pub(super) fn variables(&self) -> impl Iterator<Item = &'a ast::Variable> {
        self.0.iter().filter_map(|item| match item {
            ItemKind::Shared(variable) => Some(&**variable),
            _ => None,
        })
    }

    /// The values that read shared variables, by name.
    pub(super) fn values(&self) -> impl Iterator<Item = (&'a Name, &'a ast::Expr)> {
        self.0.iter().filter_map(|item| match item {
            ItemKind::Let(name, None, value) => Some((name, value)),
            _ => None,
        })
    }
}

impl<'a> Declarations<'a> {
    /// What an actuation reads that is declared outside of it.
    pub(super) fn everyones(
        &mut self,
        name: &Name,
        binder: &Name,
        kind: &Name,
        clauses: &[ActuationClause],
    ) -> Everyones<'a> {
        let program = self.environment.program;
        let is_shared = |(declaration, item): &(Declaration, &ast::Item)| {
            let reads = match &item.kind {
                ItemKind::Shared(_) => true,
                ItemKind::Let(_, None, _) => self.environment.sharing.reads(*declaration),
                _ => false,
            };
            reads && !program.dropped.contains_key(declaration)
        };
        let some: Vec<Declaration> =
            program.items().filter(is_shared).map(|(declaration, _)| declaration).collect();
        if some.is_empty() {
            return Everyones(Vec::new());
        }
        let all = self.environment.sharing.before(some);
        // Tried with all of them: those that are read stay.
        let before = self.expressions.errors.len();
        let touched = self.expressions.touched.clone();
        let read = std::mem::replace(&mut self.expressions.read, IndexSet::new());
        self.actuation_with(&self.items_of(&all), name, binder, kind, clauses, true);
        drop(self.expressions.errors.split_off(before));
        self.expressions.touched = touched;
        let tried = std::mem::replace(&mut self.expressions.read, read);
        let is_read = |declaration: &Declaration| {
            let name = program.item(*declaration).and_then(crate::names::declared);
            name.is_some_and(|name| tried.contains(&name.span))
        };
        let wanted: Vec<Declaration> = all.into_iter().filter(is_read).collect();
        self.expressions.read.extend(tried);
        let kept = self.environment.sharing.before(wanted);
        self.expressions.touched.extend(&kept);
        let kept = self.items_of(&kept);
        self.one_of_each_name(&kept, clauses);
        kept
    }

    /// Reports variables that have one name in one actuation: another module may declare one that only its own values read.
    fn one_of_each_name(&mut self, kept: &Everyones<'_>, clauses: &[ActuationClause]) {
        let own = clauses.iter().filter_map(|clause| match clause {
            ActuationClause::Variable(variable) => Some(&variable.name),
            _ => None,
        });
        let mut names: Vec<&Name> = own.collect();
        for variable in kept.variables() {
            let name = &variable.name;
            if let Some(other) = names.iter().find(|other| other.text == name.text) {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        other.span,
                        format!("this actuation has two variables `{}`", name.text),
                    )
                    .label("one")
                    .also(name.span, "the other, which a value or function of that text reads")
                    .help("give one of them another name"),
                );
            }
            names.push(name);
        }
    }

    fn items_of(&self, declarations: &[Declaration]) -> Everyones<'a> {
        let program = self.environment.program;
        Everyones(declarations.iter().filter_map(|d| program.item(*d)).map(|item| &item.kind).collect())
    }

    /// Checks a variable that all actuations share, by itself.
    pub(super) fn everyones_own(&mut self, variable: &ast::Variable, damaged: bool) {
        let cx = Context::new(Stage::Drive, damaged);
        self.variable(variable, &cx);
    }

    /// A value that is declared outside of the actuation that reads it: it knows no name of this actuation.
    pub(super) fn value_of_everyone(&mut self, value: &ast::Expr, outside: &mut Context) -> Expr {
        let read = std::mem::take(&mut self.expressions.read);
        let value = self.expressions.infer(value, outside);
        // What it reads is asked for when it is read itself.
        self.expressions.read = read;
        value
    }

    /// The type of what a variable is read as.
    pub(super) fn type_of_variable(variable: &ast::Variable, item: Ty) -> Ty {
        if variable.size.is_some() { Ty::List(Box::new(item)) } else { item }
    }
}
