//! What actuations share that is declared outside of them: `shared` variables, and values that read some.

use indexmap::IndexSet;

use super::Declarations;
use crate::ir::{Expr, Ty};
use crate::names::Declaration;
use crate::syntax::ast::{self, ActuationClause, ItemKind, Name};
use crate::types::expressions::context::{Context, Local};
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
        let own: Vec<&str> = clauses.iter().filter_map(named_by).map(|name| name.text.as_str()).collect();
        let visible = program.items().filter(|(declaration, item)| {
            let name = match &item.kind {
                ItemKind::Shared(variable) => &variable.name,
                ItemKind::Let(name, None, _) if self.environment.sharing.reads(*declaration) => name,
                _ => return false,
            };
            let here = program.lookup(binder.span, &name.text).map(|(found, _)| found);
            // What the actuation calls so itself is meant.
            here == Some(*declaration) && !own.contains(&name.text.as_str())
        });
        let visible: Vec<Declaration> = visible.map(|(declaration, _)| declaration).collect();
        if visible.is_empty() {
            return Everyones(Vec::new());
        }
        let all = self.environment.sharing.before(visible);
        // Tried with all of them: those that are read stay.
        let before = self.expressions.errors.len();
        let read = std::mem::replace(&mut self.expressions.read, IndexSet::new());
        self.actuation_with(&self.items_of(&all), name, binder, kind, clauses, true);
        drop(self.expressions.errors.split_off(before));
        let tried = std::mem::replace(&mut self.expressions.read, read);
        let is_read = |declaration: &Declaration| {
            let name = program.item(*declaration).and_then(crate::names::declared);
            name.is_some_and(|name| tried.contains(&name.span))
        };
        let wanted: Vec<Declaration> = all.into_iter().filter(is_read).collect();
        self.expressions.read.extend(tried);
        let kept = self.environment.sharing.before(wanted);
        self.expressions.touched.extend(&kept);
        self.items_of(&kept)
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
    pub(super) fn value_of_everyone(&mut self, value: &ast::Expr, cx: &Context) -> Expr {
        let mut outside = Context::new(cx.stage, cx.damaged);
        outside.locals = cx.locals.iter().map(Local::hidden).collect();
        let read = self.expressions.read.clone();
        let value = self.expressions.infer(value, &mut outside);
        // What it reads is asked for when it is read itself.
        self.expressions.read = read;
        value
    }

    /// The type of what a variable is read as.
    pub(super) fn type_of_variable(variable: &ast::Variable, item: Ty) -> Ty {
        if variable.size.is_some() { Ty::List(Box::new(item)) } else { item }
    }
}

/// The name that a clause gives to something.
fn named_by(clause: &ActuationClause) -> Option<&Name> {
    match clause {
        ActuationClause::Variable(variable) => Some(&variable.name),
        ActuationClause::Let(name, _) => Some(name),
        ActuationClause::State(state) => Some(&state.name),
        ActuationClause::Action(action) => Some(&action.name),
        ActuationClause::Drive(..) => None,
    }
}
