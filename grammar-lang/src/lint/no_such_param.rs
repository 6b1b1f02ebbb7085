//! A rule sets a parameter that no part there can have, or something reads one.

use crate::bounds::{Abstract, Kinds, Lacking, Repeated};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{Effect, Settable};
use crate::source::Span;

use super::known::Known;
use super::places::wherever;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.all_rules() {
        known.reasoning(locals).through_effects(
            &rule.effects,
            Repeated::Together,
            &mut |reasoning, effect| {
                if let Effect::Set { part, attribute: Settable::Param(name), .. } = effect
                    && let Abstract::Part(kinds) = reasoning.value(part)
                {
                    findings.extend(not_there(known, &kinds, name, part.span));
                }
            },
        );
    }
    // Whatever else is worked out: it has no value as soon as there is such a part.
    wherever(known, findings, |reasoning| {
        let lacking = reasoning.lacking.iter();
        lacking.filter_map(|Lacking { span, name, kinds }| not_there(known, kinds, name, *span)).collect()
    });
}

fn not_there(known: &Known<'_>, kinds: &Kinds, name: &str, at: Span) -> Option<Diagnostic> {
    let names = known.facts.names(kinds);
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
    Some(Diagnostic::new(Code::UNKNOWN_FIELD, at, whose).label("no such parameter").help(help))
}
