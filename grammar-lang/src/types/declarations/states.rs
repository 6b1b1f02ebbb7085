//! Checks states: what an actuator, the robot or its parts remember from one control moment to the next.

use super::Declarations;
use super::lets::Lets;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Expr, Ty};
use crate::syntax::ast::{self, State};
use crate::types::expressions::context::{Context, Local};
use crate::types::expressions::stage::Stage;

impl Declarations<'_> {
    /// A state of the robot, or of each part of a kind.
    pub(super) fn body_state(&mut self, declared: &ast::BodyState, damaged: bool) -> Option<ir::BodyState> {
        let ast::BodyState { of, state } = declared;
        let mut cx = Context::new(Stage::Drive, damaged);
        let of = match of {
            None => None,
            Some((binder, kind)) => Some(self.of_parts(
                binder,
                kind,
                &mut cx,
                "cells of a lattice cannot have states",
                "states belong to the robot, to parts and to actuators, as in `state phase(l : leg) : Number from 0 next ...`",
            )?),
        };
        let everyones = self.everyones_of(&state.name);
        let variables = self.variables_of_everyone(&everyones, &mut cx);
        let known = cx.locals.len();
        let mut values = Lets::new(known..known);
        let begun = self.begun(state, &cx, known);
        self.values_of_everyone(&everyones, &mut cx, &mut values);
        let complete = variables.len() + usize::from(of.is_some()) == known;
        let state = self.state_change(state, begun, &mut cx)?;
        let span = declared.state.name.span;
        let Lets { lets, moving, .. } = values;
        complete.then_some(ir::BodyState { of, variables, lets, moving, state, span })
    }

    /// The type of a state, and where it begins: it knows the first locals, and nothing that is measured.
    pub(super) fn begun(&mut self, state: &State, cx: &Context, known: usize) -> (Ty, Expr) {
        let mut ty = self.expressions.type_named(&state.ty);
        if !matches!(ty, Ty::Quantity(_) | Ty::Count | Ty::Bool | Ty::Enum(_) | Ty::Unknown) {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    state.ty.span,
                    "a state must be a quantity, a Count, a Bool or a value of an enumeration",
                )
                .label("not one of these")
                .help("declare one for each number that is to be remembered"),
            );
            ty = Ty::Unknown;
        }
        let mut before = Context { stage: Stage::Derivation, ..cx.clone() };
        before.locals.truncate(known);
        let what = format!("where `{}` begins", state.name.text);
        let known_errors = self.expressions.errors.len();
        let from = self.expressions.expect(&state.from, &mut before, &ty, &what);
        self.tell_of_moments(known_errors, &cx.locals[known..]);
        (ty, from)
    }

    /// Says of names that the first value of a state reads, and that are known only in each moment.
    fn tell_of_moments(&mut self, known: usize, of_moments: &[Local]) {
        self.expressions.errors.help_unknown(known, |name| {
            of_moments.iter().any(|local| local.name == name).then(|| {
                format!("`{name}` is a value of each moment, and a state begins before the first one: write here what it stands for")
            })
        });
    }

    /// A state with what it will be at the next control moment, where all values are known.
    pub(super) fn state_change(
        &mut self,
        state: &State,
        (ty, from): (Ty, Expr),
        cx: &mut Context,
    ) -> Option<ir::State> {
        let what = format!("the next `{}`", state.name.text);
        let next = self.expressions.expect(&state.next, cx, &ty, &what);
        let sound = ![&ty, &from.ty, &next.ty].contains(&&Ty::Unknown);
        sound.then(|| ir::State { name: state.name.text.clone(), ty, from, next })
    }
}
