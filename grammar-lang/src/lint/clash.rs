//! Requirements that exclude each other: the smallest sets of them.

use std::cmp::Reverse;

use crate::bounds::linear::{Row, connected, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Requirement;

use super::counts::Counts;
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut counts = Counts::new(known);
    let all: Vec<_> = known.ruleset.requirements.iter().map(|r| (r, counts.rows(&r.condition))).collect();
    let mut clashes = Vec::new();
    for mut group in groups(counts.base(), &all) {
        // Sets that share no requirement are told one by one.
        while let Some(clash) = group.smallest() {
            group.open.retain(|(number, _)| !clash.contains(number));
            clashes.push(clash);
        }
    }
    // Of several, the one that begins last in the text comes first.
    clashes.sort_by_key(|clash| Reverse(clash.first().copied()));
    findings.extend(clashes.iter().map(|clash| report(&named(clash, &all))));
}

/// A smallest set of requirements that exclude each other, if what always holds allows them one by one.
pub(super) fn one<'r>(base: &[Row], all: &[(&'r Requirement, Vec<Row>)]) -> Option<Vec<&'r Requirement>> {
    if contradictory(base) {
        return None;
    }
    let clashes = groups(base, all).into_iter().filter_map(|group| group.smallest());
    clashes.max_by_key(|clash| clash.first().copied()).map(|clash| named(&clash, all))
}

/// Requirements by their numbers.
fn named<'r>(clash: &[usize], all: &[(&'r Requirement, Vec<Row>)]) -> Vec<&'r Requirement> {
    clash.iter().filter_map(|i| all.get(*i)).map(|(requirement, _)| *requirement).collect()
}

/// Requirements that have to do with each other.
struct Group<'a> {
    /// What always holds of what they are about.
    base: Vec<&'a Row>,
    /// Their numbers, in the order of the text, and what they say.
    open: Vec<(usize, &'a [Row])>,
}

fn groups<'a>(base: &'a [Row], all: &'a [(&Requirement, Vec<Row>)]) -> Vec<Group<'a>> {
    let rows = all.iter().map(|(_, rows)| rows.as_slice());
    let sets: Vec<&[Row]> = rows.chain(base.iter().map(std::slice::from_ref)).collect();
    let group = |numbers: Vec<usize>| {
        let sets = numbers.into_iter().filter_map(|i| Some((i, *sets.get(i)?)));
        let (open, base): (Vec<_>, Vec<_>) = sets.partition(|(i, _)| *i < all.len());
        Group { base: base.into_iter().flat_map(|(_, rows)| rows).collect(), open }
    };
    connected(&sets).into_iter().map(group).filter(|group| !group.open.is_empty()).collect()
}

impl Group<'_> {
    /// A set that excludes each other, and none of which can be left out: of several, that which
    /// begins last. Gives their numbers.
    fn smallest(&self) -> Option<Vec<usize>> {
        let mut kept: Vec<(usize, &[Row])> = Vec::new();
        let mut from = 0;
        let excluded = |kept: &[(usize, &[Row])], from: usize| {
            let left = self.open.get(from..).unwrap_or(&[]);
            let rows = kept.iter().chain(left).flat_map(|(_, rows)| *rows).chain(self.base.iter().copied());
            contradictory(&rows.cloned().collect::<Vec<_>>())
        };
        if !excluded(&kept, from) {
            return None;
        }
        while !excluded(&kept, self.open.len()) {
            // All before the last without which nothing is excluded can be left out.
            let mut beyond = self.open.len();
            while from + 1 < beyond {
                let middle = from.midpoint(beyond);
                if excluded(&kept, middle) {
                    from = middle;
                } else {
                    beyond = middle;
                }
            }
            kept.extend(self.open.get(from).copied());
            from += 1;
        }
        Some(kept.into_iter().map(|(number, _)| number).collect()).filter(|kept: &Vec<_>| !kept.is_empty())
    }
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
            .help("no design can have this number of these parts: relax the requirement");
    }
    let message = match clash.len() {
        2 => format!("{} cannot both hold", listed(clash)),
        _ => format!("{} cannot all hold", listed(clash)),
    };
    let mut finding = Diagnostic::new(Code::CLASH, span, message).label("one of the clashing requirements");
    for (i, requirement) in clash.iter().enumerate().skip(1) {
        let last = i + 1 == clash.len();
        finding = finding
            .also(requirement.condition.span, if last { "the last of them" } else { "another one of them" });
    }
    finding.help("relax one of them: the others could then hold")
}
