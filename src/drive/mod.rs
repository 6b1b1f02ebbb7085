//! Actuation: parameters that the search varies become targets over time.
//!
//! A [`Drive`] knows which variables a body's actuators have. Their values for
//! one evaluation are a [`Parameters`]: every actuator that is not a mirror image
//! has its own set, images follow their originals, shared variables are there once.

mod mutate;
mod scope;

use std::sync::Arc;

use grammar_lang::eval::{EvalError, Reference, Scope, Value, evaluate};
use grammar_lang::ir::{Actuation, RuleSet, Ty, Variable};

use crate::derive::Derivation;
use crate::derive::random::Stream;
use crate::design::{Body, PartId};
use crate::simulate::Targets;
use scope::DriveScope;

/// Values of all varied quantities of a body, in SI units; a Bool is 0 or 1.
pub type Parameters = Vec<f64>;

/// A run of values within [`Parameters`] that belong to one variable.
#[derive(Clone, Debug, PartialEq)]
struct Field {
    /// Index of the actuation in [`Drive::actuations`].
    actuation: usize,
    /// Index of the variable in the actuation.
    variable: usize,
    /// The original actuator; none for a shared variable.
    owner: Option<PartId>,
    /// Where it starts.
    start: usize,
}

/// The actuation of one body.
#[derive(Clone, Debug)]
pub struct Drive<'r> {
    rules: &'r RuleSet,
    derivation: Arc<Derivation>,
    /// Actuators in the order of the assembly: part, original, actuation.
    actuators: Vec<(PartId, PartId, usize)>,
    actuations: Vec<(&'r str, &'r Actuation)>,
    fields: Vec<Field>,
    length: usize,
}

impl<'r> Drive<'r> {
    /// The actuation of a body of a derivation.
    #[must_use]
    pub fn new(rules: &'r RuleSet, derivation: Arc<Derivation>, body: &Body) -> Self {
        let mut drive = Self {
            rules,
            derivation,
            actuators: Vec::new(),
            actuations: Vec::new(),
            fields: Vec::new(),
            length: 0,
        };
        for id in &body.actuators {
            let Some(part) = drive.derivation.design.parts.get(id) else { continue };
            let original = part.image_of.unwrap_or(*id);
            let Some((name, actuation)) =
                rules.actuated.get(&part.kind).and_then(|n| rules.actuations.get_key_value(n))
            else {
                continue;
            };
            let index = drive.actuations.iter().position(|(n, _)| n == name).unwrap_or_else(|| {
                drive.actuations.push((name, actuation));
                drive.actuations.len() - 1
            });
            drive.actuators.push((*id, original, index));
            for (i, variable) in actuation.variables.iter().enumerate() {
                let owner = (!variable.shared).then_some(original);
                let field = Field { actuation: index, variable: i, owner, start: drive.length };
                let known =
                    drive.fields.iter().any(|f| (f.actuation, f.variable, f.owner) == (index, i, owner));
                if !known {
                    drive.fields.push(field);
                    drive.length += variable.size.unwrap_or(1);
                }
            }
        }
        drive
    }

