//! What expressions know of cells and lattices.

use super::Expressions;
use crate::ir::{Group, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, ItemKind};
use crate::syntax::declarations::BlockKind;

impl Expressions<'_> {
    /// Whether the bodies of this grammar are lattices.
    pub(in crate::types) fn has_lattice(&self) -> bool {
        self.begins_with_cells()
            || self.environment.program.entries().any(|(_, item)| matches!(item.kind, ItemKind::Lattice(..)))
    }

    /// Whether the initial design fills places: then it is a lattice that is meant, even if it is not declared.
    pub(in crate::types) fn begins_with_cells(&self) -> bool {
        let fills = |item: &ast::Item| matches!(&item.kind, ItemKind::Begin(places, fills) if places.is_empty() && !fills.is_empty());
        self.environment.program.entries().any(|(_, item)| fills(item))
    }

    /// Whether a name means a kind of cell.
    pub(in crate::types) fn is_cell(&self, kind: &str, place: Span) -> bool {
        self.environment
            .program
            .lookup(place, kind)
            .is_some_and(|(_, item)| matches!(item.kind, ItemKind::Block(BlockKind::Cell, _)))
    }

    /// The type of what belongs to a group.
    pub(in crate::types) fn member_of(&self, group: &Group, place: Span) -> Ty {
        match group {
            Group::Actuator => Ty::Actuator,
            Group::Cell => Ty::Cell,
            Group::Kind(kind) if self.is_actuator(kind, place) => Ty::Actuator,
            Group::Kind(kind) if self.is_cell(kind, place) => Ty::Cell,
            _ => Ty::Part,
        }
    }

    /// The parameters that cells of the program have.
    pub(super) fn cell_params(&mut self) -> Vec<(String, Ty)> {
        let program = self.environment.program;
        let blocks = program.items().filter_map(|(_, item)| match &item.kind {
            ItemKind::Block(BlockKind::Cell, block) => Some(block),
            _ => None,
        });
        blocks.flat_map(|block| self.params_of(block)).collect()
    }
}
