//! Checks a program and lowers it to the typed rule set, in phases that only know those before them:
//!
//! 1. `environment`: the program, and what holds of it before any expression is looked at;
//! 2. `expressions`: types, names, constants, functions, by the stage in which they are read;
//! 3. `declarations`: a file for each kind;
//! 4. `assembly`: which of them the grammar uses, whether they fit together, the rule set.

mod assembly;
mod built_in;
mod declarations;
mod environment;
mod expressions;
mod found;

use crate::diagnostics::Diagnostic;
use crate::eval::Budget;
use crate::ir::RuleSet;
use crate::names::Program;
use crate::source::{SourceMap, Span};
use assembly::Assembly;
use declarations::Declarations;
use environment::Environment;
use expressions::Expressions;
use found::Found;

pub use declarations::usual::{USUAL, Usual};

/// Of a text with several grammars and variants, what one of them could use: each may leave to the
/// others what it does not use itself.
#[derive(Clone, Debug, Default)]
pub struct Idle {
    /// The names that could be used.
    pub there: Vec<Span>,
    /// A warning for each that is not.
    pub unused: Vec<Diagnostic>,
}

/// What a check gives.
#[derive(Debug)]
pub struct Checked {
    /// The rule set, if no error was found and the first module is a grammar.
    pub ruleset: Option<RuleSet>,
    /// What was found.
    pub found: Vec<Diagnostic>,
    /// What is not used, of a text with several grammars.
    pub idle: Idle,
}

/// Checks a program.
#[must_use]
pub fn check(
    program: &Program,
    sources: &SourceMap,
    overrides: &[(String, String)],
    budget: &Budget,
) -> Checked {
    let environment = Environment::of(program, sources, overrides);
    let mut found = Found::default();
    built_in::check(program, &mut found);
    let expressions = Expressions::new(&environment, found, budget);
    let declarations = Declarations::new(expressions);
    Assembly::new(declarations).check()
}
