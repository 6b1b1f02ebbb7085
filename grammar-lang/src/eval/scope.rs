//! What a stage of a grammar knows, for the expressions that are evaluated there.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

use super::{Reference, Value};
use crate::ir::{Attribute, DesignFunction, Expr, Group, Param, RuleSet, Track, Ty, Word};

/// What a stage knows. A scope says what its stage adds and leaves the rest to
/// its outer scope; whatever nobody knows is `None`, and the checker lets no
/// expression ask for it.
pub trait Scope {
    /// Who knows what this scope does not.
    fn outer(&self) -> Option<&dyn Scope>;

    /// The value of a word.
    fn word(&self, word: Word) -> Option<Value> {
        self.outer()?.word(word)
    }
    /// How many operations all that is evaluated here may still take together; without a bound if there is none.
    fn left(&self) -> Option<&AtomicU64> {
        None
    }
    /// The value of a term, if it has been evaluated before.
    fn remembered(&self, term: &str) -> Option<Value> {
        let _ = term;
        None
    }
    /// Remembers the value of a term, where that is of use.
    fn remember(&self, term: &str, value: &Value) {
        let _ = (term, value);
    }
    /// The value of a parameter of the grammar, SI.
    fn param(&self, name: &str) -> Option<Value> {
        self.outer()?.param(name)
    }
    /// The value that a parameter of the grammar has in this body, SI: rules set it.
    fn of_body(&self, name: &str) -> Option<Value> {
        self.outer()?.of_body(name)
    }
    /// A part of the initial design by name.
    fn placed(&self, name: &str) -> Option<Value> {
        self.outer()?.placed(name)
    }
    /// The parts of a group.
    fn group(&self, group: &Group) -> Option<Vec<Value>> {
        self.outer()?.group(group)
    }
    /// Whether a part belongs to a group.
    fn belongs(&self, part: &Value, group: &Group) -> Option<bool> {
        self.outer()?.belongs(part, group)
    }
    /// Whether a step created a part of a group that still exists.
    fn adds(&self, step: &Value, group: &Group) -> Option<bool> {
        self.outer()?.adds(step, group)
    }
    /// An attribute of a thing. Each implementation matches [`Attribute`] without a wildcard.
    fn attribute(&self, of: Reference, attribute: &Attribute) -> Option<Value> {
        self.outer()?.attribute(of, attribute)
    }
    /// Where an element, or the first one of a part, is at a time in s.
    fn track(&self, of: Reference, track: Track, time: f64) -> Option<Value> {
        self.outer()?.track(of, track, time)
    }
    /// A port of a part by name, and by number where several share the name.
    fn port(&self, part: &Value, name: &str, number: Option<f64>) -> Option<Value> {
        self.outer()?.port(part, name, number)
    }
    /// Whether a port has a name.
    fn is_port(&self, port: &Value, name: &str) -> Option<bool> {
        self.outer()?.is_port(port, name)
    }
    /// The value of a task.
    fn task(&self, name: &str) -> Option<Value> {
        self.outer()?.task(name)
    }
    /// The value of a shared variable of an actuation.
    fn shared(&self, actuation: &str, variable: &str) -> Option<Value> {
        self.outer()?.shared(actuation, variable)
    }
    /// What a sensor reads, of a part where parts have one each.
    fn sensed(&self, sensor: &str, of: Option<&Value>) -> Option<Value> {
        self.outer()?.sensed(sensor, of)
    }
    /// A function that asks the design.
    fn call(&self, function: DesignFunction, arguments: &[Value]) -> Option<Value> {
        self.outer()?.call(function, arguments)
    }
    /// What the best value of a search gained in its last iterations.
    fn gain(&self, iterations: usize) -> Option<f64> {
        self.outer()?.gain(iterations)
    }
    /// Of cells with a value each, how many groups of neighbours with the same value there are.
    fn clusters(&self, cells: &[(Value, Value)]) -> Option<usize> {
        self.outer()?.clusters(cells)
    }
    /// How many worlds there are, the nominal one among them.
    fn worlds(&self) -> Option<u32> {
        self.outer()?.worlds()
    }
    /// What is known in a world; 0 is the nominal one.
    fn world(&self, place: u32) -> Option<&dyn Scope> {
        self.outer()?.world(place)
    }
    /// The expression of a pattern.
    fn pattern(&self, name: &str) -> Option<&Expr> {
        self.outer()?.pattern(name)
    }
    /// The expression of a term.
    fn term(&self, name: &str) -> Option<&Expr> {
        self.outer()?.term(name)
    }
}

/// A scope that knows only the declarations of a rule set.
impl Scope for RuleSet {
    fn outer(&self) -> Option<&dyn Scope> {
        None
    }
    fn param(&self, name: &str) -> Option<Value> {
        self.params.get(name).map(Param::in_force)
    }
    fn pattern(&self, name: &str) -> Option<&Expr> {
        self.patterns.get(name)
    }
    fn term(&self, name: &str) -> Option<&Expr> {
        self.terms.get(name).map(|t| &t.value)
    }
}

/// The values of one body, by name: the parameters of the grammar that rules have set to something else than they begin with.
pub type BodyValues = BTreeMap<String, Value>;

impl Param {
    /// Its value as expressions read it.
    #[must_use]
    pub fn in_force(&self) -> Value {
        if self.ty == Ty::Bool { Value::Bool(self.value != 0.0) } else { Value::Number(self.value) }
    }
}

/// A rule set with the values of one body: what the fields of its parts can read.
pub struct WithValues<'a> {
    /// The rule set.
    pub rules: &'a RuleSet,
    /// The values of the body.
    pub values: &'a BodyValues,
}

impl Scope for WithValues<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.rules)
    }
    fn of_body(&self, name: &str) -> Option<Value> {
        self.values.get(name).cloned().or_else(|| self.rules.param(name))
    }
}

/// A scope with so many operations for all that is worked out in it.
pub struct Bounded<'a> {
    /// What is known.
    pub scope: &'a dyn Scope,
    /// How many operations are left.
    pub left: &'a AtomicU64,
}

impl Scope for Bounded<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.scope)
    }
    fn left(&self) -> Option<&AtomicU64> {
        Some(self.left)
    }
}

/// The inside of a pattern: a scope that also knows where the cycle is.
pub(super) struct InCycle<'a> {
    pub(super) outer: &'a dyn Scope,
    pub(super) cycle: f64,
}

impl Scope for InCycle<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.outer)
    }
    fn word(&self, word: Word) -> Option<Value> {
        if word == Word::Cycle { Some(Value::Number(self.cycle)) } else { self.outer.word(word) }
    }
}
