//! What is observed of a motion beside its value.

use std::fmt;

use grammar_lang::eval::{EvalError, Scope, Value, evaluate};
use grammar_lang::ir::{RuleSet, Term, Ty};
use grammar_lang::units;
use serde::{Deserialize, Serialize};

use super::{MotionScope, Recording};

/// The value of an observed term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Observed {
    /// Whether something is so.
    Bool(bool),
    /// A quantity or a count, in SI units.
    Number(f64),
    /// A value of an enumeration.
    Word(String),
}

impl fmt::Display for Observed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(yes) => write!(f, "{yes}"),
            Self::Number(x) => write!(f, "{x}"),
            Self::Word(word) => f.write_str(word),
        }
    }
}

/// The values of the terms that a grammar observes, in their order; none where a term has no value for a motion.
#[must_use]
pub fn observe(recording: Recording<'_>) -> Vec<Option<Observed>> {
    let rules = recording.drive.candidate().rules;
    let Ok(scope) = MotionScope::new(recording) else { return vec![None; rules.observed.len()] };
    let one = |name: &String| {
        let term = rules.terms.get(name)?;
        told(rules, &term.ty, &value(name, term, &scope).ok()?)
    };
    rules.observed.iter().map(one).collect()
}

/// A value of a type as people know it.
fn told(rules: &RuleSet, ty: &Ty, value: &Value) -> Option<Observed> {
    match (ty, value) {
        (_, Value::Bool(yes)) => Some(Observed::Bool(*yes)),
        (Ty::Enum(of), Value::Number(place)) => {
            rules.value_of(of, *place).map(|word| Observed::Word(word.to_owned()))
        }
        (_, Value::Number(x)) => (x.abs() <= units::LARGEST).then_some(Observed::Number(*x)),
        _ => None,
    }
}

/// The value of a term, worked out once for a motion.
pub(super) fn value(name: &str, term: &Term, scope: &MotionScope<'_>) -> Result<Value, EvalError> {
    if let Some(known) = scope.remembered(name) {
        return Ok(known);
    }
    let value = evaluate(&term.value, scope, &mut Vec::new())?;
    scope.remember(name, &value);
    Ok(value)
}
