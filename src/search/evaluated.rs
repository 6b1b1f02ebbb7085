//! What comes of an evaluation.

use super::tally::Missing;
use crate::score::Observed;

/// The value of an evaluation, or why it has none.
pub(super) type Valued = Result<f64, Missing>;

/// An evaluation, as far as it was made.
#[derive(Clone, Debug)]
pub(super) struct Evaluated {
    pub(super) value: Valued,
    /// What its value could come to at most, where more is better, when that was least. It is known by the
    /// middle of the motion or later, also of motions that turn out not to be valid; infinite where no bound follows.
    pub(super) ceiling: f64,
    /// What was observed of its motion, where it could be a new best.
    pub(super) observed: Option<Vec<Option<Observed>>>,
    /// What each objective is, where a front is searched for; the value is what the move is after then.
    pub(super) each: Vec<f64>,
}

impl Evaluated {
    /// A value of which nothing else is known.
    pub(super) fn of(value: Valued) -> Self {
        Self { value, ceiling: f64::INFINITY, observed: None, each: Vec::new() }
    }
}
