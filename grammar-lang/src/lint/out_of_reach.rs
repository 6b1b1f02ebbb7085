//! Rules that no derivation gets to: what they match is only made by rules that
//! need the same thing first, or has no free port.

use crate::bounds::{Abstract, Facts, made_by, narrowed_locals_of};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind, Matched, Rule, RuleSet};

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let reach = Reach::of(ruleset);
    for (rule, reached) in ruleset.rules.iter().zip(&reach.rules) {
        let blocked = if *reached { None } else { reach.blocked(rule) };
        if let Some(why) = blocked {
            findings.push(
                Diagnostic::new(
                    Code::OUT_OF_REACH,
                    rule.span,
                    format!("no derivation ever gets to the rule `{}`", rule.name),
                )
                .label(why)
                .help("add a rule that starts from what `begin` places"),
            );
        }
    }
}

/// What derivations can get to.
pub(super) struct Reach<'r> {
    facts: Facts<'r>,
    /// The kinds of parts that a rule within reach makes.
    made: Vec<String>,
    /// Which rules are within reach.
    pub(super) rules: Vec<bool>,
}

impl<'r> Reach<'r> {
    /// Goes on from the initial design for as long as more comes within reach.
    pub(super) fn of(ruleset: &'r RuleSet) -> Self {
        let facts = Facts::new(ruleset);
        let mut reach = Self { facts, made: Vec::new(), rules: vec![false; ruleset.rules.len()] };
        loop {
            let mut more = false;
            for (i, rule) in ruleset.rules.iter().enumerate() {
                if reach.rules.get(i) == Some(&true) || reach.blocked(rule).is_some() {
                    continue;
                }
                more = true;
                if let Some(reached) = reach.rules.get_mut(i) {
                    *reached = true;
                }
                for effect in &rule.effects {
                    reach.made.extend(made_by(&reach.facts, rule, effect));
                }
            }
            if !more {
                return reach;
            }
        }
    }

    fn exists(&self, kind: &String) -> bool {
        self.made.contains(kind) || self.facts.placed(kind) > 0
    }

    /// What a rule needs that is not within reach.
    fn blocked(&self, rule: &Rule) -> Option<String> {
        let locals = narrowed_locals_of(&self.facts, rule);
        let mut slot = 0;
        for matched in &rule.matches {
            let why = match (&matched.what, locals.get(slot)) {
                (Matched::Part { port, .. }, Some(Abstract::Part(kinds))) => self.missing(kinds, *port),
                (Matched::Step, _) => self.no_step(rule),
                _ => None,
            };
            if why.is_some() {
                return why;
            }
            slot += matched.slots();
        }
        None
    }

    fn missing(&self, kinds: &[String], port: bool) -> Option<String> {
        let there: Vec<&String> = kinds.iter().filter(|kind| self.exists(kind)).collect();
        if there.is_empty() {
            return Some(format!("there is never a `{}` to begin with", kinds.join("` or `")));
        }
        if port && !there.iter().any(|kind| self.has_free_port(kind)) {
            let names: Vec<&str> = there.iter().map(|k| k.as_str()).collect();
            return Some(format!("a `{}` never has a free port", names.join("` or `")));
        }
        None
    }

    /// Whether a part of a kind can have a free port. Every part but the core is held by one.
    fn has_free_port(&self, kind: &str) -> bool {
        let ports = self.facts.ports(kind).len();
        if self.made.iter().any(|made| made == kind) && ports > 1 {
            return true;
        }
        let begin = &self.facts.rules.begin;
        let is = |expr: &Expr| matches!(&expr.kind, ExprKind::Kind(name, _) if name == kind);
        let on = |name: &str| {
            let held = |expr: &Expr| {
                expr.any(&mut |e| matches!(&e.kind, ExprKind::Placed(placed) if placed == name))
            };
            begin.iter().filter(|p| p.on.as_ref().is_some_and(|on| held(&on.port))).count()
        };
        begin.iter().filter(|p| is(&p.what)).any(|p| ports > on(&p.name) + usize::from(p.on.is_some()))
    }

    /// A step is needed before one can be taken back.
    fn no_step(&self, rule: &Rule) -> Option<String> {
        let steps = |r: &Rule| !r.effects.iter().any(|e| matches!(e, Effect::Revert(_)));
        let rules = self.facts.rules.rules.iter().zip(&self.rules);
        let some = rules.filter(|(r, reached)| **reached && r.name != rule.name).any(|(r, _)| steps(r));
        (!some).then(|| "there is never a step to match".to_owned())
    }
}
