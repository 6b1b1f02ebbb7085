//! Hand-picked derivations.

use serde::{Deserialize, Serialize};

use super::Expr;
use crate::source::Span;

/// A hand-picked derivation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// What it does and expects, in order. Each step fills local slots: one with the step itself, one with the first part
    /// that it made (or the step again, if it made none), and one for each part that its rule names.
    pub clauses: Vec<ExampleClause>,
    /// Where it is declared.
    pub span: Span,
}

/// A clause of an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExampleClause {
    /// A rule applied with chosen values.
    Step {
        /// What the example calls it.
        name: String,
        /// What is applied.
        application: Application,
        /// For each name that the rule gives parts the effects that make them, by their numbers among all that make some. What is made within a
        /// block is a list, and several blocks may give one name.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        products: Vec<Vec<usize>>,
    },
    /// A rule that must not be applicable with these values.
    Refuse {
        /// What must not be applicable.
        application: Application,
        /// The requirement that must stop it.
        by: Option<String>,
    },
    /// What must hold of the design so far.
    Expect(Expr),
}

/// A rule with a value for each of its locals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Application {
    /// The rule.
    pub rule: String,
    /// A value for each thing that it matches and chooses, by local slot;
    /// none for what follows from the others.
    pub values: Vec<Option<Expr>>,
    /// Where it is said.
    pub span: Span,
}
