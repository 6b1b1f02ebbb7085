//! How actuators are driven: curves with quantities that a search varies.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, range};
use super::{Action, DRIVEN, Expr, ExprKind, Policy, Ty};
use crate::source::Span;

/// A parameterised curve for actuators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuation {
    /// What the search varies.
    pub variables: Vec<Variable>,
    /// What each actuator remembers from one control moment to the next.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<State>,
    /// What policies decide of each actuator.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub actions: Vec<Action>,
    /// Values that neither change in time nor are measured, in order. Locals: the actuator is 0,
    /// then the variables, then the states, then the actions, then these.
    pub lets: Vec<(String, Expr)>,
    /// How many of these, the first ones, are declared outside of the actuations: all that read them have the same.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shared_lets: usize,
    /// Values that change in time, are measured or remembered, in order, with the next local slots.
    pub moving: Vec<(String, Expr)>,
    /// Where the tip is to stand against the base, how fast it is to turn, or the states of valves: its type says which.
    pub drive: Expr,
    /// Where it is declared.
    pub span: Span,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// What an actuator remembers from one control moment to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Ty,
    /// What it is at the first control moment. May read the actuator and the variables.
    pub from: Expr,
    /// What it will be at the next one. May read everything.
    pub next: Expr,
}

/// A quantity that the search varies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Who has one.
    pub owner: Owner,
    /// How many there are, if it is a list.
    pub size: Option<usize>,
    /// Its type (of one item).
    pub ty: Ty,
    /// Least and greatest value in SI units; 0 and 1 for a Bool.
    pub domain: (f64, f64),
    /// Where a search for curves begins: an expression that may read the actuator, which is local 0, where each has its own; drawn
    /// evenly if this is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Expr>,
    /// How it is mutated.
    pub mutation: Mutation,
    /// Where it is declared.
    #[serde(default)]
    pub span: Span,
}

/// Who has a varied quantity of its own. Images always follow their originals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Owner {
    /// All actuators of a task, whatever actuates them: all such variables of one name are one.
    Everyone,
    /// The whole body, where it is actuated so.
    Body,
    /// Each actuator.
    Actuator,
    /// All actuators for which this number is the same.
    Group(Expr),
}

/// How a varied quantity is mutated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mutation {
    /// The chance that one item changes in one move.
    pub probability: Expr,
    /// How it changes.
    pub kernel: Kernel,
    /// What happens at the ends of the domain.
    pub bound: Bound,
}

/// The change of a mutation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kernel {
    /// A Bool becomes the other one.
    Flip,
    /// Adds a normally distributed number: mean, standard deviation.
    Normal(Expr, Expr),
    /// Adds an evenly distributed number: least, greatest.
    Uniform(Expr, Expr),
}

/// What happens to a value beyond the ends of its domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// It stays at the end.
    Clamp,
    /// It is folded back.
    Reflect,
    /// It is drawn anew, evenly.
    Resample,
}

impl Actuation {
    /// Its values, what policies know of its actuators, and what it drives, without where states begin.
    pub fn values(&self) -> impl Iterator<Item = &Expr> {
        let values = self.lets.iter().chain(&self.moving).map(|(_, value)| value);
        let known = self.actions.iter().flat_map(|action| &action.inputs);
        values.chain(self.states.iter().map(|state| &state.next)).chain(known).chain([&self.drive])
    }

