//! Angles of more than a full turn among the choices of a rule: mostly degrees that were written as radians.

use std::f64::consts::PI;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::ExprKind;
use crate::units::Dimension;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for choice in known.ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        let ExprKind::Set(items) = &choice.domain.kind else { continue };
        let of_angles = items.iter().filter(|item| item.ty.dimension() == Some(Dimension::ANGLE));
        let beyond = of_angles.filter_map(|item| {
            let angle = known.numbers(item).single()?;
            (angle.abs() > 2.0 * PI * (1.0 + 1e-9)).then_some((item, angle))
        });
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
