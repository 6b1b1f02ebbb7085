//! Types of expressions.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::units::Dimension;

/// The type of an expression.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ty {
    /// A quantity with a dimension; a bare number has the dimension one.
    Quantity(Dimension),
    /// A whole number.
    Count,
    /// True or false.
    Bool,
    /// A text.
    Text,
    /// A vector whose components have a dimension.
    Vector(Dimension),
    /// A rotation.
    Rotation,
    /// A closed curve over a cycle from 0 to 1.
    Curve(Dimension),
    /// A named fixed curve of an angle over a cycle.
    Pattern,
    /// A measured function, from a quantity of the one dimension to one of the other.
    Table(Dimension, Dimension),
    /// A state of an actuator's valves.
    Valve,
    /// The states of an actuator's valves over a cycle.
    Valves,
    /// A geometric shape.
    Shape,
    /// A distribution of steps with a dimension.
    Distribution(Dimension),
    /// A quantity that changes over the motion: ask for it `at` a time.
    Track(Box<Ty>),
    /// A part of the design.
    Part,
    /// An actuator of the design.
    Actuator,
    /// A place of a lattice, or the cell there.
    Cell,
    /// A port of a part.
    Port,
    /// A joint between two parts.
    Joint,
    /// A value of an enumeration.
    Enum(String),
    /// A record: named fields in order.
    Record(String, Vec<(String, Ty)>),
    /// A rigid piece of the simulated body.
    Element,
    /// A world of a set of scenarios.
    World,
    /// A step of the derivation.
    Step,
    /// A declared kind of part, or one with parameters, ready to be attached.
    Kind,
    /// `part`, `block`, `actuator`, or a declared kind used as a collection.
    Group,
    /// Several of the same type in order.
    List(Box<Ty>),
    /// The values from which something is drawn.
    Domain(Box<Ty>),
    /// Something is wrong and has been reported.
    Unknown,
}

impl Ty {
    /// A bare number.
    pub const NUMBER: Self = Self::Quantity(Dimension::NUMBER);

    /// The dimension, if this is a quantity or a count.
    #[must_use]
    pub fn dimension(&self) -> Option<Dimension> {
        match self {
            Self::Quantity(d) => Some(*d),
            Self::Count => Some(Dimension::NUMBER),
            _ => None,
        }
    }

    /// Whether a value of this type can stand where `wanted` is asked for.
    #[must_use]
    pub fn fits(&self, wanted: &Self) -> bool {
        match (self, wanted) {
            (Self::Unknown, _) | (_, Self::Unknown) => true,
            (Self::Count, Self::Quantity(d)) => d.is_number(),
            (Self::Actuator | Self::Cell, Self::Part) => true,
            (Self::List(a), Self::List(b))
            | (Self::Domain(a), Self::Domain(b))
            | (Self::Track(a), Self::Track(b)) => a.fits(b),
            (a, b) => a == b,
        }
    }

    /// The type that holds both, if there is one.
    #[must_use]
    pub fn common(&self, other: &Self) -> Option<Self> {
        if self.fits(other) {
            Some(if *other == Self::Unknown { self.clone() } else { other.clone() })
        } else if other.fits(self) {
            Some(self.clone())
        } else {
            None
        }
    }
}

impl From<Dimension> for Ty {
    fn from(dimension: Dimension) -> Self {
        Self::Quantity(dimension)
    }
}

impl fmt::Display for Ty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quantity(d) => write!(f, "{d}"),
            Self::Count => f.write_str("Count"),
            Self::Bool => f.write_str("Bool"),
            Self::Text => f.write_str("Text"),
            Self::Vector(d) => write!(f, "vector of {d}"),
            Self::Rotation => f.write_str("Rotation"),
            Self::Curve(d) => write!(f, "curve of {d}"),
            Self::Pattern => f.write_str("Pattern"),
            Self::Table(from, to) => write!(f, "table {from} -> {to}"),
            Self::Valve => f.write_str("state of valves"),
            Self::Valves => f.write_str("cycle of valves"),
            Self::Shape => f.write_str("shape"),
            Self::Distribution(d) => write!(f, "distribution of {d}"),
            Self::Track(t) => write!(f, "{t} over time"),
            Self::Part => f.write_str("part"),
            Self::Actuator => f.write_str("actuator"),
            Self::Cell => f.write_str("cell"),
            Self::Port => f.write_str("port"),
            Self::Joint => f.write_str("joint"),
            Self::Enum(name) | Self::Record(name, _) => f.write_str(name),
            Self::Element => f.write_str("element"),
            Self::World => f.write_str("world"),
            Self::Step => f.write_str("step"),
            Self::Kind => f.write_str("kind of part"),
            Self::Group => f.write_str("group of parts"),
            Self::List(t) => write!(f, "list of {t}"),
            Self::Domain(t) => write!(f, "domain of {t}"),
            Self::Unknown => f.write_str("unknown"),
        }
    }
}
