//! Sets of known designs: how novel another one is, follows from what it shares with them.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::{Expr, Ty};
use crate::source::Span;

/// A set of known designs with the features that are compared (thesis 6.3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Novelty {
    /// What is compared.
    pub features: IndexMap<String, Feature>,
    /// The known designs by name: a value for each feature, in SI units; a Bool is 0 or 1, a value of an
    /// enumeration its place.
    pub known: IndexMap<String, Vec<f64>>,
    /// Where it is declared.
    pub span: Span,
}

/// What designs are compared by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// A quantity, a Count, a Bool or an enumeration.
    pub ty: Ty,
    /// What it is for a design: an expression of the score stage.
    pub value: Expr,
    /// How much it counts.
    pub weight: f64,
}
