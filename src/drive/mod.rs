//! Actuation: parameters that the search varies become targets over time.
//!
//! A [`Drive`] knows which variables a body's actuators have. Their values for
//! one evaluation are a [`Parameters`]: every actuator that is not a mirror image
//! has its own set, images follow their originals, shared variables are there once.

mod begun;
mod bends;
mod conditions;
mod cycle;
mod exploring;
mod feedback;
mod hardware;
mod mutate;
mod network;
mod passive;
mod policies;
mod remembered;
mod scope;
mod shares;
mod sides;
mod signals;
mod traced;
mod uneven;
mod untunable;

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{EvalError, Made, MadeActuator, Reference, Value, Valves, evaluate};
use grammar_lang::ir::{Actuation, Owner, Task, Ty, Variable};
use grammar_lang::source::Span;

use crate::derive::random::Stream;
use crate::derive::{Candidate, DesignScope};
use crate::design::PartId;
use crate::simulate::Targets;
pub use begun::check_driven;
pub use bends::Bends;
pub use conditions::Conditions;
pub use cycle::{Asked, Cycle};
pub use exploring::{Exploration, Explorer};
pub use feedback::ControlLaw;
pub(crate) use passive::position_of;
use policies::PolicyNetwork;
pub use policies::{Decision, INPUT_LIMIT};
use scope::DriveScope;
pub use signals::{Signal, Trace};
pub use traced::Traced;

/// Values of all varied quantities of a body, in SI units; a Bool is 0 or 1.
pub type Parameters = Vec<f64>;

/// Who has a run of values of their own.
#[derive(Clone, Debug, PartialEq)]
enum Holder {
    /// All actuators, whatever actuates them.
    Everyone,
    /// The whole body, where it is actuated so.
    Body,
    /// One actuator and its images.
    Actuator(PartId),
    /// All actuators of a group, by the numbers that they share.
    Group(Vec<f64>),
    /// A policy, by its index in [`Drive::policies`]: its weights.
    Policy(usize),
}

/// A run of values within [`Parameters`] that belong to one variable.
#[derive(Clone, Debug, PartialEq)]
struct Field {
    /// Index of the actuation in [`Drive::actuations`].
    actuation: usize,
    /// Index of the variable in the actuation.
    variable: usize,
    /// Who has these values.
    holder: Holder,
    /// Where it starts.
    start: usize,
}

/// A cell keeps at least a tenth of its size.
const LEAST_STRAIN: f64 = -0.9;

/// An actuator with what drives it.
#[derive(Clone, Debug)]
struct Driven {
    id: PartId,
    /// Index of its actuation.
    actuation: usize,
    /// The fields that hold the values of the actuation's variables, in their order.
    fields: Vec<usize>,
}

/// The actuation of one body for one task.
#[derive(Clone, Debug)]
pub struct Drive<'r> {
    candidate: Candidate<'r>,
    task: &'r Task,
    /// Actuators in the order of the assembly.
    actuators: Vec<Driven>,
    actuations: Vec<(&'r str, &'r Actuation)>,
    fields: Vec<Field>,
    /// The policies that decide for actuators of the body.
    policies: Vec<PolicyNetwork<'r>>,
    length: usize,
    /// How many operations its expressions may still take, where it is only tried.
    left: Option<Arc<AtomicU64>>,
}

impl<'r> Drive<'r> {
    /// The actuation of a body for a task.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when the group of an actuator has no value.
    pub fn new(candidate: &Candidate<'r>, task: &'r Task) -> Result<Self, EvalError> {
        let mut drive = Self {
            candidate: candidate.clone(),
            task,
            actuators: Vec::new(),
            actuations: Vec::new(),
            fields: Vec::new(),
            policies: Vec::new(),
            length: 0,
            left: None,
        };
        for id in &candidate.body.actuators {
            drive.add(*id)?;
        }
        drive.add_policies();
        Ok(drive)
    }

