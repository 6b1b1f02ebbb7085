//! What expressions know of cells and lattices.

use super::Expressions;
use crate::ir::{Group, Ty};
use crate::source::Span;
use crate::syntax::ast::ItemKind;
use crate::syntax::declarations::BlockKind;

impl Expressions<'_> {
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
