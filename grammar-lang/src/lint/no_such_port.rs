//! A rule that asks for a port that no part there can have.

use crate::bounds::{Abstract, Interval, Truth, conjuncts};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{ACTUATOR_PORTS, BLOCK_PORTS, Effect, Expr, ExprKind, Operator, Rule};

use super::known::Known;
use super::places::conditions;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let facts = &known.facts;
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.narrowed);
        for (at, of, name) in asked(rule) {
            let (Abstract::Port(kinds) | Abstract::Part(kinds)) = reasoning.value(of) else { continue };
            if facts.are_ports(&kinds, name) == Truth::Never {
                let ports = facts.ports(&kinds).into_iter().collect::<Vec<_>>();
                let kinds = facts.names(&kinds).into_iter().collect::<Vec<_>>();
                findings.push(report(rule, at, name, &kinds, &ports));
            } else if let ExprKind::Port(_, _, Some(number)) = &at.kind {
                let numbers = facts.port_numbers(&kinds, name);
                let asked = reasoning.numbers(number);
                let beyond = numbers.is_some_and(|there| asked.low > there.high || asked.high < there.low);
                if let (Some(there), true) = (numbers, beyond) {
                    findings.push(no_such_number(rule, number, name, there));
                }
            }
        }
    }
}

/// A number that no port of this name has.
fn no_such_number(rule: &Rule, number: &Expr, name: &str, there: Interval) -> Diagnostic {
    Diagnostic::new(
        Code::NO_SUCH_PORT,
        number.span,
        format!("the rule `{}` asks for a port `{name}` that is never there", rule.name),
    )
    .label("no port has this number")
    .help(format!("`{name}` has the numbers {} .. {}", there.low, there.high))
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

fn report(rule: &Rule, at: &Expr, name: &str, kinds: &[&str], ports: &[&str]) -> Diagnostic {
    let whose = match kinds {
        [one] => format!("a `{one}` has none"),
        _ => format!("none of {} has one", kinds.join(", ")),
    };
    let there = format!("the ports there are: {}", ports.join(", "));
    // A real port of another kind is no slip of the finger.
    let exists = BLOCK_PORTS.iter().chain(ACTUATOR_PORTS).any(|p| *p == name);
    let help = did_you_mean(name, ports.iter().copied()).filter(|_| !exists).unwrap_or(there);
    Diagnostic::new(
        Code::NO_SUCH_PORT,
        at.span,
        format!("the rule `{}` asks for a port `{name}` that is never there", rule.name),
    )
    .label(whose)
    .help(help)
}
