//! Declarations that say the same under two names.

use serde::Serialize;
use serde_json::Value;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::without_spans;
use crate::source::Span;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let rules = ruleset.rules.iter().map(|rule| (rule.name.as_str(), rule.span, bare(rule)));
    findings.extend(twins(
        "rules",
        rules,
        "a move draws one of them twice as often as it should: take one out, or give the other a weight",
    ));
    let requirements =
        ruleset.requirements.iter().map(|r| (r.name.as_str(), r.condition.span, bare(&r.condition)));
    findings.extend(twins("requirements", requirements, "take one out"));
    let tasks =
        ruleset.tasks.iter().map(|(name, task)| (name.as_str(), task.objective.value.span, bare(task)));
    findings.extend(twins(
        "tasks",
        tasks,
        "each costs a simulation: remove one, or give them different objectives",
    ));
}

/// What a declaration says, without its name, the names of its locals and places in the text.
fn bare(declaration: &impl Serialize) -> Option<String> {
    let mut said = without_spans(declaration).ok()?;
    if let Value::Object(fields) = &mut said {
        fields.remove("name");
        fields.remove("locals");
        for choice in fields.get_mut("choices").and_then(Value::as_array_mut).into_iter().flatten() {
            choice.as_object_mut().map(|choice| choice.remove("name"));
        }
    }
    Some(said.to_string())
}

/// A warning for each declaration that says what one before it says.
fn twins<'a>(
    what: &'a str,
    all: impl Iterator<Item = (&'a str, Span, Option<String>)>,
    help: &'a str,
) -> Vec<Diagnostic> {
    let mut seen: std::collections::BTreeMap<String, (&str, Span)> = std::collections::BTreeMap::new();
    let mut found = Vec::new();
    for (name, span, said) in all {
        let Some(said) = said else { continue };
        let Some((first, there)) = seen.insert(said, (name, span)) else { continue };
        found.push(
            Diagnostic::new(
                Code::SAID_TWICE,
                span,
                format!("the {what} `{first}` and `{name}` are the same"),
            )
            .label("again")
            .also(there, "first here")
            .help(help),
        );
    }
    found
}
