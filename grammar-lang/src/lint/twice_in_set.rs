//! A value that stands twice in a set.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{Expr, ExprKind};

use super::known::Known;
use crate::units::Dimension;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for choice in known.ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        let ExprKind::Set(items) = &choice.domain.kind else { continue };
        // Numbers are looked up: an enumeration may have thousands of values.
        let mut numbers: BTreeMap<u64, &Expr> = BTreeMap::new();
        let mut others: Vec<(Value, &Expr)> = Vec::new();
        for item in items {
            let first = match known.fixed(item) {
                None => continue,
                // No minus before a zero, and no full turns.
                Some(Value::Number(x)) => match numbers.entry((within_a_turn(item, x) + 0.0).to_bits()) {
                    Entry::Occupied(first) => Some(*first.get()),
                    Entry::Vacant(place) => {
                        place.insert(item);
                        None
                    }
                },
                Some(value) => match others.iter().find(|(other, _)| *other == value) {
                    Some((_, first)) => Some(*first),
                    None => {
                        others.push((value, item));
                        None
                    }
                },
            };
            if let Some(first) = first {
                findings.push(
                    Diagnostic::new(
                        Code::TWICE_IN_SET,
                        item.span,
                        format!("`{}` has the same value twice", choice.name),
                    )
                    .label("again")
                    .also(first.span, "first here")
                    .help(
                        "leave it out; to draw it more often, give weights: `choose x in { a, b } by [2, 1]`",
                    ),
                );
            }
        }
    }
}

/// The same angle within a turn, but for rounding; any other number as it is.
fn within_a_turn(item: &Expr, x: f64) -> f64 {
    if item.ty.dimension() != Some(Dimension::ANGLE) {
        return x;
    }
    let degrees = (x.to_degrees() * 1e6).round() / 1e6;
    degrees.rem_euclid(360.0)
}
