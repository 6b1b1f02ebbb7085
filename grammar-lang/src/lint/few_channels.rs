//! Targets with fewer channels than a design can have actuators.

use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Group;

use super::counts::Counts;
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    if known.ruleset.targets.is_empty() {
        return;
    }
    let mut counts = Counts::new(known);
    let mut rows: Vec<Row> = Vec::new();
    let mut either = Vec::new();
    for requirement in &known.ruleset.requirements {
        rows.extend(counts.rows(&requirement.condition));
        either.push(counts.alternatives(&requirement.condition));
    }
    rows.extend(counts.base().iter().cloned());
    for (name, target) in &known.ruleset.targets {
        let channels = target.backend.channels();
        let word = if channels == 1 { "channel" } else { "channels" };
        if !known.possible.contains(&Group::Kind(target.kind.clone())) {
            continue;
        }
        let Some(more) = counts.kind_at_least(&target.kind, channels as f64 + 1.0) else { continue };
        rows.push(more);
        // Of what a requirement lets choose from, each may exclude it for a reason of its own.
        let excludes = |own: &Vec<Row>| contradictory(&[rows.as_slice(), own.as_slice()].concat());
        if !contradictory(&rows) && !either.iter().any(|alternatives| alternatives.iter().all(excludes)) {
            findings.push(
                Diagnostic::new(
                    Code::FEW_CHANNELS,
                    target.span,
                    format!(
                        "`{name}` has {channels} {word} for `{}`, but no requirement was found that excludes designs with more",
                        target.kind
                    ),
                )
                .label("too few channels")
                .help(format!("add `require count({}) <= {channels}`, or name more pins", target.kind)),
            );
        }
        rows.pop();
    }
}