    /// Whether the search has nothing to vary: one evaluation says all.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        self.length == 0
    }

    /// How many values the parameters have.
    #[must_use]
    pub fn length(&self) -> usize {
        self.length
    }

    fn variable(&self, field: &Field) -> Option<&'r Variable> {
        self.actuations.get(field.actuation)?.1.variables.get(field.variable)
    }

    /// What each value is, for people: `period`, `points[2] of actuator 1`.
    #[must_use]
    pub fn labels(&self) -> Vec<String> {
        let originals: Vec<PartId> =
            self.actuators.iter().filter(|(id, o, _)| id == o).map(|(id, ..)| *id).collect();
        let mut labels = Vec::with_capacity(self.length);
        for field in &self.fields {
            let Some(variable) = self.variable(field) else { continue };
            let owner = field.owner.and_then(|o| originals.iter().position(|id| *id == o));
            let whose = owner.map_or(String::new(), |i| format!(" of actuator {}", i + 1));
            match variable.size {
                None => labels.push(format!("{}{whose}", variable.name)),
                Some(n) => labels.extend((0..n).map(|i| format!("{}[{i}]{whose}", variable.name))),
            }
        }
        labels
    }

    /// Draws every value evenly from its domain.
    #[must_use]
    pub fn draw(&self, random: &mut Stream) -> Parameters {
        let mut out = Vec::with_capacity(self.length);
        for field in &self.fields {
            let Some(variable) = self.variable(field) else { continue };
            for _ in 0..variable.size.unwrap_or(1) {
                let (low, high) = variable.domain;
                out.push(match variable.ty {
                    Ty::Bool => f64::from(u8::from(random.unit() < 0.5)),
                    Ty::Count => low + random.below((high - low) as usize + 1) as f64,
                    _ => low + (high - low) * random.unit(),
                });
            }
        }
        out
    }

    /// Whether saved values fit this body and lie in their domains.
    #[must_use]
    pub fn fits(&self, parameters: &[f64]) -> bool {
        parameters.len() == self.length
            && self.fields.iter().all(|field| {
                let Some(variable) = self.variable(field) else { return false };
                let (low, high) = variable.domain;
                parameters
                    .iter()
                    .skip(field.start)
                    .take(variable.size.unwrap_or(1))
                    .all(|x| x.is_finite() && *x >= low - 1e-12 && *x <= high + 1e-12)
            })
    }

    fn value(&self, actuation: usize, variable: usize, owner: PartId, parameters: &[f64]) -> Option<Value> {
        let field = self.fields.iter().find(|f| {
            f.actuation == actuation && f.variable == variable && f.owner.is_none_or(|o| o == owner)
        })?;
        let declared = self.variable(field)?;
        let one = |x: &f64| if declared.ty == Ty::Bool { Value::Bool(*x != 0.0) } else { Value::Number(*x) };
        match declared.size {
            None => parameters.get(field.start).map(one),
            Some(n) => {
                Some(Value::List(parameters.get(field.start..field.start + n)?.iter().map(one).collect()))
            }
        }
    }

    /// The target angles of every actuator over the whole motion.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn targets(&self, parameters: &[f64]) -> Result<Targets, EvalError> {
        let model = &self.rules.model;
        let samples = libm::ceil(model.duration / model.control - 1e-9) as usize + 1;
        let count = self.actuators.len();
        let mut angles = vec![0.0; samples * count];
        for (column, (id, original, index)) in self.actuators.iter().enumerate() {
            let Some((_, actuation)) = self.actuations.get(*index) else { continue };
            let mut scope = DriveScope::new(self.rules, &self.derivation);
            let mut locals = vec![Value::Reference(Reference::Part(*id))];
            for variable in 0..actuation.variables.len() {
                locals.extend(self.value(*index, variable, *original, parameters));
            }
            for (_, value) in &actuation.lets {
                let value = evaluate(value, &scope, &mut locals)?;
                locals.push(value);
            }
            let fixed = locals.len();
            let kind = self.derivation.design.parts.get(id).map_or("", |p| p.kind.as_str());
            let (low, high) = self.rules.actuators.get(kind).map_or((0.0, 0.0), |a| a.bend);
            for sample in 0..samples {
                scope.time = sample as f64 * model.control;
                locals.truncate(fixed);
                for (_, value) in &actuation.moving {
                    let value = evaluate(value, &scope, &mut locals)?;
                    locals.push(value);
                }
                let angle =
                    evaluate(&actuation.drive, &scope as &dyn Scope, &mut locals)?.as_number().unwrap_or(0.0);
                if let Some(cell) = angles.get_mut(sample * count + column) {
                    // An actuator cannot bend further than it can.
                    *cell = angle.max(low).min(high);
                }
            }
        }
        Ok(Targets { interval: model.control, actuators: count, angles })
    }
}
