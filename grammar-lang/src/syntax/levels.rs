//! What binds how tightly: the levels of an expression, which `grammar.pest` leaves flat.

use super::parser::Rule;

/// A level, named by what its operator does.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    /// `a .. b`
    Range,
    /// `a or b or c`
    Disjunction,
    /// `a and b and c`
    Conjunction,
    /// `not a`
    Negation,
    /// `a < b`
    Comparison,
    /// `a + b - c`
    Sum,
    /// `a * b / c`
    Product,
    /// `-a`
    Sign,
    /// `a at b`
    AtTime,
}

impl Level {
    /// The loosest level in a pair that is a flat row of operators and operands.
    pub(super) fn loosest(rule: Rule) -> Option<Self> {
        match rule {
            Rule::expr | Rule::range => Some(Self::Range),
            Rule::sum => Some(Self::Sum),
            _ => None,
        }
    }

    /// The level that binds tighter; operands are the tightest.
    pub(super) fn tighter(self) -> Option<Self> {
        Some(match self {
            Self::Range => Self::Disjunction,
            Self::Disjunction => Self::Conjunction,
            Self::Conjunction => Self::Negation,
            Self::Negation => Self::Comparison,
            Self::Comparison => Self::Sum,
            Self::Sum => Self::Product,
            Self::Product => Self::Sign,
            Self::Sign => Self::AtTime,
            Self::AtTime => return None,
        })
    }

    /// What the pair of this level would be called.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::Disjunction => "disjunction",
            Self::Conjunction => "conjunction",
            Self::Negation => "negation",
            Self::Comparison => "comparison",
            Self::Sum => "sum",
            Self::Product => "product",
            Self::Sign => "sign",
            Self::AtTime => "at_time",
        }
    }

    /// Whether its operator stands before an operand, not between two.
    pub(super) fn is_prefix(self) -> bool {
        matches!(self, Self::Negation | Self::Sign)
    }

    /// Whether a pair is the operator of this level.
    pub(super) fn has(self, rule: Rule) -> bool {
        match self {
            Self::Range => rule == Rule::dots,
            Self::Disjunction => rule == Rule::kw_or,
            Self::Conjunction => rule == Rule::kw_and,
            Self::Negation => rule == Rule::kw_not,
            Self::Comparison => rule == Rule::compare_op,
            Self::Sum => rule == Rule::sum_op,
            Self::Product => rule == Rule::product_op,
            Self::Sign => rule == Rule::minus,
            Self::AtTime => rule == Rule::kw_at,
        }
    }
}
