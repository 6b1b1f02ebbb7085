//! What actuations share that is declared outside of them: `shared` variables, and values that read some.

use indexmap::IndexSet;

use super::Declarations;
use super::lets::Lets;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Expr, Ty};
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast::{self, ActuationClause, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
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
        let is_shared = |(declaration, item): &(Declaration, &ast::Item)| {
            let reads = match &item.kind {
                ItemKind::Shared(_) => true,
                // Who reads a state has the variables that it comes from, and so has whom a policy decides for that reads one.
                ItemKind::Let(_, None, _) | ItemKind::State(_) | ItemKind::Block(BlockKind::Policy, _) => {
                    self.environment.sharing.reads(*declaration)
                }
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

    /// Where the name is declared that a name means.
    pub(super) fn declared_at(&self, name: &Name) -> Option<Span> {
        let (_, item) = self.environment.program.lookup(name.span, &name.text)?;
        crate::names::declared(item).map(|name| name.span)
    }

    /// What a state of the robot or of its parts reads that is shared.
    pub(super) fn everyones_of(&mut self, state: &Name) -> Everyones<'a> {
        let declaration = self.environment.program.lookup(state.span, &state.text).map(|(own, _)| own);
        let read = declaration.map(|own| self.environment.sharing.read_by(own)).unwrap_or_default();
        let kept = self.environment.sharing.before(read);
        self.expressions.touched.extend(&kept);
        self.items_of(&kept)
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
                    .also(name.span, "the other: a value or function of that file reads it")
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

    /// The shared variables that an actuation or a state reads, each with the next local slot.
    pub(super) fn variables_of_everyone(
        &mut self,
        everyones: &Everyones<'_>,
        cx: &mut Context,
    ) -> Vec<ir::Variable> {
        let mut variables = Vec::new();
        for variable in everyones.variables() {
            let checked = self.variable(variable, cx);
            let item = checked.as_ref().map_or(Ty::Unknown, |v| v.ty.clone());
            let ty = Self::type_of_variable(variable, item);
            // It is known by its declaration: its name may mean something else here.
            cx.locals.push(Local::new("", ty, variable.name.span));
            variables.extend(checked.map(|v| ir::Variable { owner: ir::Owner::Everyone, ..v }));
        }
        variables
    }

    /// The values outside of it that an actuation or a state reads, each with the next local slot.
    pub(super) fn values_of_everyone(
        &mut self,
        everyones: &Everyones<'_>,
        cx: &mut Context,
        values: &mut Lets,
    ) {
        let mut outside = Context::new(cx.stage, cx.damaged);
        outside.locals = cx.locals.iter().map(Local::hidden).collect();
        for (name, value) in everyones.values() {
            let value = self.value_of_everyone(value, &mut outside);
            // It is known by its declaration: its name may mean something else here.
            let local = Local::new("", value.ty.clone(), name.span);
            outside.locals.push(local.clone());
            cx.locals.push(local);
            values.add(name, value);
        }
    }

    /// A value that is declared outside of what reads it: it knows no name of that.
    fn value_of_everyone(&mut self, value: &ast::Expr, outside: &mut Context) -> Expr {
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
