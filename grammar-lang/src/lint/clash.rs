//! Requirements that exclude each other: the smallest sets of them.

use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Requirement, RuleSet};

use super::counts::Counts;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let mut counts = Counts::new(ruleset);
    let mut open: Vec<(&Requirement, Vec<Row>)> =
        ruleset.requirements.iter().map(|r| (r, counts.rows(&r.condition))).collect();
    let base = counts.base();
    // Sets that share no requirement are told one by one.
    while let Some(clash) = smallest(&base, &open) {
        findings.push(report(&clash));
        open.retain(|(r, _)| !clash.iter().any(|c| c.span == r.span && c.name == r.name));
    }
}

/// A set that excludes each other, and none of which can be left out.
pub(super) fn smallest<'r>(
    base: &[Row],
    all: &[(&'r Requirement, Vec<Row>)],
) -> Option<Vec<&'r Requirement>> {
    let excluded = |some: &[&(&Requirement, Vec<Row>)]| {
        let rows = some.iter().flat_map(|(_, rows)| rows).chain(base).cloned();
        contradictory(&rows.collect::<Vec<_>>())
    };
    let mut left: Vec<&(&'r Requirement, Vec<Row>)> =
        all.iter().filter(|(_, rows)| !rows.is_empty()).collect();
    if !excluded(&left) {
        return None;
    }
    for one in left.clone() {
        let fewer: Vec<_> = left.iter().copied().filter(|other| !std::ptr::eq(*other, one)).collect();
        if excluded(&fewer) {
            left = fewer;
        }
    }
    Some(left.into_iter().map(|(requirement, _)| *requirement).collect())
}

/// `a`, `a and b`, `a, b and c`, each in backquotes.
pub(super) fn listed(requirements: &[&Requirement]) -> String {
    let mut names: Vec<String> = requirements.iter().map(|r| format!("`{}`", r.name)).collect();
    match names.pop() {
        Some(last) if names.is_empty() => last,
        Some(last) => format!("{} and {last}", names.join(", ")),
        None => String::new(),
    }
}

fn report(clash: &[&Requirement]) -> Diagnostic {
    let span = clash.first().map(|r| r.condition.span).unwrap_or_default();
    if clash.len() < 2 {
        return Diagnostic::new(Code::CONSTANT_REQUIRE, span, format!("{} never holds", listed(clash)))
            .label("false for every design")
            .help("no design has that many, or that few, of these parts: relax it");
    }
    let message = match clash.len() {
        2 => format!("{} cannot both hold", listed(clash)),
        _ => format!("{} cannot all hold", listed(clash)),
    };
    let mut finding = Diagnostic::new(Code::CLASH, span, message).label("no design that fulfils this");
    for (i, requirement) in clash.iter().enumerate().skip(1) {
        let last = i + 1 == clash.len();
        finding =
            finding.also(requirement.condition.span, if last { "also fulfils this" } else { "and this" });
    }
    finding.help("relax one of them: the others could then hold")
}
