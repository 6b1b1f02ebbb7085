//! What the tree and the rule set both say by a word or a sign: operators, aggregates, what is done with places.

/// What is done with places of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Painting {
    /// Each gets a cell, in the place of what was there.
    Fill,
    /// The cells that are there get attributes.
    Paint,
    /// Nothing is there any more.
    Clear,
}

impl Painting {
    /// The word that opens the clause.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Fill => "fill",
            Self::Paint => "paint",
            Self::Clear => "clear",
        }
    }
}

/// How an aggregate gathers its items.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gather {
    /// How many.
    Count,
    /// Their sum.
    Sum,
    /// Their mean.
    Mean,
    /// The least.
    Min,
    /// The greatest.
    Max,
    /// Their standard deviation: the root of the mean square of what each differs from the mean by.
    Deviation,
    /// What a share of them lies below, between two of them in proportion.
    Quantile,
    /// How many groups of neighbours, in which the gathered value is the same.
    Clusters,
    /// Whether all hold.
    Forall,
    /// Whether one holds.
    Exists,
}

impl Gather {
    /// The word that opens it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Count => "count",
            Self::Sum => "sum",
            Self::Mean => "mean",
            Self::Min => "min",
            Self::Max => "max",
            Self::Deviation => "deviation",
            Self::Quantile => "quantile",
            Self::Clusters => "clusters",
            Self::Forall => "forall",
            Self::Exists => "exists",
        }
    }
}

/// An operator with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    And,
    Or,
    Is,
    IsNot,
    Adds,
}

impl Operator {
    /// Whether it adds, subtracts, multiplies or divides.
    #[must_use]
    pub fn is_arithmetic(self) -> bool {
        matches!(self, Self::Add | Self::Subtract | Self::Multiply | Self::Divide)
    }

    /// The comparison with its sides changed: `a < b` is `b > a`.
    #[must_use]
    pub fn turned_round(self) -> Option<Self> {
        Some(match self {
            Self::Less => Self::Greater,
            Self::LessEqual => Self::GreaterEqual,
            Self::Greater => Self::Less,
            Self::GreaterEqual => Self::LessEqual,
            Self::Equal | Self::NotEqual => self,
            _ => return None,
        })
    }

    /// How a text writes it.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
            Self::And => "and",
            Self::Or => "or",
            Self::Is => "is",
            Self::IsNot => "is not",
            Self::Adds => "adds",
        }
    }
}
