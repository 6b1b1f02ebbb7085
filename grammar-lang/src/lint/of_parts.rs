//! What is asked of lattices although only bodies made of parts have it: a core, actuators.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, Lacking, lacking};
use crate::source::Span;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    if ruleset.lattice.is_none() {
        return;
    }
    let tasks = ruleset.tasks.values().flat_map(|task| task.objectives());
    let preferences = ruleset.preferences.iter().map(|preference| &preference.condition);
    let descriptors = ruleset.search.archive().into_iter().flat_map(|archive| archive.descriptors.values());
    let features = ruleset.novelties.values().flat_map(|novelty| novelty.features.values());
    let wanted = tasks
        .chain(ruleset.objectives())
        .map(|objective| &objective.value)
        .chain(preferences)
        .chain(descriptors.map(|descriptor| &descriptor.value))
        .chain(features.map(|feature| &feature.value))
        .map(|value| (value, value.span));
    let observed = ruleset.observed.iter().filter_map(|name| ruleset.terms.get(name));
    let mut told = Vec::new();
    for (value, place) in wanted.chain(observed.map(|term| (&term.value, term.span))) {
        if let Some(finding) = report(known, value, place)
            && !told.contains(&place)
        {
            told.push(place);
            findings.push(finding);
        }
    }
}

fn report(known: &Known<'_>, value: &Expr, place: Span) -> Option<Diagnostic> {
    let (what, term) = lacking(value, &known.ruleset.terms)?;
    let (message, help) = match what {
        Lacking::Core => (
            "reads the core, but a lattice has none: its first element may be any ball, so a body and its mirror image get different values",
            "read all elements instead, as `mean over e in elements of ...` does",
        ),
        Lacking::Actuators => (
            "reads the actuators, but a lattice has none: the sum is always zero",
            "leave it out: in a lattice, the cells are driven",
        ),
    };
    let term = term.and_then(|name| known.ruleset.terms.get_key_value(name));
    let who = term.map_or("this".to_owned(), |(name, _)| format!("`{name}`"));
    let finding = Diagnostic::new(Code::OF_PARTS, place, format!("{who} {message}"))
        .label("in a grammar with a lattice");
    let finding = match term.filter(|(_, term)| term.span != place) {
        Some((name, term)) => finding.also(term.span, format!("`{name}` is declared here")),
        None => finding,
    };
    Some(finding.help(help))
}
