//! Requirements that leave no room for a single part more than the initial design has.

use crate::bounds::linear::Row;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Requirement};

use super::clash::{listed, one};
use super::counts::Counts;
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let attaches = |e: &Effect| matches!(e, Effect::Attach { .. });
    let Some(rule) = ruleset.rules.iter().find(|rule| rule.effects.iter().any(attaches)) else { return };
    let mut counts = Counts::new(known);
    let all: Vec<(&Requirement, Vec<Row>)> =
        ruleset.requirements.iter().map(|r| (r, counts.rows(&r.condition))).collect();
    let mut base = counts.base().to_vec();
    base.extend(counts.begun());
    base.push(counts.parts_at_least(ruleset.begin.len() as f64 + 1.0));
    let Some(stops) = one(&base, &all) else { return };
    let Some(first) = stops.first() else { return };
    let verb = if stops.len() == 1 { "leaves" } else { "leave" };
    let mut finding = Diagnostic::new(
        Code::NO_ROOM,
        first.condition.span,
        format!("{} {verb} no room for anything but the initial design", listed(&stops)),
    )
    .label("no larger design fulfils this")
    .help("relax it, or remove the rules that attach parts");
    for other in stops.iter().skip(1) {
        finding = finding.also(other.condition.span, "together with this");
    }
    findings.push(finding.also(rule.span, "this rule attaches parts in vain"));
}