    fn add(&mut self, id: PartId) -> Result<(), EvalError> {
        let Candidate { rules, derivation, .. } = self.candidate.clone();
        let Some(part) = derivation.design.parts.get(&id) else { return Ok(()) };
        let original = part.image_of.unwrap_or(id);
        let with = self.task.actuated.get(&part.kind);
        let Some((name, actuation)) = with.and_then(|n| rules.actuations.get_key_value(n)) else {
            return Ok(());
        };
        let index = self.actuations.iter().position(|(n, _)| n == name).unwrap_or_else(|| {
            self.actuations.push((name, actuation));
            self.actuations.len() - 1
        });
        let mut fields = Vec::with_capacity(actuation.variables.len());
        for (i, variable) in actuation.variables.iter().enumerate() {
            let holder = match &variable.owner {
                Owner::Everyone => Holder::Everyone,
                Owner::Body => Holder::Body,
                Owner::Actuator => Holder::Actuator(original),
                Owner::Group(group) => {
                    let scope = DesignScope::new(rules, &derivation);
                    let own = Value::Reference(Reference::Part(original));
                    let number = |value: &Value| match value {
                        Value::Bool(yes) => f64::from(u8::from(*yes)),
                        value => value.as_number().unwrap_or(0.0),
                    };
                    Holder::Group(match evaluate(group, &scope, &mut vec![own])? {
                        Value::List(items) => items.iter().map(number).collect(),
                        value => vec![number(&value)],
                    })
                }
            };
            let known = |f: &Field| match &holder {
                Holder::Everyone => {
                    f.holder == holder && self.variable(f).is_some_and(|other| other.name == variable.name)
                }
                _ => (f.actuation, f.variable, &f.holder) == (index, i, &holder),
            };
            let known = self.fields.iter().position(known);
            fields.push(known.unwrap_or_else(|| {
                self.fields.push(Field { actuation: index, variable: i, holder, start: self.length });
                self.length += variable.size.unwrap_or(1);
                self.fields.len() - 1
            }));
        }
        self.actuators.push(Driven { id, actuation: index, fields });
        Ok(())
    }

