//! What a task says of its value before it is checked.

use crate::syntax::ast::{self, Item, ItemKind, Name};

/// Whether a task says what is wanted.
pub(super) fn has_objective(items: &[Item]) -> bool {
    items.iter().any(|item| matches!(item.kind, ItemKind::Objective { .. }))
}

/// The unit in which a task's value is told, if it has one.
pub(in crate::types) fn unit_of(items: &[Item]) -> Option<&Name> {
    items.iter().find_map(|item| match &item.kind {
        ItemKind::Objective { value, .. } => match &value.kind {
            ast::ExprKind::Convert(_, unit) => Some(unit),
            _ => None,
        },
        _ => None,
    })
}
