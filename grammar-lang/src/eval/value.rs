//! The values of expressions.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Curve, Valve, Valves, order};
use crate::ir::{Form, Table};

/// A value, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// What is not known yet: a local that comes before one that is known.
    Unknown,
    /// A quantity or a count.
    Number(f64),
    /// True or false.
    Bool(bool),
    /// A text.
    Text(Arc<str>),
    /// A vector: x, y, z with y up.
    Vector([f64; 3]),
    /// A rotation as a unit quaternion: w, x, y, z.
    Rotation([f64; 4]),
    /// A closed curve.
    Curve(Arc<Curve>),
    /// A pattern of the rule set, by name.
    Pattern(Arc<str>),
    /// A measured function.
    Table(Arc<Table>),
    /// A state of valves.
    Valve(Valve),
    /// States of valves over a cycle.
    Valves(Arc<Valves>),
    /// A shape.
    Shape(Form),
    /// A kind of part, with parameters.
    Kind(Arc<KindValue>),
    /// Something in the design.
    Reference(Reference),
    /// Several in order.
    List(Arc<[Value]>),
    /// Values to draw from.
    Domain(Arc<Domain>),
}

/// A kind of part, ready to be attached.
#[derive(Clone, Debug, PartialEq)]
pub struct KindValue {
    /// The kind's name.
    pub name: String,
    /// The parameters that were given.
    pub params: Vec<(String, Value)>,
}

/// Names a part for as long as the step that made it exists, or the place of a cell. What the number
/// means is the design's business.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PartId(u64);

impl PartId {
    /// The part with this number, as it is saved.
    #[must_use]
    pub const fn from_number(number: u64) -> Self {
        Self(number)
    }

    /// Its number.
    #[must_use]
    pub const fn number(self) -> u64 {
        self.0
    }
}

impl fmt::Display for PartId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Something in a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// A part.
    Part(PartId),
    /// A port of a part.
    Port(PartId, u8),
    /// The joint that holds a part.
    Joint(PartId),
    /// An element.
    Element(u32),
    /// A step of the derivation.
    Step(u64),
    /// A world of the scenarios of a task, by its place; 0 is the nominal one.
    World(u32),
}

/// Values to draw from.
#[derive(Clone, Debug)]
pub enum Domain {
    /// Everything between two ends, or every whole number.
    Range {
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
        /// Whether only whole numbers count.
        whole: bool,
    },
    /// These.
    Items(Vec<Value>),
}

/// Sets are the same whatever the order in which their values were written.
impl PartialEq for Domain {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Range { low, high, whole }, Self::Range { low: least, high: most, whole: own }) => {
                (low, high, whole) == (least, most, own)
            }
            (Self::Items(items), Self::Items(others)) => {
                let is_in = |all: &[Value], one: &Value| all.contains(one);
                items.iter().all(|one| is_in(others, one)) && others.iter().all(|one| is_in(items, one))
            }
            _ => false,
        }
    }
}

impl Domain {
    /// How many values there are; none in a continuous range can be counted.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Self::Items(items) => items.len(),
            Self::Range { low, high, whole: true } => {
                (order::floor(*high) - order::ceil(*low) + 1.0).max(0.0) as usize
            }
            Self::Range { .. } => 0,
        }
    }

    /// The ends of a range.
    #[must_use]
    pub fn ends(&self) -> Option<(f64, f64)> {
        match self {
            Self::Range { low, high, .. } => Some((*low, *high)),
            Self::Items(_) => None,
        }
    }

    /// A value by its place.
    #[must_use]
    pub fn item(&self, index: usize) -> Option<Value> {
        match self {
            Self::Items(items) => items.get(index).cloned(),
            Self::Range { low, .. } => {
                (index < self.count()).then(|| Value::Number(order::ceil(*low) + index as f64))
            }
        }
    }

    /// Whether a value is one of these.
    #[must_use]
    pub fn holds(&self, value: &Value) -> bool {
        match (self, value) {
            (Self::Range { low, high, whole }, Value::Number(x)) => {
                order::is_within(*low, *x, *high) && (!whole || libm::floor(*x) == *x)
            }
            (Self::Items(items), value) => items.iter().any(|item| item.is_same(value)),
            _ => false,
        }
    }

    /// Whether every value of another domain is one of this one.
    #[must_use]
    pub fn holds_all(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Range { low, high, .. }, Self::Range { low: least, high: most, .. }) => {
                !order::is_less(*least, *low) && !order::is_less(*high, *most)
            }
            (Self::Range { low, high, .. }, Self::Items(items)) => {
                items.iter().all(|x| x.as_number().is_some_and(|x| order::is_within(*low, x, *high)))
            }
            (Self::Items(all), other) => {
                let countable = !matches!(other, Self::Range { whole: false, .. });
                countable
                    && other.count() <= 1000
                    && other.items().all(|x| all.iter().any(|item| item.is_same(&x)))
            }
        }
    }

    /// The values one by one; for a continuous range, none.
    pub fn items(&self) -> impl Iterator<Item = Value> {
        (0..self.count()).filter_map(|i| self.item(i))
    }
}

impl Value {
    /// The items of a list; of anything else, none.
    #[must_use]
    pub fn items(&self) -> &[Value] {
        match self {
            Self::List(items) => items,
            _ => &[],
        }
    }

    /// Whether two values are equal, numbers but for rounding.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        let are_same =
            |a: &[Self], b: &[Self]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.is_same(b));
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => order::is_same(*a, *b),
            (Self::Vector(a), Self::Vector(b)) => a.iter().zip(b).all(|(a, b)| order::is_same(*a, *b)),
            (Self::List(a), Self::List(b)) => are_same(a, b),
            (Self::Kind(a), Self::Kind(b)) => {
                let params = a.params.iter().zip(&b.params);
                a.name == b.name
                    && a.params.len() == b.params.len()
                    && params.clone().all(|((name, a), (other, b))| name == other && a.is_same(b))
            }
            (a, b) => a == b,
        }
    }

    /// The number, if it is one.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Number(x) => Some(*x),
            _ => None,
        }
    }
}
