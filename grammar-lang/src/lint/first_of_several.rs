//! A port that is named without its number, where several have the name: the first of them is meant.

use std::collections::BTreeSet;

use crate::bounds::Asked;
use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for place in places(known) {
        let mut reasoning = known.reasoning(&place.locals);
        for expr in place.exprs {
            reasoning.value(expr);
        }
        for asked in &reasoning.ports {
            let span = asked.span;
            if let Some(count) = several(known, asked)
                && told.insert((span.file, span.start))
            {
                let name = &asked.name;
                findings.push(
                    Diagnostic::new(
                        Code::FIRST_OF_SEVERAL,
                        span,
                        format!("there are {count} ports `{name}`, and this is the first of them"),
                    )
                    .label(format!("`{name}[0]`"))
                    .help(format!("write the number of the port, as in `{name}[0]`; to ask whether a port q is any of them, write `q is {name}`")),
                );
            }
        }
    }
}

/// How many ports have the name that is asked for without a number, if each kind that has it has several.
fn several(known: &Known<'_>, asked: &Asked) -> Option<usize> {
    if asked.number.is_some() {
        return None;
    }
    let kinds = known.facts.names(&asked.kinds);
    let counts = kinds.into_iter().filter_map(|kind| known.ruleset.parts.get(kind)).map(|part| {
        // Six ports that no kind needs to declare have one of each name.
        let own = part.ports.iter().filter(|port| port.name == asked.name).count();
        if part.ports.is_empty() { 1 } else { own }
    });
    let counts: Vec<usize> = counts.filter(|count| *count > 0).collect();
    counts.iter().min().copied().filter(|count| *count > 1)
}
