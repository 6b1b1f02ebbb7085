//! Scores a recorded motion with the grammar's terms.

use grammar_lang::eval::{EvalError, Reference, Scope, Value, evaluate};
use grammar_lang::ir::{RuleSet, Word};

use crate::derive::{Derivation, DesignScope};
use crate::simulate::Motion;

/// The value of an objective with its terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// The objective's number, as the grammar states it.
    pub value: f64,
    /// Terms in SI units, in the order of the rule set.
    pub terms: Vec<(String, f64)>,
}

/// Scores a motion.
///
/// # Errors
///
/// [`EvalError`] when a term or the objective has no value.
pub fn score(rules: &RuleSet, derivation: &Derivation, motion: &Motion) -> Result<Score, EvalError> {
    let scope = MotionScope { design: DesignScope::new(rules, derivation), motion };
    let mut terms = Vec::with_capacity(rules.terms.len());
    for (name, term) in &rules.terms {
        terms
            .push((name.clone(), evaluate(&term.value, &scope, &mut Vec::new())?.as_number().unwrap_or(0.0)));
    }
    Ok(Score { value: value(rules, &scope)?, terms })
}

/// The objective alone.
///
/// # Errors
///
/// [`EvalError`] when the objective has no value.
pub fn objective(rules: &RuleSet, derivation: &Derivation, motion: &Motion) -> Result<f64, EvalError> {
    value(rules, &MotionScope { design: DesignScope::new(rules, derivation), motion })
}

fn value(rules: &RuleSet, scope: &MotionScope<'_>) -> Result<f64, EvalError> {
    Ok(evaluate(&rules.objective.value, scope, &mut Vec::new())?.as_number().unwrap_or(0.0))
}

/// What terms can read: the design and the whole recorded motion.
struct MotionScope<'a> {
    design: DesignScope<'a>,
    motion: &'a Motion,
}

impl Scope for MotionScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Start => Some(Value::Number(0.0)),
            Word::End | Word::Duration => Some(Value::Number(self.motion.duration)),
            Word::Elements => {
                let count = self.motion.placements.len() as u32;
                Some(Value::List((0..count).map(|i| Value::Reference(Reference::Element(i))).collect()))
            }
            _ => self.design.word(word),
        }
    }

    fn attribute_at(&self, of: &Value, name: &str, time: f64) -> Option<Value> {
        let Value::Reference(Reference::Element(element)) = of else { return None };
        let pose = self.motion.pose(*element as usize, time)?;
        match name {
            "position" => {
                let p = pose.translation.vector;
                Some(Value::Vector([p.x, p.y, p.z]))
            }
            "rotation" => {
                let r = pose.rotation.into_inner();
                Some(Value::Rotation([r.w, r.i, r.j, r.k]))
            }
            _ => None,
        }
    }
}
