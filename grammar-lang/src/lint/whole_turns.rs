//! Angles of a full turn or more among the choices of a rule: mostly degrees that were written as radians.

use std::f64::consts::PI;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind};
use crate::units::Dimension;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for choice in known.ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        let ExprKind::Set(items) = &choice.domain.kind else { continue };
        let of_angles = items.iter().filter(|item| item.ty.dimension() == Some(Dimension::ANGLE));
        let beyond = of_angles.clone().filter_map(|item| {
            let angle = known.numbers(item).single()?;
            (angle.abs() > 2.0 * PI * (1.0 + 1e-9)).then_some((item, angle))
        });
        let full = |item: &&Expr| {
            known.numbers(item).single().is_some_and(|angle| (angle.abs() / (2.0 * PI) - 1.0).abs() < 1e-9)
        };
        let is_told = |item: &Expr| findings.iter().any(|known| known.span() == item.span);
        if let Some(item) = of_angles.clone().find(full).filter(|item| !is_told(item)) {
            findings.push(
                Diagnostic::new(Code::UNUSUAL, item.span, format!("`{}` may be a full turn", choice.name))
                    .label("this turns nothing")
                    .help("write `0 deg`, or leave it out"),
            );
            continue;
        }
        if let Some((item, angle)) = beyond.into_iter().next() {
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    item.span,
                    format!("`{}` turns by more than a full turn", choice.name),
                )
                .label(format!("{:.0} deg", angle.to_degrees()))
                .help("is the unit right? A full turn is `360 deg`"),
            );
        }
    }
}
