//! A search that has nothing to change: no rule for its loop over bodies, no varied quantity, or no actuator that has one.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{ExprKind, Group};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let is_driven = ruleset.tasks.values().any(|task| !task.actuated.is_empty());
    if let Some(lattice) = ruleset.lattice.as_ref().filter(|_| !is_driven) {
        findings.push(
            Diagnostic::new(Code::NOTHING_TO_SEARCH, lattice.span, "nothing moves: no cell is driven")
                .label("its bodies only fall and lie still")
                .help("write for example `actuate soft with wave`, with an actuation that drives `strain`"),
        );
    }
    let Some(core) = ruleset.begin.first() else { return };
    let used = ruleset.tasks.values().flat_map(|task| task.actuated.values());
    let varied = used
        .filter_map(|name| ruleset.actuations.get(name))
        .any(|a| !a.variables.is_empty() || !a.actions.is_empty());
    let told = |label: &str, help: &str| {
        Diagnostic::new(Code::NOTHING_TO_SEARCH, core.span, "there is nothing to search")
            .label(label)
            .help(help)
    };
    let (bodies, curves) = (ruleset.search.bodies.is_some(), ruleset.search.curves.is_some());
    if ruleset.rules.is_empty() && !varied {
        findings.push(told(
            "the only design, and nothing in it varies",
            "add a rule, or an actuation with a `vary` clause",
        ));
    } else if ruleset.rules.is_empty() && bodies && (!curves || !has_actuators(known)) {
        findings.push(told(
            "the only design: no rule changes it",
            "add a rule, or search for curves of this body with `search gait_annealing`",
        ));
    } else if !bodies && ruleset.from.is_none() && !has_actuators(known) {
        findings.push(told(
            "this body has no actuator, and the search does not change bodies",
            "begin with a body that has actuators, or name an example: `search gait_annealing from NAME`",
        ));
    }
}

/// Whether the initial design has actuators, or is a lattice, whose cells can be driven.
fn has_actuators(known: &Known<'_>) -> bool {
    let is_actuator = |kind: &str| known.facts.belongs(kind, &Group::Actuator);
    known.ruleset.lattice.is_some()
        || known.ruleset.begin.iter().any(|placed| match &placed.what.kind {
            ExprKind::Kind(name, _) => is_actuator(name),
            // What is placed may be chosen by a parameter.
            _ => true,
        })
}
