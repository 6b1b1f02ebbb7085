//! Checks what is observed: terms whose values are written beside that of each body.

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Ty};
use crate::names::declared;
use crate::source::Span;
use crate::syntax::ast::{ItemKind, Name};
use indexmap::IndexMap;

/// A term that is observed.
pub(in crate::types) struct Observed {
    /// Its name, where that is said.
    pub(in crate::types) name: Name,
    /// Whether the grammar says so, not a module that it uses.
    is_own: bool,
}

impl Declarations<'_> {
    /// The terms among some names.
    pub(super) fn observed(&mut self, names: &[Name]) -> Vec<Name> {
        let mut terms: Vec<Name> = Vec::new();
        for name in names {
            if let Some(first) = terms.iter().find(|n| n.text == name.text) {
                self.observed_twice(name, first.span);
                continue;
            }
            let Some(ItemKind::Term(_, ty, _)) =
                self.named(name, "term", |k| matches!(k, ItemKind::Term(..)))
            else {
                continue;
            };
            let place = ty.span;
            match self.expressions.type_named(ty) {
                ty if ty.dimension().is_some() => terms.push(name.clone()),
                Ty::Bool | Ty::Enum(_) => terms.push(name.clone()),
                Ty::Unknown => {}
                ty => self.report(
                    Diagnostic::new(
                        Code::WRONG_TYPE,
                        name.span,
                        "only a quantity, a Count, a Bool or a value of an enumeration can be observed",
                    )
                    .label(format!("this is {}", crate::types::expressions::fit::article(&ty)))
                    .also(place, "declared here")
                    .help("observe a number that you compute from it, such as `height(...)`"),
                ),
            }
        }
        terms
    }

    /// What the grammar observes, then what the modules observe that it uses, unless it uses the name for
    /// something else.
    pub(in crate::types) fn all_observed(&mut self) -> Vec<Observed> {
        let program = self.environment.program;
        let mut all: Vec<Observed> = Vec::new();
        for declaration in program.observing() {
            let Some(ItemKind::Observe(names)) = program.item(declaration).map(|item| &item.kind) else {
                continue;
            };
            let is_own = program.own.contains(&declaration.module);
            let taken = |name: &Name| {
                program.items().any(|(other, item)| {
                    let meant = program.lookup(name.span, &name.text).map(|(meant, _)| meant);
                    declared(item).is_some_and(|own| own.text == name.text) && meant != Some(other)
                })
            };
            let names: Vec<Name> = names.iter().filter(|name| is_own || !taken(name)).cloned().collect();
            for name in self.observed(&names) {
                match all.iter().find(|one| one.name.text == name.text) {
                    Some(first) if is_own => self.observed_twice(&name, first.name.span),
                    Some(_) => {}
                    None => all.push(Observed { name, is_own }),
                }
            }
        }
        all
    }

    /// The names of what is observed. What a module observes is left out where it means nothing: of a lattice, what
    /// reads the core or the actuators.
    pub(in crate::types) fn names_observed(
        observed: Vec<Observed>,
        terms: &IndexMap<String, ir::Term>,
        is_lattice: bool,
    ) -> Vec<String> {
        let means_nothing = |one: &Observed| {
            let term = terms.get(&one.name.text);
            !one.is_own && is_lattice && term.is_some_and(|term| ir::lacking(&term.value, terms).is_some())
        };
        observed.into_iter().filter(|one| !means_nothing(one)).map(|one| one.name.text).collect()
    }

    fn observed_twice(&mut self, name: &Name, first: Span) {
        self.report(
            Diagnostic::new(Code::DUPLICATE, name.span, format!("`{}` is observed twice", name.text))
                .label("again")
                .also(first, "the first time")
                .help("keep one of them"),
        );
    }
}
