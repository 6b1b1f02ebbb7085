//! Several objectives without a search for a front; a front of one objective, or over one that never changes.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Objective, RuleSet};

use super::known::Known;

/// What a search for a front can be had from.
const SEARCH: &str = "write `search trade_offs` (in a variant `replace search trade_offs`), imported by `use std.search { trade_offs }`";

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let search = &ruleset.search.name;
    let mut objectives = ruleset.objectives();
    let (Some(first), second) = (objectives.next(), objectives.next()) else { return };
    let misfit = |span, message: String| Diagnostic::new(Code::FRONT_MISFIT, span, message);
    match (ruleset.search.front(), second) {
        (None, Some(second)) => findings.push(
            misfit(
                second.value.span,
                format!("there are several objectives, but `{search}` optimises only one"),
            )
            .label("another objective")
            .also(first.value.span, "the first one")
            .help(format!("{SEARCH}; or make one objective of them, as in `maximize travel - 2 * fall in cm`; in a variant, `replace` replaces the objectives of the base")),
        ),
        (Some(_), None) => findings.push(
            misfit(
                first.value.span,
                format!("`{search}` searches for a front of several objectives, but there is only one"),
            )
            .label("the only objective")
            .help("add another one, for example `minimize count(actuator)`, or name another search"),
        ),
        (Some(_), Some(_)) => {
            let never_changes = |objective: &&Objective| known.numbers(&objective.value).single().is_some();
            findings.extend(ruleset.objectives().filter(never_changes).map(|objective| {
                misfit(objective.value.span, "this objective is the same for all designs".to_owned())
                    .label("no trade-off is possible")
                    .help("let it read the motion or the design, or leave it out")
            }));
            small(known, findings);
        }
        (None, None) => {}
    }
    most(ruleset, findings);
}

/// A front keeps the best of each objective, whatever its size: fewer are no front.
fn small(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let Some(front) = known.ruleset.search.front() else { return };
    let (size, objectives) = (&front.selection.size, known.ruleset.objectives().count());
    if known.numbers(size).high < objectives as f64 {
        let (one, all) = (known.numbers(size).high, objectives);
        findings.push(
            Diagnostic::new(
                Code::FRONT_MISFIT,
                size.span,
                format!("a front of {all} objectives must keep at least {all} designs: the best for each objective"),
            )
            .label(format!("this keeps {one}"))
            .help(format!("write `size = {}`, or any number of at least {all}", all * 8)),
        );
    }
}

/// More objectives than this make a front of nearly all designs.
const MOST: usize = 3;

fn most(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    if let Some(objective) = ruleset.objectives().nth(MOST) {
        findings.push(
            Diagnostic::new(
                Code::FRONT_MISFIT,
                objective.value.span,
                format!("a front can have at most {MOST} objectives"),
            )
            .label("one too many")
            .help("with more objectives, hardly any design is better than another: combine some, or turn them into requirements"),
        );
    }
}
