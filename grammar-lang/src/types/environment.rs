//! What a check starts from: the program, and what holds of it before any expression is looked at.

use std::collections::{BTreeMap, BTreeSet};

use indexmap::{IndexMap, IndexSet};

use crate::ir;
use crate::names::{Declaration, Program, Sharing};
use crate::source::{SourceMap, Span};
use crate::syntax::ast::{self, Item, ItemKind, RuleClauseKind};
use crate::syntax::declarations::BlockKind;

/// What a check starts from. Nothing of it changes.
pub(super) struct Environment<'a> {
    pub(super) program: &'a Program,
    pub(super) sources: &'a SourceMap,
    /// The values that `-p NAME=VALUE` gives parameters.
    pub(super) overrides: &'a [(String, String)],
    /// What `begin` calls its parts, and what they are.
    pub(super) placed: IndexMap<&'a str, &'a ast::Place>,
    /// The names of all ports that parts of the program have.
    pub(super) ports: IndexSet<String>,
    /// Whether the initial design fills places: then it is a lattice that is meant, even if it is not declared.
    pub(super) begins_with_cells: bool,
    /// Whether the bodies of this grammar are lattices.
    pub(super) has_lattice: bool,
    /// What reads shared variables outside of actuations.
    pub(super) sharing: Sharing,
    /// The parameters of the grammar that its rules set, and where the first of them does.
    pub(super) set_by_rules: BTreeMap<Declaration, Span>,
    /// By the name of a parameter: the actuators of the program that have it.
    pub(super) param_owners: IndexMap<&'a str, Vec<&'a Item>>,
}

impl<'a> Environment<'a> {
    pub(super) fn of(
        program: &'a Program,
        sources: &'a SourceMap,
        overrides: &'a [(String, String)],
    ) -> Self {
        let mut placed = IndexMap::new();
        let places = program.entries().filter_map(|(_, item)| match &item.kind {
            ItemKind::Begin(places, _) => Some(places),
            _ => None,
        });
        for place in places.flatten() {
            placed.entry(place.name.text.as_str()).or_insert(place);
        }
        let fills = |item: &Item| matches!(&item.kind, ItemKind::Begin(places, fills) if places.is_empty() && !fills.is_empty());
        let begins_with_cells = program.entries().any(|(_, item)| fills(item));
        let declares = |item: &Item| matches!(item.kind, ItemKind::Lattice(..));
        let has_lattice = begins_with_cells || program.entries().any(|(_, item)| declares(item));
        let (ports, param_owners) = (port_names(program), param_owners(program));
        let sharing = Sharing::of(program);
        let mut environment = Self {
            program,
            sources,
            overrides,
            placed,
            ports,
            begins_with_cells,
            has_lattice,
            sharing,
            set_by_rules: BTreeMap::new(),
            param_owners,
        };
        environment.set_by_rules = environment.find_set_by_rules();
        environment
    }

    /// The parameters of the grammar that its rules set.
    fn find_set_by_rules(&self) -> BTreeMap<Declaration, Span> {
        let mut found = BTreeMap::new();
        for (_, item) in self.known() {
            let ItemKind::Rule(_, clauses) = &item.kind else { continue };
            for (name, span) in named_targets(clauses) {
                if let Some((declaration, of)) = self.program.lookup(span, name)
                    && matches!(of.kind, ItemKind::Param(_))
                {
                    found.entry(declaration).or_insert(span);
                }
            }
        }
        found
    }

    /// The declarations that the grammar has or imports by name; of a variant those of its base, too.
    pub(super) fn known(&self) -> impl Iterator<Item = (Declaration, &'a Item)> + use<'a> {
        let program = self.program;
        let imported =
            program.own.iter().filter_map(|m| program.modules.get(*m)).flat_map(|m| m.scope.values());
        let all: BTreeSet<Declaration> =
            imported.copied().chain(program.entries().map(|(declaration, _)| declaration)).collect();
        let there = all.into_iter().filter(|declaration| !program.dropped.contains_key(declaration));
        there.filter_map(|declaration| Some((declaration, program.item(declaration)?)))
    }
}

/// What clauses set by its name alone, and where.
fn named_targets(clauses: &[ast::RuleClause]) -> Vec<(&str, Span)> {
    let named = clauses.iter().flat_map(|clause| match &clause.kind {
        RuleClauseKind::Set { target, .. } => match &target.kind {
            ast::ExprKind::Name(name) => vec![(name.as_str(), target.span)],
            _ => Vec::new(),
        },
        RuleClauseKind::Repeat { clauses, .. } => named_targets(clauses),
        _ => Vec::new(),
    });
    named.collect()
}

/// The parts and actuators of a program by the parameters that they have.
fn param_owners(program: &Program) -> IndexMap<&str, Vec<&Item>> {
    let mut owners: IndexMap<&str, Vec<&Item>> = IndexMap::new();
    for (_, item) in program.items() {
        let ItemKind::Block(BlockKind::Actuator | BlockKind::Part, block) = &item.kind else { continue };
        let names: IndexSet<&str> = block.fields.iter().filter_map(param_name).collect();
        for name in names {
            owners.entry(name).or_default().push(item);
        }
    }
    owners
}

fn param_name(field: &ast::Field) -> Option<&str> {
    match field {
        ast::Field::Param(param) => Some(&param.name.text),
        _ => None,
    }
}

/// The names of all ports that parts of a program have.
fn port_names(program: &Program) -> IndexSet<String> {
    let built_in = ir::BLOCK_PORTS.iter().chain(ir::ACTUATOR_PORTS).map(|p| (*p).to_owned());
    let fields = program.items().filter_map(|(_, item)| match &item.kind {
        ItemKind::Block(BlockKind::Part, block) => Some(&block.fields),
        _ => None,
    });
    let declared = fields.flatten().filter_map(|f| match f {
        ast::Field::Port(port) => Some(port.name.text.clone()),
        _ => None,
    });
    built_in.chain(declared).collect()
}
