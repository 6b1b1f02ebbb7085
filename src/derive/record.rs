//! Steps as they are kept and saved.

use std::sync::Arc;

use grammar_lang::eval::{Curve, Domain, KindValue, Reference, Value, Valve, Valves};
use grammar_lang::ir::{Form, Table};
use serde::{Deserialize, Serialize};

/// One rule application: what it matched and what it chose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Its number, which never changes: parts are named after it.
    pub id: u64,
    /// The rule.
    pub rule: String,
    /// The values of the rule's locals: matches, then choices.
    pub locals: Vec<Recorded>,
}

/// A derivation as it is kept: its steps, which lead to its design again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Steps {
    /// The steps, in order.
    pub steps: Vec<Step>,
    /// The number of the next step; steps that were taken back had numbers, too.
    pub next: u64,
}

/// A value of a match or choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Recorded {
    /// A quantity in SI units or a count.
    Number(f64),
    /// True or false.
    Bool(bool),
    /// A text.
    Text(String),
    /// A pattern's name.
    Pattern(String),
    /// A kind of part with its parameters.
    Kind(String, Vec<(String, Recorded)>),
    /// A part, port or step.
    Reference(Reference),
    /// A vector.
    Vector([f64; 3]),
    /// A rotation.
    Rotation([f64; 4]),
    /// A shape.
    Shape(Form),
    /// A curve.
    Curve(Curve),
    /// A measured function.
    Table(Table),
    /// A state of valves.
    Valve(Valve),
    /// States of valves over a cycle.
    Valves(Valves),
    /// Several in order: a list, or the fields of a record.
    List(Vec<Recorded>),
    /// A range to draw from: its ends, and whether only whole numbers count.
    Range(f64, f64, bool),
    /// Values to draw from.
    Set(Vec<Recorded>),
}

impl Recorded {
    /// Records a value.
    #[must_use]
    pub fn new(value: &Value) -> Self {
        match value {
            Value::Number(x) => Self::Number(*x),
            // Nothing reads what was never known.
            Value::Unknown => Self::Bool(false),
            Value::Bool(x) => Self::Bool(*x),
            Value::Text(x) => Self::Text(x.to_string()),
            Value::Pattern(x) => Self::Pattern(x.to_string()),
            Value::Reference(x) => Self::Reference(*x),
            Value::Kind(kind) => {
                let params = kind.params.iter().map(|(n, v)| (n.clone(), Self::new(v))).collect();
                Self::Kind(kind.name.clone(), params)
            }
            Value::Vector(x) => Self::Vector(*x),
            Value::Rotation(x) => Self::Rotation(*x),
            Value::Shape(x) => Self::Shape(*x),
            Value::Curve(x) => Self::Curve((**x).clone()),
            Value::Table(x) => Self::Table((**x).clone()),
            Value::Valve(x) => Self::Valve(*x),
            Value::Valves(x) => Self::Valves((**x).clone()),
            Value::List(items) => Self::List(items.iter().map(Self::new).collect()),
            Value::Domain(domain) => match &**domain {
                Domain::Range { low, high, whole } => Self::Range(*low, *high, *whole),
                Domain::Items(items) => Self::Set(items.iter().map(Self::new).collect()),
            },
        }
    }

    /// Whether it is something in the design that is asked for, or holds it.
    #[must_use]
    pub fn refers(&self, to: &impl Fn(&Reference) -> bool) -> bool {
        match self {
            Self::Reference(reference) => to(reference),
            Self::List(items) | Self::Set(items) => items.iter().any(|i| i.refers(to)),
            _ => false,
        }
    }

    /// The value that was recorded.
    #[must_use]
    pub fn value(&self) -> Value {
        match self {
            Self::Number(x) => Value::Number(*x),
            Self::Bool(x) => Value::Bool(*x),
            Self::Text(x) => Value::Text(x.as_str().into()),
            Self::Pattern(x) => Value::Pattern(x.as_str().into()),
            Self::Reference(x) => Value::Reference(*x),
            Self::Kind(name, params) => Value::Kind(Arc::new(KindValue {
                name: name.clone(),
                params: params.iter().map(|(n, v)| (n.clone(), v.value())).collect(),
            })),
            Self::Vector(x) => Value::Vector(*x),
            Self::Rotation(x) => Value::Rotation(*x),
            Self::Shape(x) => Value::Shape(*x),
            Self::Curve(x) => Value::Curve(Arc::new(x.clone())),
            Self::Table(x) => Value::Table(Arc::new(x.clone())),
            Self::Valve(x) => Value::Valve(*x),
            Self::Valves(x) => Value::Valves(Arc::new(x.clone())),
            Self::List(items) => Value::List(items.iter().map(Self::value).collect()),
            Self::Range(low, high, whole) => {
                Value::Domain(Arc::new(Domain::Range { low: *low, high: *high, whole: *whole }))
            }
            Self::Set(items) => {
                Value::Domain(Arc::new(Domain::Items(items.iter().map(Self::value).collect())))
            }
        }
    }
}
