//! Angles of a full turn or more among the choices of a rule: mostly degrees that were written as radians.

use std::f64::consts::PI;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind};
use crate::units::Dimension;

use super::known::Known;

/// One to four quarter turns in radians.
const QUARTERS: [f64; 4] = [0.5 * PI, PI, 1.5 * PI, 2.0 * PI];

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
        let in_radians = |item: &&Expr| {
            let degrees = known.numbers(item).single().map_or(0.0, |angle| angle.to_degrees().abs());
            QUARTERS.iter().any(|quarter| (degrees - quarter).abs() < 0.006)
        };
        if let Some(item) = of_angles.clone().find(in_radians).filter(|item| !is_told(item)) {
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    item.span,
                    format!("`{}` turns by as many degrees as a quarter turn has radians", choice.name),
                )
                .label("a quarter turn is `90 deg`")
                .help("is `rad` meant?"),
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
