//! Choices among patterns of which two are the same, or one never changes.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Ty, Word};
use crate::units::Dimension;

use super::known::Known;

/// Patterns are compared at so many places of the cycle.
const PLACES: usize = 32;
/// More patterns than this are not compared.
const MOST: usize = 64;
/// Values that differ by less are the same, in SI units.
const SAME: f64 = 1e-9;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for choice in known.ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        let (ExprKind::Set(items) | ExprKind::List(items)) = &choice.domain.kind else { continue };
        if items.len() > MOST || items.iter().any(|item| item.ty != Ty::Pattern) {
            continue;
        }
        let values: Vec<Option<Vec<f64>>> = items.iter().map(|item| samples(known, item)).collect();
        for (item, values) in items.iter().zip(&values) {
            findings.extend(
                values
                    .as_ref()
                    .and_then(|values| constant(known, item, values))
                    .filter(|told| findings.iter().all(|known| known.span() != told.span())),
            );
        }
        let repeated = (1..items.len()).find_map(|later| {
            let own = values[later].as_ref().filter(|own| !is_constant(own))?;
            let first =
                (0..later).find(|first| values[*first].as_ref().is_some_and(|other| are_same(own, other)))?;
            Some((&items[first], &items[later]))
        });
        if let Some((first, later)) = repeated {
            // The same name twice is told as such.
            if first.kind != later.kind {
                findings.push(
                    Diagnostic::new(
                        Code::SAID_TWICE,
                        later.span,
                        format!("this pattern of `{}` is the same as another one", choice.name),
                    )
                    .label("it has the same values in the whole cycle")
                    .also(first.span, "as this one")
                    .help("a pattern that is late by a whole cycle is the same pattern: half a cycle is `1 / 2`"),
                );
            }
        }
    }
}

/// A warning for a pattern that reads where in the cycle it is, and has the same value everywhere.
fn constant(known: &Known<'_>, item: &Expr, values: &[f64]) -> Option<Diagnostic> {
    let ExprKind::Pattern(name) = &item.kind else { return None };
    let pattern = known.ruleset.patterns.get(name)?;
    let reads_cycle = pattern.any(&mut |part| matches!(part.kind, ExprKind::Word(Word::Cycle)));
    // Of a pattern that is made of another one, that one is told.
    let is_made = pattern.any(&mut |part| matches!(part.kind, ExprKind::Pattern(_)));
    (reads_cycle && !is_made && is_constant(values)).then(|| {
        Diagnostic::new(Code::UNUSUAL, pattern.span, format!("the pattern `{name}` never changes"))
            .label("the same value in the whole cycle")
            .help("`cycle` runs from 0 to 1: half of it is `cycle < 1 / 2`")
    })
}

fn samples(known: &Known<'_>, pattern: &Expr) -> Option<Vec<f64>> {
    let at = |place: usize| {
        let expr = |kind, ty| Expr { kind, ty, span: pattern.span };
        let place = expr(ExprKind::Number(place as f64 / PLACES as f64), Ty::Quantity(Dimension::NUMBER));
        let applied =
            expr(ExprKind::Apply(Box::new(pattern.clone()), Box::new(place)), Ty::Quantity(Dimension::ANGLE));
        known.value(&applied).ok()?.as_number()
    };
    (0..PLACES).map(at).collect()
}

fn is_constant(values: &[f64]) -> bool {
    values.iter().all(|value| (value - values[0]).abs() < SAME)
}

fn are_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME)
}
