//! Features of a novelty that are measured and not rounded: no two designs share them, so that every design is new.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Function, Ty};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let features = known.ruleset.novelties.values().flat_map(|novelty| &novelty.features);
    for (name, feature) in features {
        let rounds = |value: &Expr| {
            value.any(&mut |part| {
                matches!(
                    part.kind,
                    ExprKind::Call(Function::Floor | Function::Ceil | Function::Round, _) | ExprKind::If(..)
                )
            })
        };
        let term = match &feature.value.kind {
            ExprKind::Term(name) => known.ruleset.terms.get(name).map(|term| &term.value),
            _ => None,
        };
        let is_rounded = rounds(&feature.value) || term.is_some_and(rounds);
        if matches!(&feature.ty, Ty::Quantity(dimension) if !dimension.is_number()) && !is_rounded {
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    feature.value.span,
                    format!("the feature `{name}` is measured and not rounded"),
                )
                .label("hardly two designs share its value, so that each is new")
                .help("compare classes: write for example `round(length / 5 cm)`"),
            );
        }
    }
}
