//! What may be known of a value before there is a design.

use super::{Interval, Kinds};

/// Whether something is true, as far as is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// It is true, whatever the design.
    Always,
    /// It is false, whatever the design.
    Never,
    /// Nothing is known.
    Sometimes,
}

impl Truth {
    /// What is known exactly.
    #[must_use]
    pub fn known(value: bool) -> Self {
        if value { Self::Always } else { Self::Never }
    }

    /// Always if `yes`, never if `no`.
    #[must_use]
    pub fn of(yes: bool, no: bool) -> Self {
        match (yes, no) {
            (true, _) => Self::Always,
            (_, true) => Self::Never,
            _ => Self::Sometimes,
        }
    }

    /// The opposite.
    #[must_use]
    pub fn negated(self) -> Self {
        match self {
            Self::Always => Self::Never,
            Self::Never => Self::Always,
            Self::Sometimes => Self::Sometimes,
        }
    }

    /// Whether both are true.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::of(self == Self::Always && other == Self::Always, self == Self::Never || other == Self::Never)
    }

    /// Whether one of them is true.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        self.negated().and(other.negated()).negated()
    }
}

/// All values that an expression may have.
#[derive(Clone, Debug, PartialEq)]
pub enum Abstract {
    /// Numbers.
    Number(Interval),
    /// True or false.
    Bool(Truth),
    /// Parts of these kinds.
    Part(Kinds),
    /// A port of parts of these kinds.
    Port(Kinds),
    /// Kinds of parts, ready to be attached.
    Kind(Kinds),
    /// Several values, in a list, a group or a domain: what each may be, and how many.
    Many(Box<Abstract>, Interval),
    /// Anything.
    Any,
}

impl Abstract {
    /// The numbers, or every number.
    #[must_use]
    pub fn numbers(&self) -> Interval {
        match self {
            Self::Number(interval) => *interval,
            _ => Interval::ALL,
        }
    }

    /// Whether it is true.
    #[must_use]
    pub fn truth(&self) -> Truth {
        match self {
            Self::Bool(truth) => *truth,
            _ => Truth::Sometimes,
        }
    }

    /// What an item may be.
    #[must_use]
    pub fn item(&self) -> Self {
        match self {
            Self::Many(item, _) => (**item).clone(),
            _ => Self::Any,
        }
    }

    /// How many items there are.
    #[must_use]
    pub fn length(&self) -> Interval {
        match self {
            Self::Many(_, length) => *length,
            _ => Interval::NOT_NEGATIVE,
        }
    }

    /// Everything that either may be.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => Self::Number(a.hull(b)),
            (Self::Bool(a), Self::Bool(b)) => Self::Bool(if a == b { a } else { Truth::Sometimes }),
            (Self::Part(a), Self::Part(b)) => Self::Part(a.and(b)),
            (Self::Port(a), Self::Port(b)) => Self::Port(a.and(b)),
            (Self::Kind(a), Self::Kind(b)) => Self::Kind(a.and(b)),
            (Self::Many(a, n), Self::Many(b, m)) => Self::Many(Box::new(a.hull(*b)), n.hull(m)),
            _ => Self::Any,
        }
    }
}