    /// The same, with what the policies know of the whole robot that decide its actions.
    pub fn values_with<'v>(
        &'v self,
        policies: &'v IndexMap<String, Policy>,
    ) -> impl Iterator<Item = &'v Expr> {
        let deciding = self.actions.iter().filter_map(|action| policies.get(&action.policy));
        self.values().chain(deciding.flat_map(Policy::known))
    }

    /// Whether it reacts to what is measured, remembers something, or leaves something to a policy: what it asks for is not known ahead.
    #[must_use]
    pub fn is_closed_loop(&self) -> bool {
        !self.states.is_empty()
            || !self.actions.is_empty()
            || self.values().any(|value| value.any(&mut |e| matches!(e.kind, ExprKind::Sensor(..))))
    }

    /// The first slot of its values.
    #[must_use]
    pub fn first_let(&self) -> usize {
        self.first_action() + self.actions.len()
    }

    /// The first slot of its states.
    #[must_use]
    pub fn first_state(&self) -> usize {
        1 + self.variables.len()
    }

    /// The first slot of its actions.
    #[must_use]
    pub fn first_action(&self) -> usize {
        self.first_state() + self.states.len()
    }
}

impl Variable {
    /// Whether all actuators that an actuation drives have one together.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        matches!(self.owner, Owner::Everyone | Owner::Body)
    }
}

impl Writer<'_> {
    pub(super) fn actuation(&mut self, name: &str, actuation: &Actuation) {
        self.gap();
        self.line(0, format!("actuation {name} for a : actuator {{"));
        let mut names: Names = vec!["a".to_owned()];
        for variable in &actuation.variables {
            let (word, per) = match &variable.owner {
                Owner::Everyone => ("shared by all", String::new()),
                Owner::Body => ("shared", String::new()),
                Owner::Actuator => ("vary", String::new()),
                Owner::Group(number) => ("vary", format!(" per {}", self.expr(number, &names))),
            };
            let size = variable.size.map_or(String::new(), |n| format!("[{n}]"));
            let domain = if variable.ty == Ty::Bool {
                String::new()
            } else {
                format!(" in {}", range(variable.domain, &variable.ty))
            };
            let from = variable.from.as_ref();
            let from = from.map_or(String::new(), |value| format!(" from {}", self.expr(value, &names)));
            let chance = self.expr(&variable.mutation.probability, &Names::new());
            let kernel = match &variable.mutation.kernel {
                Kernel::Flip => format!(" flip {chance}"),
                Kernel::Normal(a, b) => {
                    format!(
                        " mutate {chance} by normal({}, {})",
                        self.expr(a, &Names::new()),
                        self.expr(b, &Names::new())
                    )
                }
                Kernel::Uniform(a, b) => {
                    format!(
                        " mutate {chance} by uniform({}, {})",
                        self.expr(a, &Names::new()),
                        self.expr(b, &Names::new())
                    )
                }
            };
            let bound = format!("{:?}", variable.mutation.bound).to_lowercase();
            self.line(
                1,
                format!(
                    "{word} {}{size} : {}{domain}{from}{per}{kernel} bound {bound}",
                    variable.name, variable.ty
                ),
            );
        }
        names.extend(actuation.variables.iter().map(|v| v.name.clone()));
        let states: Names = actuation.states.iter().map(|state| state.name.clone()).collect();
        let starts: Vec<String> = actuation.states.iter().map(|s| self.expr(&s.from, &names)).collect();
        names.extend(states);
        names.extend(actuation.actions.iter().map(|action| action.name.clone()));
        actuation.actions.iter().for_each(|action| self.action(action, &names));
        let mut all = names.clone();
        all.extend(actuation.lets.iter().chain(&actuation.moving).map(|(name, _)| name.clone()));
        for (state, from) in actuation.states.iter().zip(starts) {
            let next = self.expr(&state.next, &all);
            self.line(1, format!("state {} : {} from {from} next {next}", state.name, state.ty));
        }
        for (name, value) in actuation.lets.iter().chain(&actuation.moving) {
            self.line(1, format!("let {name} = {}", self.expr(value, &names)));
            names.push(name.clone());
        }
        let driven =
            DRIVEN.iter().find(|(_, ty)| *ty == actuation.drive.ty).map_or("strain", |(word, _)| word);
        self.line(1, format!("drive {driven} = {}", self.expr(&actuation.drive, &names)));
        self.line(0, "}");
    }
}
