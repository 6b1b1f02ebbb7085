//! A rule sets a parameter that no part there can have.

use crate::bounds::{Abstract, Reasoning, Repeated};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{Effect, Expr, Settable};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.all_rules() {
        known.reasoning(locals).through_effects(
            &rule.effects,
            Repeated::Together,
            &mut |reasoning, effect| {
                if let Effect::Set { part, attribute: Settable::Param(name), .. } = effect {
                    findings.extend(not_there(known, reasoning, part, name));
                }
            },
        );
    }
}

fn not_there(
    known: &Known<'_>,
    reasoning: &mut Reasoning<'_>,
    part: &Expr,
    name: &str,
) -> Option<Diagnostic> {
    let Abstract::Part(kinds) = reasoning.value(part) else { return None };
    let names = known.facts.names(&kinds);
    let params = |kind: &&str| known.ruleset.params_of(kind).into_iter().flat_map(|params| params.keys());
    if names.is_empty() || names.iter().flat_map(params).any(|param| param == name) {
        return None;
    }
    let whose = match names.iter().copied().collect::<Vec<_>>().as_slice() {
        [one] => format!("`{one}` has no parameter `{name}`"),
        several => format!("none of {} has a parameter `{name}`", several.join(", ")),
    };
    let has: Vec<&str> = names.iter().flat_map(params).map(String::as_str).collect();
    let help = did_you_mean(name, has.iter().copied()).unwrap_or_else(|| match has.as_slice() {
        [] => "it has no parameters: declare one with `param`".to_owned(),
        has => format!("its parameters are: {}", has.join(", ")),
    });
    Some(Diagnostic::new(Code::UNKNOWN_FIELD, part.span, whose).label("no such parameter").help(help))
}
