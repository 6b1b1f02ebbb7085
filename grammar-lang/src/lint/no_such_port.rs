//! A port is asked for that no part there can have.

use crate::bounds::{Abstract, Asked, Facts, Interval, Reasoning, Repeated, Truth, conjuncts};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{ACTUATOR_PORTS, BLOCK_PORTS, Effect, Expr, ExprKind, Operator, Rule};
use crate::source::Span;

use super::known::Known;
use super::places::{conditions, wherever};

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let facts = &known.facts;
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.narrowed);
        for (at, of, name) in asked(rule) {
            findings.extend(not_there(facts, &mut reasoning, rule, at, of, name));
        }
        reasoning.through_effects(&rule.effects, Repeated::FirstAndLast, &mut |reasoning, effect| {
            if let Effect::Attach { on, .. } = effect
                && let ExprKind::Port(of, name, _) = &on.port.kind
            {
                findings.extend(not_there(facts, reasoning, rule, &on.port, of, name));
            }
        });
    }
    // Whatever else is worked out: requirements, preferences, terms, guards, actuations.
    wherever(known, findings, |reasoning| {
        reasoning.ports.iter().filter_map(|asked| never_there(facts, asked)).collect()
    });
}

/// What is wrong with a port that a rule must find, if it cannot.
fn not_there(
    facts: &Facts<'_>,
    reasoning: &mut Reasoning<'_>,
    rule: &Rule,
    at: &Expr,
    of: &Expr,
    name: &str,
) -> Option<Diagnostic> {
    let (Abstract::Port(kinds) | Abstract::Part(kinds)) = reasoning.value(of) else { return None };
    if facts.are_ports(&kinds, name) == Truth::Never {
        let ports = facts.ports(&kinds).into_iter().collect::<Vec<_>>();
        let kinds = facts.names(&kinds).into_iter().collect::<Vec<_>>();
        return Some(report(&of_rule(rule, name), at.span, name, &kinds, &ports));
    }
    let ExprKind::Port(_, _, Some(number)) = &at.kind else { return None };
    let there = facts.port_numbers(&kinds, name)?;
    let asked = reasoning.numbers(number);
    let is_beyond = asked.low > there.high || asked.high < there.low;
    is_beyond.then(|| {
        let finding = no_such_number(&of_rule(rule, name), number.span, name, there);
        match asked.single() {
            Some(one) => finding.label(format!("this is {one}")),
            None => finding,
        }
    })
}

/// What is wrong with a port that is asked for, if it is never there.
fn never_there(facts: &Facts<'_>, asked: &Asked) -> Option<Diagnostic> {
    let Asked { span, name, number, kinds } = asked;
    if facts.is_empty(kinds) {
        return None;
    }
    let what = format!("this asks for a port `{name}` that does not exist");
    if facts.are_ports(kinds, name) == Truth::Never {
        let ports = facts.ports(kinds).into_iter().collect::<Vec<_>>();
        let kinds = facts.names(kinds).into_iter().collect::<Vec<_>>();
        return Some(report(&what, *span, name, &kinds, &ports));
    }
    let ((place, number), there) = number.as_ref().zip(facts.port_numbers(kinds, name))?;
    let is_beyond = number.low > there.high || number.high < there.low;
    is_beyond.then(|| no_such_number(&what, *place, name, there))
}

fn of_rule(rule: &Rule, name: &str) -> String {
    format!("the rule `{}` asks for a port `{name}` that does not exist", rule.name)
}

/// A number that no port of this name has.
fn no_such_number(what: &str, place: Span, name: &str, there: Interval) -> Diagnostic {
    Diagnostic::new(Code::NO_SUCH_PORT, place, what)
        .label("no port has this number")
        .help(format!("the ports `{name}` are numbered {} .. {}", there.low, there.high))
}

/// Ports that the conditions of a rule ask for: where each is named, the port or part that it is asked of, its name.
fn asked(rule: &Rule) -> Vec<(&Expr, &Expr, &str)> {
    let mut found = Vec::new();
    for condition in conditions(rule).flat_map(conjuncts) {
        if let ExprKind::Binary(port, Operator::Is, name) = &condition.kind
            && let ExprKind::PortName(text) = &name.kind
        {
            found.push((&**name, &**port, text.as_str()));
        }
    }
    found
}

fn report(what: &str, at: Span, name: &str, kinds: &[&str], ports: &[&str]) -> Diagnostic {
    let whose = match kinds {
        [one] => format!("a `{one}` has none"),
        _ => format!("none of {} has one", kinds.join(", ")),
    };
    let there = format!("the existing ports are: {}", ports.join(", "));
    // A real port of another kind is no slip of the finger.
    let exists = BLOCK_PORTS.iter().chain(ACTUATOR_PORTS).any(|p| *p == name);
    let help = did_you_mean(name, ports.iter().copied()).filter(|_| !exists).unwrap_or(there);
    Diagnostic::new(Code::NO_SUCH_PORT, at, what).label(whose).help(help)
}
