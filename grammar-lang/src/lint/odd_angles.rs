//! Angles that hardly anybody means: a part that is turned by next to nothing or by many turns, and a value of a set that is far from the others.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{Choice, Effect, Expr, ExprKind};
use crate::units::{Dimension, shown};

use super::known::Known;

/// A part is not turned by less, rad, nor by more than a turn.
const LITTLE: f64 = 0.5 * std::f64::consts::PI / 180.0;
const MUCH: f64 = 2.0 * std::f64::consts::PI + 1e-9;
/// Of the values of a set, none is so many times smaller than the next.
const APART: f64 = 200.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let placed = ruleset.begin.iter().filter_map(|placed| placed.on.as_ref());
    let attached =
        ruleset.rules.iter().flat_map(|rule| Effect::single(&rule.effects)).filter_map(
            |effect| match effect {
                Effect::Attach { on, .. } => Some(on),
                _ => None,
            },
        );
    for turned in placed.chain(attached).filter_map(|on| on.turned.as_ref()) {
        let Some(Value::Number(angle)) = known.fixed(turned) else { continue };
        if angle != 0.0 && (angle.abs() < LITTLE || angle.abs() > MUCH) {
            findings.push(
                Diagnostic::new(Code::UNUSUAL, turned.span, "parts are hardly ever turned by such an angle")
                    .label(format!("this is {}", shown(angle, Dimension::ANGLE)))
                    .help("is the unit right? A quarter of a turn is `90 deg`"),
            );
        }
    }
    for choice in ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        findings.extend(far_from_others(known, choice));
    }
}

/// A value of a set of quantities that is far smaller than all others.
fn far_from_others(known: &Known<'_>, choice: &Choice) -> Option<Diagnostic> {
    let ExprKind::Set(items) = &choice.domain.kind else { return None };
    let size = |item: &'_ Expr| match known.fixed(item) {
        Some(Value::Number(x)) if x != 0.0 => Some(x.abs()),
        _ => None,
    };
    let mut sizes: Vec<(f64, &Expr)> = items.iter().filter_map(|item| Some((size(item)?, item))).collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(least, lone), (next, other), ..] = sizes.as_slice() else { return None };
    let dimension = lone.ty.dimension().filter(|dimension| *dimension != Dimension::NUMBER)?;
    (*next > APART * least).then(|| {
        Diagnostic::new(
            Code::UNUSUAL,
            lone.span,
            format!("a value of `{}` is far smaller than the others", choice.name),
        )
        .label(format!("this is {}", shown(*least, dimension)))
        .also(other.span, format!("this is {}", shown(*next, dimension)))
        .help("is the unit right?")
    })
}
