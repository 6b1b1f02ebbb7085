//! A rule that asks for a port that no part there can have.

use crate::bounds::{Abstract, Facts, Reasoning, conjuncts, narrowed_locals_of};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{ACTUATOR_PORTS, BLOCK_PORTS, Effect, Expr, ExprKind, Operator, Rule, RuleSet};

use super::places::conditions;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let facts = Facts::new(ruleset);
    for rule in &ruleset.rules {
        let locals = narrowed_locals_of(&facts, rule);
        for (at, of, name) in asked(rule) {
            let kinds = match Reasoning::new(&facts, locals.clone()).value(of) {
                Abstract::Port(kinds) | Abstract::Part(kinds) if !kinds.is_empty() => kinds,
                _ => continue,
            };
            let has: Vec<&str> = kinds.iter().flat_map(|kind| facts.ports(kind)).collect();
            if !has.contains(&name) {
                findings.push(report(rule, at, name, &kinds, &has));
            }
        }
    }
}

/// Ports that a rule must find: where each is named, the port or part that it is asked of, its name.
fn asked(rule: &Rule) -> Vec<(&Expr, &Expr, &str)> {
    let mut found = Vec::new();
    for condition in conditions(rule).flat_map(conjuncts) {
        if let ExprKind::Binary(port, Operator::Is, name) = &condition.kind
            && let ExprKind::PortName(text) = &name.kind
        {
            found.push((&**name, &**port, text.as_str()));
        }
    }
    for effect in &rule.effects {
        if let Effect::Attach { on, .. } = effect
            && let ExprKind::Port(of, name, _) = &on.port.kind
        {
            found.push((&on.port, &**of, name.as_str()));
        }
    }
    found
}

fn report(rule: &Rule, at: &Expr, name: &str, kinds: &[String], has: &[&str]) -> Diagnostic {
    let whose = match kinds {
        [one] => format!("a `{one}` has none"),
        _ => format!("none of {} has one", kinds.join(", ")),
    };
    let mut known: Vec<&str> = Vec::new();
    for port in has {
        if !known.contains(port) {
            known.push(port);
        }
    }
    let there = format!("the ports there are: {}", known.join(", "));
    // A real port of another kind is no slip of the finger.
    let exists = BLOCK_PORTS.iter().chain(ACTUATOR_PORTS).any(|p| *p == name);
    let help = did_you_mean(name, known.iter().copied()).filter(|_| !exists).unwrap_or(there);
    Diagnostic::new(
        Code::NO_SUCH_PORT,
        at.span,
        format!("the rule `{}` asks for a port `{name}` that is never there", rule.name),
    )
    .label(whose)
    .help(help)
}
