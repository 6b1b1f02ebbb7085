//! Two preferences on the numbers of parts of which no design fulfils both.

use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{ExprKind, Preference};

use super::counts::Counts;
use super::known::Known;

/// Of more preferences than this, none is compared with the others.
const MOST: usize = 100;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let preferences = &known.ruleset.preferences;
    if preferences.len() > MOST {
        return;
    }
    let mut counts = Counts::new(known);
    // Whoever sets a parameter may let both hold.
    let mut limits: Vec<(&Preference, Vec<Row>)> = preferences
        .iter()
        .filter(|one| !one.condition.any(&mut |e| matches!(e.kind, ExprKind::Param(_))))
        .map(|one| (one, counts.rows(&one.condition)))
        .collect();
    let together = |rows: &[&[Row]]| [&[counts.base()], rows].concat().concat();
    limits.retain(|(_, rows)| !rows.is_empty() && !contradictory(&together(&[rows])));
    for (place, (later, rows)) in limits.iter().enumerate() {
        let rival = limits
            .iter()
            .take(place)
            .find(|(_, own)| contradictory(&[counts.base(), own.as_slice(), rows.as_slice()].concat()));
        let Some((first, _)) = rival else { continue };
        findings.push(
            Diagnostic::new(
                Code::UNUSUAL,
                later.condition.span,
                format!("no design fulfils both `{}` and `{}`", first.name, later.name),
            )
            .label("one of the two is always broken")
            .also(first.condition.span, "the other one")
            .help("take one of them out, or make them overlap: what both leave open costs twice"),
        );
    }
}
