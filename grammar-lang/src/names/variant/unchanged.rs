//! Edits that leave a value as it is.

use crate::diagnostics::{Code, Diagnostic};
use crate::syntax::ast::{Block, Expr, ExprKind, Field, Item, ItemKind, Name};
use crate::units;

/// An edit that leaves a value as it is.
pub(super) struct Unchanged {
    /// What there is to say of it.
    pub(super) told: Diagnostic,
    /// Whether the value is of the standard library: a grammar may say a value of it that it relies on.
    pub(super) is_library: bool,
}

/// A finding if an edit sets what a path names to the value that it has in the base already.
pub(super) fn check(item: &Item, path: &[Name], new: &Expr) -> Option<Diagnostic> {
    let (_, rest) = path.split_first()?;
    let old = match &item.kind {
        ItemKind::Param(param) if rest.is_empty() => param.default.as_ref()?,
        kind => in_block(kind.block()?, rest)?,
    };
    if !same(old, new) {
        return None;
    }
    let whole: Vec<&str> = path.iter().map(|name| name.text.as_str()).collect();
    let told = format!("`{}` has this value already", whole.join("."));
    Some(
        Diagnostic::new(Code::POINTLESS, new.span, told)
            .label("changes nothing")
            .also(old.span, "the same value")
            .help("set another value, or take the edit out"),
    )
}

/// The value of a field of a block, or the default of a parameter of it.
fn in_block<'b>(block: &'b Block, rest: &[Name]) -> Option<&'b Expr> {
    let (name, within) = rest.split_first()?;
    block.fields.iter().find_map(|field| match field {
        Field::Value(known, value) if known.text == name.text && within.is_empty() => Some(value),
        Field::Param(param) if param.name.text == name.text && within.is_empty() => param.default.as_ref(),
        Field::Group(group) if group.name.text == name.text => in_block(group, within),
        _ => None,
    })
}

/// Whether two expressions are the same written value: numbers with units, and ranges and sets of them.
fn same(a: &Expr, b: &Expr) -> bool {
    let all = |a: &[Expr], b: &[Expr]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b));
    match (&a.kind, &b.kind) {
        (ExprKind::Quantity(x, in_x), ExprKind::Quantity(y, in_y)) => {
            let size = |unit: &Option<Name>| {
                unit.as_ref().map_or(Some((1.0, None)), |unit| {
                    units::parse(&unit.text).ok().map(|u| (u.factor, Some(u.dimension)))
                })
            };
            match (size(in_x), size(in_y)) {
                (Some((m, d)), Some((n, e))) => d == e && (x * m - y * n).abs() <= 1e-12 * (x * m).abs(),
                _ => false,
            }
        }
        (ExprKind::Bool(x), ExprKind::Bool(y)) => x == y,
        (ExprKind::Text(x), ExprKind::Text(y)) => x == y,
        (ExprKind::Negate(x), ExprKind::Negate(y)) => same(x, y),
        (ExprKind::Range(a, b), ExprKind::Range(c, d)) => same(a, c) && same(b, d),
        (ExprKind::Set(a), ExprKind::Set(b)) | (ExprKind::List(a), ExprKind::List(b)) => all(a, b),
        _ => false,
    }
}
