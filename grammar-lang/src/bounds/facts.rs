//! What is known of a grammar whatever the design.

use super::{Abstract, Interval, Truth};
use crate::ir::{ACTUATOR_PORTS, BLOCK_PORTS, ExprKind, Group, RuleSet, Symmetry, Ty, Word};

/// What is known of a grammar whatever the design and the values of its parameters.
#[derive(Clone, Debug)]
pub struct Facts<'r> {
    /// The grammar.
    pub rules: &'r RuleSet,
    /// Words of which more is known than their meaning says.
    words: Vec<(Word, Interval)>,
}

impl<'r> Facts<'r> {
    /// The facts of a grammar.
    #[must_use]
    pub fn new(rules: &'r RuleSet) -> Self {
        Self { rules, words: Vec::new() }
    }

    /// Knows more of a word.
    #[must_use]
    pub fn with(mut self, word: Word, interval: Interval) -> Self {
        self.words.push((word, interval));
        self
    }

    /// Every declared kind of part.
    #[must_use]
    pub fn kinds(&self) -> Vec<String> {
        self.rules.parts.keys().chain(self.rules.actuators.keys()).cloned().collect()
    }

    /// The declared kinds of a group.
    #[must_use]
    pub fn kinds_in(&self, group: &Group) -> Vec<String> {
        self.kinds().into_iter().filter(|kind| self.belongs(kind, group)).collect()
    }

    /// Whether parts of a kind are of a group.
    #[must_use]
    pub fn belongs(&self, kind: &str, group: &Group) -> bool {
        match group {
            Group::Part => true,
            Group::Block => !self.rules.is_actuator(kind),
            Group::Actuator => self.rules.is_actuator(kind),
            Group::Kind(name) => name == kind,
        }
    }

    /// Whether a part of one of these kinds is of a group.
    #[must_use]
    pub fn member(&self, kinds: &[String], group: &Group) -> Truth {
        let inside = kinds.iter().filter(|kind| self.belongs(kind, group)).count();
        Truth::of(inside == kinds.len() && inside > 0, inside == 0 && !kinds.is_empty())
    }

    /// How many parts of a kind the initial design has: they stay.
    #[must_use]
    pub fn placed(&self, kind: &str) -> usize {
        let is = |p: &&crate::ir::Placed| matches!(&p.what.kind, ExprKind::Kind(name, _) if name == kind);
        self.rules.begin.iter().filter(is).count()
    }

    /// How many parts of a group there are.
    #[must_use]
    pub fn count(&self, group: &Group) -> Interval {
        let kinds = self.kinds_in(group);
        if kinds.is_empty() {
            return Interval::point(0.0);
        }
        let placed: usize = kinds.iter().map(|kind| self.placed(kind)).sum();
        Interval::new(placed as f64, f64::INFINITY)
    }

    /// The names of a kind's ports.
    #[must_use]
    pub fn ports(&self, kind: &str) -> Vec<&'r str> {
        match self.rules.parts.get(kind) {
            _ if self.rules.is_actuator(kind) => ACTUATOR_PORTS.to_vec(),
            Some(block) if !block.ports.is_empty() => block.ports.iter().map(|p| p.name.as_str()).collect(),
            _ => BLOCK_PORTS.to_vec(),
        }
    }

    /// How often a part off the axis of symmetry is there.
    #[must_use]
    pub fn images(&self) -> usize {
        match self.rules.symmetry {
            Symmetry::None => 1,
            Symmetry::Mirror(_) => 2,
            Symmetry::Radial(count, _) => count.max(1),
        }
    }

    /// The value of a word.
    #[must_use]
    pub fn word(&self, word: Word) -> Abstract {
        if let Some((_, known)) = self.words.iter().rev().find(|(w, _)| *w == word) {
            return Abstract::Number(*known);
        }
        match word {
            Word::Pi => Abstract::Number(Interval::point(std::f64::consts::PI)),
            Word::Cycle => Abstract::Number(Interval::new(0.0, 1.0)),
            Word::Start => Abstract::Number(Interval::point(0.0)),
            Word::Time | Word::End | Word::Duration | Word::Temperature | Word::Iteration | Word::Idle => {
                Abstract::Number(Interval::NOT_NEGATIVE)
            }
            Word::Elements => Abstract::Many(Box::new(Abstract::Any), Interval::new(1.0, f64::INFINITY)),
            Word::Connected | Word::NoOverlap => Abstract::Bool(Truth::Sometimes),
            Word::Period | Word::Best => Abstract::Number(Interval::ALL),
        }
    }

    /// The values that a parameter may be set to.
    #[must_use]
    pub fn param(&self, name: &str) -> Abstract {
        match self.rules.params.get(name) {
            Some(param) if param.ty == Ty::Bool => Abstract::Bool(Truth::Sometimes),
            Some(param) => match param.domain {
                Some((low, high)) => Abstract::Number(Interval::new(low, high)),
                None => Abstract::Any,
            },
            None => Abstract::Any,
        }
    }

    /// An attribute of a part of one of these kinds.
    pub(super) fn part_attribute(&self, kinds: &[String], name: &str) -> Abstract {
        let full = 2.0 * std::f64::consts::PI;
        match name {
            "turn" => Abstract::Number(Interval::new(0.0, full)),
            "image" => Abstract::Number(Interval::new(0.0, self.images() as f64 - 1.0)),
            "depth" | "mass" => Abstract::Number(Interval::NOT_NEGATIVE),
            "holder" => Abstract::Part(self.kinds()),
            "twin" => Abstract::Part(kinds.to_vec()),
            _ => self.instance_param(kinds, name),
        }
    }

    fn instance_param(&self, kinds: &[String], name: &str) -> Abstract {
        let declared: Vec<_> = kinds
            .iter()
            .filter_map(|kind| self.rules.actuators.get(kind)?.params.get(name))
            .map(|param| match (&param.ty, param.domain) {
                (Ty::Bool, _) => Abstract::Bool(Truth::Sometimes),
                (_, Some((low, high))) => Abstract::Number(Interval::new(low, high)),
                _ => Abstract::Any,
            })
            .collect();
        declared.into_iter().reduce(Abstract::hull).unwrap_or(Abstract::Any)
    }

    /// An attribute of a port of parts of these kinds.
    pub(super) fn port_attribute(&self, kinds: &[String], name: &str) -> Abstract {
        match name {
            "part" => Abstract::Part(kinds.to_vec()),
            "free" => Abstract::Bool(Truth::Sometimes),
            _ => Abstract::Any,
        }
    }
}