    /// What is driven.
    #[must_use]
    pub fn candidate(&self) -> &Candidate<'r> {
        &self.candidate
    }

    /// What it does.
    #[must_use]
    pub fn task(&self) -> &'r Task {
        self.task
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

    fn variable(&self, field: &Field) -> Option<&Variable> {
        if let Holder::Policy(number) = field.holder {
            return self.policies.get(number).map(|policy| &policy.weights);
        }
        self.actuations.get(field.actuation)?.1.variables.get(field.variable)
    }

    /// What each value is, for people: `period`, `points[2] of bender-1`; `name` tells what they call an actuator.
    #[must_use]
    pub fn labels(&self, name: impl Fn(PartId) -> String) -> Vec<String> {
        let mut labels = Vec::with_capacity(self.length);
        for field in &self.fields {
            let Some(variable) = self.variable(field) else { continue };
            let whose = match &field.holder {
                Holder::Everyone | Holder::Body | Holder::Policy(_) => String::new(),
                Holder::Actuator(id) => format!(" of {}", name(*id)),
                Holder::Group(numbers) => {
                    let numbers: Vec<_> = numbers.iter().map(ToString::to_string).collect();
                    format!(" of group {}", numbers.join(", "))
                }
            };
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
                if matches!(field.holder, Holder::Policy(_)) {
                    out.push(random.normal(0.0, 1.0).clamp(low, high));
                    continue;
                }
                out.push(match variable.ty {
                    Ty::Bool => f64::from(u8::from(random.unit() < 0.5)),
                    Ty::Count => low + random.below((high - low) as usize + 1) as f64,
                    _ => low + (high - low) * random.unit(),
                });
            }
        }
        out
    }

    /// The values that a search begins with: those that the grammar gives, and the others drawn as by [`Self::draw`].
    #[must_use]
    pub fn begin(&self, random: &mut Stream) -> Parameters {
        let mut out = self.draw(random);
        for (place, field) in self.fields.iter().enumerate() {
            let Some(variable) = self.variable(field) else { continue };
            let (low, high) = variable.domain;
            let own = out.iter_mut().skip(field.start).take(variable.size.unwrap_or(1));
            for (value, begun) in own.zip(self.beginning(place, variable)) {
                *value = begun.max(low).min(high);
            }
        }
        out
    }

    /// Where the values of a field begin; empty if they are drawn, or if what is said has no value for this body.
    fn beginning(&self, place: usize, variable: &Variable) -> Vec<f64> {
        let Some(from) = &variable.from else { return Vec::new() };
        let Some(driven) = self.actuators.iter().find(|driven| driven.fields.contains(&place)) else {
            return Vec::new();
        };
        let Candidate { rules, derivation, .. } = &self.candidate;
        let original = derivation.design.parts.get(&driven.id).and_then(|part| part.image_of);
        let own = Value::Reference(Reference::Part(original.unwrap_or(driven.id)));
        let scope = DesignScope::new(rules, derivation);
        let number = |value: &Value| match value {
            Value::Bool(yes) => Some(f64::from(u8::from(*yes))),
            value => value.as_number(),
        };
        match evaluate(from, &scope, &mut vec![own]) {
            Ok(Value::List(items)) => items.iter().filter_map(number).collect(),
            Ok(value) => number(&value).into_iter().collect(),
            Err(_) => Vec::new(),
        }
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

    /// The value of a field.
    fn value(&self, field: usize, parameters: &[f64]) -> Option<Value> {
        let field = self.fields.get(field)?;
        let declared = self.variable(field)?;
        let one = |x: &f64| if declared.ty == Ty::Bool { Value::Bool(*x != 0.0) } else { Value::Number(*x) };
        match declared.size {
            None => parameters.get(field.start).map(one),
            Some(n) => {
                Some(Value::List(parameters.get(field.start..field.start + n)?.iter().map(one).collect()))
            }
        }
    }

    /// The value of a shared variable of an actuation. A body without actuators has
    /// none: then it is the least that it may be.
    #[must_use]
    pub fn shared(&self, actuation: &str, variable: &str, parameters: &[f64]) -> Option<Value> {
        let declared = self.candidate.rules.actuations.get(actuation)?;
        let variable = declared.variables.iter().position(|v| v.name == variable && v.is_shared())?;
        let index = self.actuations.iter().position(|(n, _)| *n == actuation);
        let everyones = declared.variables.get(variable).filter(|v| v.owner == Owner::Everyone);
        let field = self.fields.iter().position(|f| match everyones {
            Some(own) => f.holder == Holder::Everyone && self.variable(f).is_some_and(|v| v.name == own.name),
            None => Some(f.actuation) == index && f.variable == variable,
        });
        match field {
            Some(field) => self.value(field, parameters),
            None => {
                let declared = declared.variables.get(variable)?;
                Some(match (declared.size, declared.ty == Ty::Bool) {
                    (Some(n), _) => {
                        Value::List(std::iter::repeat_n(Value::Number(declared.domain.0), n).collect())
                    }
                    (None, true) => Value::Bool(false),
                    (None, false) => Value::Number(declared.domain.0),
                })
            }
        }
    }

    /// The period of the cyclic actuation in s: what the first actuation that has a `period`
    /// says; the whole duration where none has.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn period(&self, parameters: &[f64]) -> Result<f64, EvalError> {
        self.period_of(|_| true, parameters)
    }

    /// The same of the actuations of some kinds of actuators.
    fn period_of(&self, kinds: impl Fn(&str) -> bool, parameters: &[f64]) -> Result<f64, EvalError> {
        for (_, name) in self.task.actuated.iter().filter(|(kind, _)| kinds(kind)) {
            if let Some(period) = self.shared(name, "period", parameters) {
                return Ok(period.as_number().unwrap_or(self.task.model.duration));
            }
            let Some(actuation) = self.candidate.rules.actuations.get(name) else { continue };
            let Some(place) = actuation.lets.iter().position(|(n, _)| n == "period") else { continue };
            let driven = self
                .actuators
                .iter()
                .find(|a| self.actuations.get(a.actuation).is_some_and(|(n, _)| n == name));
            let Some(driven) = driven else { continue };
            let locals = self.lets(driven, parameters)?;
            let slot = actuation.first_let() + place;
            return Ok(locals.get(slot).and_then(Value::as_number).unwrap_or(self.task.model.duration));
        }
        Ok(self.task.model.duration)
    }

    /// What an actuation can read before anything moves.
    fn scope(&self) -> DriveScope<'_> {
        let Candidate { rules, derivation, .. } = &self.candidate;
        let mut scope = DriveScope::new(rules, derivation, self.task.model.control);
        scope.left = self.left();
        scope
    }

    /// How many operations its expressions may still take, where it is only tried.
    pub(crate) fn left(&self) -> Option<&AtomicU64> {
        self.left.as_deref()
    }

    /// The same, tried with so many operations for all that it evaluates.
    pub(crate) fn tried_with(self, left: &Arc<AtomicU64>) -> Self {
        Self { left: Some(Arc::clone(left)), ..self }
    }

    /// Whether the actuation of an actuator reacts to what is measured, or remembers something.
    fn reacts(&self, driven: &Driven) -> bool {
        self.actuations.get(driven.actuation).is_some_and(|(_, actuation)| actuation.is_closed_loop())
    }

    /// Whether an actuation of a kind of actuators reacts.
    #[must_use]
    pub fn reacts_with(&self, kind: &str) -> bool {
        self.actuators.iter().any(|driven| self.kind_of(driven) == Some(kind) && self.reacts(driven))
    }

    /// The actuators whose targets are known ahead and that no valves drive: their places in the assembly, each with its actuation's name
    /// and what drives it.
    pub(crate) fn driven_ahead(&self) -> impl Iterator<Item = (usize, &'r str, Span)> {
        self.actuators.iter().enumerate().filter_map(|(place, driven)| {
            let (name, actuation) = self.actuations.get(driven.actuation)?;
            let is_ahead = !self.reacts(driven) && actuation.drive.ty != Ty::Valves;
            is_ahead.then_some((place, *name, actuation.drive.span))
        })
    }

    /// The locals of an actuator's actuation that do not depend on time; states as they begin.
    fn lets(&self, driven: &Driven, parameters: &[f64]) -> Result<Vec<Value>, EvalError> {
        let scope = self.scope();
        let mut locals = vec![Value::Reference(Reference::Part(driven.id))];
        locals.extend(driven.fields.iter().filter_map(|f| self.value(*f, parameters)));
        if let Some((_, actuation)) = self.actuations.get(driven.actuation) {
            let begun = actuation.states.iter().map(|state| evaluate(&state.from, &scope, &mut locals));
            let begun: Vec<Value> = begun.collect::<Result<_, _>>()?;
            locals.extend(begun);
            locals.extend(policies::undecided(actuation));
            for (_, value) in &actuation.lets {
                let value = evaluate(value, &scope, &mut locals)?;
                locals.push(value);
            }
        }
        Ok(locals)
    }

    /// What drives the body in the nominal world.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn control_law(&self, parameters: &[f64]) -> Result<ControlLaw<'r>, EvalError> {
        self.control_law_under(parameters, &Conditions::nominal())
    }

    /// The same with hardware that differs from what the grammar says.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn control_law_under(
        &self,
        parameters: &[f64],
        conditions: &Conditions,
    ) -> Result<ControlLaw<'r>, EvalError> {
        ControlLaw::new(self, parameters, conditions)
    }

    /// The targets of every actuator over the whole motion, as far as they are known ahead: zero where the actuation reacts.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn targets(&self, parameters: &[f64]) -> Result<Targets, EvalError> {
        self.targets_under(parameters, &Conditions::NOMINAL)
    }

    /// The same with hardware that differs from what the grammar says. An actuator that is late holds its start until
    /// then, with its valves closed.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn targets_under(&self, parameters: &[f64], conditions: &Conditions) -> Result<Targets, EvalError> {
        let mut targets = self.asked(parameters, conditions)?;
        self.on_hardware(parameters, conditions, &mut targets)?;
        Ok(targets)
    }

    /// The angles that the actuators are asked for over the whole motion, before any hardware limits them; zero where
    /// valves are.
    fn asked(&self, parameters: &[f64], conditions: &Conditions) -> Result<Targets, EvalError> {
        let model = &self.task.model;
        let samples = libm::ceil(model.duration / model.control - 1e-9) as usize + 1;
        let count = self.actuators.len();
        let mut angles = vec![0.0; samples * count];
        for (column, driven) in self.actuators.iter().enumerate() {
            let drives = self.actuations.get(driven.actuation).map(|(_, actuation)| &actuation.drive.ty);
            if drives == Some(&Ty::Valves) || self.reacts(driven) {
                continue;
            }
            let late = conditions.late(column);
            let times = (0..samples).map(|sample| (sample as f64 * model.control - late).max(0.0));
            let bends = self.bends(driven, parameters, times)?;
            for (row, bend) in angles.chunks_exact_mut(count).zip(bends) {
                row[column] = bend;
            }
        }
        Ok(Targets { interval: model.control, actuators: count, angles })
    }

    fn kind_of(&self, driven: &Driven) -> Option<&str> {
        self.candidate.design().parts.get(&driven.id).map(|part| part.kind.as_str())
    }

    /// What an actuator can be asked for: rad, m or rad/s. Cells are strained as far as they are asked to be, while something is left
    /// of them.
    fn driven_range(&self, driven: &Driven) -> (f64, f64) {
        self.made(driven).map_or((LEAST_STRAIN, f64::INFINITY), MadeActuator::driven_range)
    }

    /// What an actuator is with its parameters; none for a cell.
    fn made(&self, driven: &Driven) -> Option<&MadeActuator> {
        match self.candidate.design().parts.get(&driven.id)?.made.as_ref() {
            Made::Actuator(actuator) => Some(actuator),
            Made::Block(_) | Made::Cell(_) => None,
        }
    }

    /// The states of an actuator's valves, if it has any.
    fn valves(&self, driven: &Driven, parameters: &[f64]) -> Result<Option<Valves>, EvalError> {
        let Some((_, actuation)) = self.actuations.get(driven.actuation) else { return Ok(None) };
        if actuation.drive.ty != Ty::Valves {
            return Ok(None);
        }
        let scope = self.scope();
        let mut locals = self.lets(driven, parameters)?;
        match evaluate(&actuation.drive, &scope, &mut locals)? {
            Value::Valves(valves) => Ok(Some(Valves::clone(&valves))),
            _ => Ok(None),
        }
    }
}
