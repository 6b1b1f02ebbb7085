//! Declarations: a file checks each kind, and gives what it comes to; none if something is wrong.

mod actuations;
mod actuators;
mod blocks;
mod constructions;
mod everyones;
mod examples;
mod extent;
mod fields;
mod items;
mod joints;
mod lattice;
mod learners;
mod lets;
mod loops;
mod methods;
mod models;
mod novelty;
mod observe;
mod parts;
mod phases;
mod policies;
pub(in crate::types) mod rules;
mod scenarios;
mod searches;
mod sensors;
pub(super) mod singles;
mod states;
mod targets;
pub(super) mod tasks;
pub(super) mod usual;

use indexmap::{IndexMap, IndexSet};

use super::Idle;
use super::environment::Environment;
use super::expressions::Expressions;
use crate::diagnostics::Diagnostic;
use crate::ir::{self, RuleSet};
use crate::names::{Declaration, declared};
use crate::source::Span;
use crate::syntax::ast::{Item, ItemKind, Name};
use crate::syntax::declarations::BlockKind;

/// What declarations come to that others know by their names: those that a grammar uses.
#[derive(Default)]
pub(super) struct Named {
    pub(super) terms: IndexMap<String, ir::Term>,
    patterns: IndexMap<String, ir::Expr>,
    pub(super) parts: IndexMap<String, ir::Part>,
    pub(super) actuators: IndexMap<String, ir::Actuator>,
    pub(super) actuations: IndexMap<String, ir::Actuation>,
    pub(super) sensors: IndexMap<String, ir::Sensor>,
    pub(super) states: IndexMap<String, ir::BodyState>,
    pub(super) policies: IndexMap<String, ir::Policy>,
    scenarios: IndexMap<String, ir::Scenarios>,
}

impl Named {
    /// A rule set of these, and otherwise of nothing.
    pub(super) fn rule_set(self, name: &str, objective: ir::Objective, search: ir::Search) -> RuleSet {
        RuleSet {
            version: ir::VERSION,
            name: name.to_owned(),
            params: IndexMap::new(),
            enumerations: IndexMap::new(),
            parts: self.parts,
            actuators: self.actuators,
            patterns: self.patterns,
            symmetry: ir::Symmetry::None,
            begin: Vec::new(),
            lattice: None,
            rules: Vec::new(),
            always: Vec::new(),
            fallbacks: Vec::new(),
            requirements: Vec::new(),
            preferences: Vec::new(),
            examples: IndexMap::new(),
            sensors: self.sensors,
            states: self.states,
            policies: self.policies,
            actuations: self.actuations,
            tasks: IndexMap::new(),
            targets: IndexMap::new(),
            prototypes: IndexMap::new(),
            scenarios: self.scenarios,
            observed: Vec::new(),
            novelties: IndexMap::new(),
            terms: self.terms,
            objective,
            beside: Vec::new(),
            search,
            from: None,
        }
    }
}

/// Keeps what a declaration comes to; whether it comes to something.
fn keep<T>(among: &mut IndexMap<String, T>, name: &Name, checked: Option<T>) -> bool {
    checked.map(|checked| among.insert(name.text.clone(), checked)).is_some()
}

/// Checks declarations.
pub(super) struct Declarations<'a> {
    pub(super) environment: &'a Environment<'a>,
    pub(super) expressions: Expressions<'a>,
    /// Rules in which something is wrong: what they match and choose is not certain.
    faulty: IndexSet<Span>,
    /// What sound rules call the parts that they make: an example may read it where the rule does not.
    products: Vec<Name>,
    /// Names that several blocks of a rule give: the first place, and another.
    shared_names: Vec<(Span, Span)>,
    /// Whether the text has several grammars and variants: each may leave to the others what it does not use.
    several: bool,
    /// What is not used, of a text with several grammars.
    pub(super) idle: Idle,
}

impl<'a> Declarations<'a> {
    pub(super) fn new(expressions: Expressions<'a>) -> Self {
        let first = expressions.environment.program.modules.first();
        Self {
            environment: expressions.environment,
            expressions,
            faulty: IndexSet::new(),
            products: Vec::new(),
            shared_names: Vec::new(),
            several: first.is_some_and(|module| crate::names::offers(&module.tree).len() > 1),
            idle: Idle::default(),
        }
    }

