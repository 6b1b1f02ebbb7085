//! What the patterns of a rule match.

use std::collections::BTreeSet;

use grammar_lang::eval::{EvalError, Reference, Value, evaluate};
use grammar_lang::ir::{Match, Matched, Rule, RuleSet};

use super::{Derivation, DesignScope};
use crate::design::PartId;

/// So many matches of one rule are listed at most: whatever lies beyond is not drawn.
const MOST: usize = 200_000;

/// So many combinations are tried for one rule at most: a fifth of a second. Five patterns, each of which matches thirty parts,
/// make 24 million of them.
const TRIED: usize = 300_000;

impl Derivation {
    /// Everything that a rule's patterns match together, as values of its first locals.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when a condition has no value, or too much would have to be tried.
    pub fn matches(&self, rules: &RuleSet, rule: &Rule) -> Result<Vec<Vec<Value>>, EvalError> {
        let any = rule.matches.iter().any(|one| matches!(one.what, Matched::Part { port: true, .. }));
        let taken = if any { self.design.taken_ports() } else { BTreeSet::new() };
        let mut search = Search { derivation: self, rules, rule, taken, tried: 0, found: Vec::new() };
        let mut bound = Vec::new();
        if search.holds(None, 0, 0, &mut bound)? {
            search.extend(&rule.matches, &mut bound)?;
        }
        Ok(search.found)
    }
}

struct Search<'a> {
    derivation: &'a Derivation,
    rules: &'a RuleSet,
    rule: &'a Rule,
    /// The ports that are not free, where a pattern asks for a free one.
    taken: BTreeSet<(PartId, u8)>,
    /// How often a pattern was bound.
    tried: usize,
    found: Vec<Vec<Value>>,
}

impl Search<'_> {
    /// Binds the next pattern to each of its candidates in turn.
    fn extend(&mut self, open: &[Match], bound: &mut Vec<Value>) -> Result<(), EvalError> {
        let Some((next, rest)) = open.split_first() else {
            self.found.push(bound.clone());
            return Ok(());
        };
        let before = bound.len();
        for candidate in self.candidates(next, bound) {
            let twice = candidate.iter().any(|c| bound.contains(c));
            if twice || self.found.len() >= MOST {
                continue;
            }
            self.tried += 1;
            if self.tried > TRIED {
                let span = next.condition.as_ref().map_or(self.rule.weight.span, |condition| condition.span);
                let reason = format!(
                    "its patterns would be tried on more than {TRIED} combinations; match fewer things, or put the pattern with the narrowest condition first"
                );
                return Err(EvalError { span, reason });
            }
            bound.extend(candidate);
            if self.holds(Some(next), before + 1, bound.len(), bound)? {
                self.extend(rest, bound)?;
            }
            bound.truncate(before);
        }
        Ok(())
    }

    /// Whether the condition of a pattern holds, and every guard whose last local
    /// is one of those from number `from` to number `to`.
    fn holds(
        &self,
        matched: Option<&Match>,
        from: usize,
        to: usize,
        bound: &mut Vec<Value>,
    ) -> Result<bool, EvalError> {
        let scope = DesignScope::new(self.rules, self.derivation);
        let guards = self.rule.guards.iter().filter(|g| (from..=to).contains(&g.needs));
        let conditions = matched.and_then(|m| m.condition.as_ref()).into_iter();
        for condition in conditions.chain(guards.map(|g| &g.condition)) {
            if evaluate(condition, &scope, bound)? != Value::Bool(true) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn candidates(&self, matched: &Match, bound: &[Value]) -> Vec<Vec<Value>> {
        let design = &self.derivation.design;
        let of = |r| Value::Reference(r);
        let part_in = |slot: &usize| match bound.get(*slot) {
            Some(Value::Reference(Reference::Part(id))) => Some(*id),
            _ => None,
        };
        match &matched.what {
            Matched::Step => self.derivation.steps.iter().map(|s| vec![of(Reference::Step(s.id))]).collect(),
            Matched::Joint => design
                .parts
                .iter()
                .filter(|(_, p)| p.held_by.is_some())
                .map(|(id, _)| vec![of(Reference::Joint(*id))])
                .collect(),
            Matched::Port { of: owner } => {
                let parts: Vec<PartId> = match owner {
                    Some(slot) => part_in(slot).into_iter().collect(),
                    None => design.parts.keys().copied().collect(),
                };
                let ports = parts.into_iter().flat_map(|id| (0..design.port_count(id)).map(move |p| (id, p)));
                ports.map(|(id, p)| vec![of(Reference::Port(id, p))]).collect()
            }
            Matched::Part { kind, port, joined_to } => {
                let parts: Vec<PartId> = match joined_to {
                    Some(slot) => part_in(slot).map_or(Vec::new(), |id| design.neighbours(id)),
                    None => design.parts.keys().copied().collect(),
                };
                let parts = parts.into_iter().filter(|id| design.belongs(self.rules, *id, kind));
                if *port {
                    parts
                        .flat_map(|id| (0..design.port_count(id)).map(move |p| (id, p)))
                        .filter(|port| !self.taken.contains(port))
                        .map(|(id, p)| vec![of(Reference::Part(id)), of(Reference::Port(id, p))])
                        .collect()
                } else {
                    parts.map(|id| vec![of(Reference::Part(id))]).collect()
                }
            }
        }
    }
}
