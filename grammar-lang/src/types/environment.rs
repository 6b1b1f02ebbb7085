//! What a check starts from: the program, and what holds of it before any expression is looked at.

use std::collections::BTreeSet;

use indexmap::{IndexMap, IndexSet};

use crate::ir;
use crate::names::{Declaration, Program};
use crate::source::SourceMap;
use crate::syntax::ast::{self, Item, ItemKind};
use crate::syntax::declarations::BlockKind;

/// What a check starts from. Nothing of it changes.
pub(super) struct Environment<'a> {
    pub(super) program: &'a Program,
    pub(super) sources: &'a SourceMap,
    /// The values that `-p NAME=VALUE` gives parameters.
    pub(super) overrides: &'a [(String, String)],
    /// What `begin` calls its parts, and what they are.
    pub(super) placed: IndexMap<&'a str, &'a ast::Expr>,
    /// The names of all ports that parts of the program have.
    pub(super) ports: IndexSet<String>,
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
            placed.entry(place.name.text.as_str()).or_insert(&place.what);
        }
        Self { program, sources, overrides, placed, ports: port_names(program) }
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
