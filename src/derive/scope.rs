//! What the expressions of the derivation can read: the design so far.

use grammar_lang::eval::{Reference, Scope, Value};
use grammar_lang::ir::{Function, Group, RuleSet, Word};

use super::Derivation;
use crate::design::{Design, PartId};

/// The design so far, and the temperature where a weight may read it.
pub struct DesignScope<'a> {
    rules: &'a RuleSet,
    derivation: &'a Derivation,
    temperature: Option<f64>,
}

impl<'a> DesignScope<'a> {
    /// Sees a design.
    #[must_use]
    pub fn new(rules: &'a RuleSet, derivation: &'a Derivation) -> Self {
        Self { rules, derivation, temperature: None }
    }

    /// Sees the temperature, too.
    #[must_use]
    pub fn at_temperature(mut self, temperature: f64) -> Self {
        self.temperature = Some(temperature);
        self
    }

    fn design(&self) -> &Design {
        &self.derivation.design
    }
}

fn part(value: &Value) -> Option<PartId> {
    match value {
        Value::Reference(Reference::Part(id)) => Some(*id),
        _ => None,
    }
}

impl Scope for DesignScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.rules)
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Connected => Some(Value::Bool(self.design().is_connected())),
            Word::NoOverlap => Some(Value::Bool(self.design().no_overlap(self.rules))),
            Word::Temperature => self.temperature.map(Value::Number),
            _ => None,
        }
    }

    fn placed(&self, name: &str) -> Option<Value> {
        self.design().placed.get(name).map(|id| Value::Reference(Reference::Part(*id)))
    }

    fn group(&self, group: &Group) -> Option<Vec<Value>> {
        let parts = self.design().parts.keys().filter(|id| self.design().belongs(self.rules, **id, group));
        Some(parts.map(|id| Value::Reference(Reference::Part(*id))).collect())
    }

    fn belongs(&self, value: &Value, group: &Group) -> Option<bool> {
        Some(self.design().belongs(self.rules, part(value)?, group))
    }

    fn adds(&self, step: &Value, group: &Group) -> Option<bool> {
        let Value::Reference(Reference::Step(step)) = step else { return None };
        let design = self.design();
        Some(design.parts.iter().any(|(id, p)| p.step == *step && design.belongs(self.rules, *id, group)))
    }

    fn attribute(&self, of: &Value, name: &str) -> Option<Value> {
        let part = self.design().parts.get(&part(of)?)?;
        match name {
            "turn" => Some(Value::Number(part.turn)),
            "image" => Some(Value::Number(f64::from(u8::from(part.image_of.is_some())))),
            _ => part.params.get(name).cloned(),
        }
    }

    fn call(&self, function: Function, arguments: &[Value]) -> Option<Value> {
        if function != Function::Neighbours {
            return None;
        }
        let neighbours = self.design().neighbours(part(arguments.first()?)?);
        Some(Value::List(neighbours.into_iter().map(|id| Value::Reference(Reference::Part(id))).collect()))
    }
}
