//! What the robot, or each of its parts, remembers for all actuations that read it.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, group};
use super::{Expr, ExprKind, Group, State, Variable};
use crate::source::Span;

/// A state that belongs to no actuator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// The parts that have one each; none where the robot has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<Group>,
    /// The shared variables that it reads. Locals: the part, where parts have one each, then these variables, then the values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variables: Vec<Variable>,
    /// Values outside of it that it reads, as far as they do not change in time, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lets: Vec<(String, Expr)>,
    /// Those that change in time, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moving: Vec<(String, Expr)>,
    /// What is remembered. `from` knows the part and the variables, `next` everything.
    pub state: State,
    /// Where it is declared.
    pub span: Span,
}

impl BodyState {
    /// What it will be next, and the values that this may read.
    pub fn values(&self) -> impl Iterator<Item = &Expr> {
        self.lets.iter().chain(&self.moving).map(|(_, value)| value).chain([&self.state.next])
    }
}

/// The sensors and states that some values read, themselves or through states, each with the place where it is read first.
pub fn felt_by<'v>(
    values: impl Iterator<Item = &'v Expr>,
    states: &'v IndexMap<String, BodyState>,
) -> IndexMap<String, Span> {
    let mut felt = IndexMap::new();
    values.for_each(|value| add_felt(value, &mut felt));
    let mut next = 0;
    while let Some((name, _)) = felt.get_index(next) {
        if let Some(state) = states.get(name) {
            state.values().for_each(|value| add_felt(value, &mut felt));
        }
        next += 1;
    }
    felt
}

fn add_felt(value: &Expr, felt: &mut IndexMap<String, Span>) {
    value.any(&mut |e| {
        if let ExprKind::Sensor(name, _) = &e.kind {
            felt.entry(name.clone()).or_insert(e.span);
        }
        false
    });
}

impl Writer<'_> {
    pub(super) fn body_state(&mut self, name: &str, declared: &BodyState) {
        let mut names = Names::new();
        let of = declared.of.as_ref().map_or(String::new(), |of| {
            names.push("p".to_owned());
            format!("(p : {})", group(of))
        });
        names.extend(declared.variables.iter().map(|variable| variable.name.clone()));
        let from = self.expr(&declared.state.from, &names);
        let mut values = Vec::new();
        for (name, value) in declared.lets.iter().chain(&declared.moving) {
            values.push(format!("let {name} = {}", self.expr(value, &names)));
            names.push(name.clone());
        }
        let next = self.expr(&declared.state.next, &names);
        self.line(0, format!("state {name}{of} : {} from {from} next {next}", declared.state.ty));
        values.into_iter().for_each(|value| self.line(1, value));
    }
}