    /// Warns of what nothing uses; where the text has several grammars, once none of them does.
    pub(super) fn report_unused(&mut self, unused: Vec<Diagnostic>) {
        if self.several {
            self.idle.unused.extend(unused);
        } else {
            unused.into_iter().for_each(|warning| self.report(warning));
        }
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

    /// Checks a declaration and keeps what it comes to, if others know that by its name; whether it is sound.
    pub(super) fn check_named(&mut self, item: &Item, found: &mut Named) -> bool {
        let damaged = item.damaged;
        let Some(own) = declared(item) else { return true };
        match &item.kind {
            // The compiler asks for a block that is not told here.
            ItemKind::Block(kind, block) => match kind {
                BlockKind::Part => keep(&mut found.parts, own, self.part(block, damaged)),
                BlockKind::Actuator => keep(&mut found.actuators, own, self.actuator(block, damaged)),
                BlockKind::Scenarios => keep(&mut found.scenarios, own, self.scenarios(block, damaged)),
                BlockKind::Policy => keep(&mut found.policies, own, self.policy(block, damaged)),
                // What has one of these says what it comes to.
                BlockKind::Cell | BlockKind::Model | BlockKind::Search => true,
            },
            ItemKind::Actuation { name, binder, kind, clauses } => {
                let actuation = self.actuation(name, binder, kind, clauses, damaged);
                keep(&mut found.actuations, own, actuation)
            }
            ItemKind::Sense(sense) => keep(&mut found.sensors, own, self.sensor(sense, damaged)),
            ItemKind::State(of_body) => keep(&mut found.states, own, self.body_state(of_body, damaged)),
            ItemKind::Pattern(_, value) => {
                keep(&mut found.patterns, own, Some(self.fixed_pattern(value, damaged)))
            }
            ItemKind::Term(_, ty, value) => {
                let (ty, value) = self.term(ty, value, damaged);
                keep(&mut found.terms, own, Some(ir::Term { ty, value, span: own.span }))
            }
            _ => true,
        }
    }

    fn check_own(&mut self, declaration: Declaration, item: &Item) {
        let before = self.expressions.touched.len();
        self.check_named(item, &mut Named::default());
        if matches!(item.kind, ItemKind::State(_)) {
            // That states follow from each other does not mean that something uses them.
            let program = self.environment.program;
            let is_state = |d: &&Declaration| {
                program.item(**d).is_some_and(|item| matches!(item.kind, ItemKind::State(_)))
            };
            let touched = &mut self.expressions.touched;
            let states: Vec<Declaration> = touched.iter().skip(before).filter(is_state).copied().collect();
            for state in states {
                touched.shift_remove(&state);
            }
        }
        match &item.kind {
            ItemKind::Shared(variable) => self.everyones_own(variable, item.damaged),
            ItemKind::Block(BlockKind::Cell, block) => drop(self.cell(block, item.damaged)),
            ItemKind::Block(BlockKind::Model, block) => drop(self.model(block, None, item.damaged)),
            ItemKind::Block(BlockKind::Search, block) => drop(self.search(block, item.damaged)),
            ItemKind::Table(table) => drop(self.expressions.table(table, item.damaged)),
            ItemKind::Target { block, backend, kind } => {
                drop(self.target(block, backend, kind, item.damaged));
            }
            ItemKind::Prototype(block, backend) => drop(self.prototype(block, backend, item.damaged)),
            ItemKind::Observe(names) => drop(self.observed(names)),
            ItemKind::Novelty(name, clauses) => drop(self.novelty(name, clauses, item.damaged)),
            ItemKind::Let(_, None, value) if self.environment.sharing.reads(declaration) => {
                self.expressions.own_body(declaration, &[], value);
            }
            ItemKind::Let(_, None, value) => drop(self.expressions.inline(declaration, value)),
            ItemKind::Let(_, Some(parameters), value) => {
                self.distinct(parameters.iter().map(|p| &p.name), "parameter");
                self.expressions.own_body(declaration, parameters, value);
            }
            ItemKind::Enum(name, values) => self.enumeration(name, values),
            ItemKind::Record(name, fields) => {
                self.distinct(fields.iter().map(|f| &f.typed.name), "field");
                // That a record is read to be checked does not mean that something uses it.
                let used = self.expressions.touched.contains(&declaration);
                self.expressions.type_named(name);
                self.expressions.check_defaults(declaration, fields);
                if !used {
                    self.expressions.touched.shift_remove(&declaration);
                }
            }
            _ => {}
        }
    }
}
