//! States of the robot and of its parts: what all actuations that react can read.

use grammar_lang::eval::{EvalError, Reference, Value, evaluate};
use grammar_lang::ir::{BodyState, Ty, Variable};

use super::scope::DriveScope;
use super::{Drive, Holder};
use crate::design::PartId;

/// A state of the robot, or of one of its parts.
#[derive(Clone, Debug)]
pub(super) struct Remembered<'r> {
    pub(super) name: &'r str,
    /// Whose it is.
    pub(super) of: Option<PartId>,
    /// What it is at the first control moment.
    pub(super) begun: Value,
    declared: &'r BodyState,
    /// Its locals, up to the values that do not change.
    fixed: Vec<Value>,
}

impl<'r> Remembered<'r> {
    pub(super) fn new(
        drive: &Drive<'r>,
        (name, declared): (&'r str, &'r BodyState),
        of: Option<PartId>,
        parameters: &[f64],
    ) -> Result<Self, EvalError> {
        let scope = drive.scope();
        let mut fixed: Vec<Value> =
            of.map(|part| Value::Reference(Reference::Part(part))).into_iter().collect();
        for variable in &declared.variables {
            fixed.push(drive.of_everyone(variable, parameters)?);
        }
        let begun = evaluate(&declared.state.from, &scope, &mut fixed)?;
        for (_, value) in &declared.lets {
            let value = evaluate(value, &scope, &mut fixed)?;
            fixed.push(value);
        }
        Ok(Self { name, of, begun, declared, fixed })
    }

    /// Its type.
    pub(super) fn ty(&self) -> &'r Ty {
        &self.declared.state.ty
    }

    /// What it will be at the next control moment.
    pub(super) fn next(&self, scope: &DriveScope<'_>) -> Result<Value, EvalError> {
        let mut locals = self.fixed.clone();
        for (_, value) in &self.declared.moving {
            let value = evaluate(value, scope, &mut locals)?;
            locals.push(value);
        }
        evaluate(&self.declared.state.next, scope, &mut locals)
    }
}

impl Drive<'_> {
    /// The value of a variable that all actuations share.
    fn of_everyone(&self, variable: &Variable, parameters: &[f64]) -> Result<Value, EvalError> {
        let is_it = |field: &super::Field| {
            field.holder == Holder::Everyone
                && self.variable(field).is_some_and(|other| other.name == variable.name)
        };
        let field = self.fields.iter().position(is_it);
        let none = || EvalError { span: variable.span, reason: "no actuator has this variable".to_owned() };
        field.and_then(|field| self.value(field, parameters)).ok_or_else(none)
    }
}
