//! The typed rule set: what the engine runs. SI numbers, spans kept, serialisable.

mod actuation;
mod constructions;
mod examples;
mod expr;
mod form;
mod hardware;
mod joint;
mod kind;
mod lattice;
mod learners;
mod novelty;
mod parts;
mod policies;
mod rules;
mod scenarios;
mod search;
mod sensors;
mod spans;
mod states;
mod table;
mod tasks;
mod terms;
mod text;
mod ty;
mod words;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

pub use actuation::*;
pub use constructions::*;
pub use examples::*;
pub use expr::*;
pub use form::*;
pub use hardware::*;
pub use joint::*;
pub use kind::*;
pub use lattice::*;
pub use learners::*;
pub use novelty::*;
pub use parts::*;
pub use policies::*;
pub use rules::*;
pub use scenarios::*;
pub use search::*;
pub use sensors::*;
pub use spans::*;
pub use states::*;
pub use table::*;
pub use tasks::*;
pub use terms::*;
pub use ty::*;
pub use words::*;

pub use crate::syntax::Direction;

use self::text::{Names, Writer, range};
use crate::source::Span;

/// The version of this format.
pub const VERSION: u32 = 3;

/// A whole grammar, checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RuleSet {
    /// [`VERSION`] of the format.
    pub version: u32,
    /// The grammar's name.
    pub name: String,
    /// What a user may set from outside, with the values in force.
    pub params: IndexMap<String, Param>,
    /// The values of enumerations, in order: a value is kept as its number.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub enumerations: IndexMap<String, Vec<String>>,
    /// Passive parts.
    pub parts: IndexMap<String, Part>,
    /// Actuators.
    pub actuators: IndexMap<String, Actuator>,
    /// Fixed cyclic curves: expressions of `cycle`.
    pub patterns: IndexMap<String, Expr>,
    /// How rule applications are mirrored.
    pub symmetry: Symmetry,
    /// The initial design; the first part is the core.
    pub begin: Vec<Placed>,
    /// The lattice that the bodies are made of, if they are not made of parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lattice: Option<Lattice>,
    /// The rules.
    pub rules: Vec<Rule>,
    /// Rules that are never drawn, but carried out after `begin` and after each step.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub always: Vec<Rule>,
    /// Rules that alone are drawn while something holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fallbacks: Vec<Fallback>,
    /// What every design must fulfil.
    pub requirements: Vec<Requirement>,
    /// What a design should fulfil.
    pub preferences: Vec<Preference>,
    /// Hand-picked derivations.
    pub examples: IndexMap<String, Example>,
    /// What the robot measures of itself.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub sensors: IndexMap<String, Sensor>,
    /// What it remembers beside what each actuator does.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub states: IndexMap<String, BodyState>,
    /// What decides actions.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub policies: IndexMap<String, Policy>,
    /// Actuations by name.
    pub actuations: IndexMap<String, Actuation>,
    /// What one body is asked to do. A grammar that names no tasks has one,
    /// called [`RuleSet::ONLY_TASK`].
    pub tasks: IndexMap<String, Task>,
    /// The hardware that runs gaits.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub targets: IndexMap<String, Target>,
    /// Robots that were built.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub prototypes: IndexMap<String, Prototype>,
    /// Sets of worlds.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub scenarios: IndexMap<String, Scenarios>,
    /// Terms whose values are written beside that of each body.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub observed: Vec<String>,
    /// Sets of known designs, by which others are novel.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub novelties: IndexMap<String, Novelty>,
    /// Named terms.
    pub terms: IndexMap<String, Term>,
    /// What the search wants: an expression over the tasks' values and the design.
    pub objective: Objective,
    /// What it wants beside that, each by itself: it searches for a front then. The one task of a grammar that names none
    /// has them itself: see [`RuleSet::beside`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<Objective>,
    /// How it searches.
    pub search: Search,
    /// The example that the search starts from, instead of the initial design.
    pub from: Option<String>,
}

/// A parameter with its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Param {
    /// Its type.
    pub ty: Ty,
    /// The values it may take: low and high, in SI units.
    pub domain: Option<(f64, f64)>,
    /// Its value in SI units; a Bool is 0 or 1, a value of an enumeration its place.
    pub value: f64,
    /// Whether rules set it: then each body has a value of its own, and this is the one that it begins with.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub set_by_rules: bool,
    /// Whether its value was given from outside, with `-p`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub given: bool,
    /// Where it is declared.
    pub span: Span,
}

impl RuleSet {
    /// The name of the task of a grammar that names none.
    pub const ONLY_TASK: &str = "";

    /// The rule with a name.
    #[must_use]
    pub fn rule(&self, name: &str) -> Option<&Rule> {
        self.rules.iter().find(|rule| rule.name == name)
    }

    /// The first task: what is observed is observed of its motion.
    #[must_use]
    pub fn first_task(&self) -> Option<&Task> {
        self.tasks.values().next()
    }

    /// Whether a task is the first.
    #[must_use]
    pub fn is_first(&self, task: &Task) -> bool {
        self.first_task().is_some_and(|first| first.name == task.name)
    }

    /// What the search wants beside its first objective, each by itself. Of a grammar that names no tasks these are expressions over
    /// the motion, of others over the tasks' values and the design.
    #[must_use]
    pub fn beside(&self) -> &[Objective] {
        self.tasks.get(Self::ONLY_TASK).map_or(&self.beside, |task| &task.beside)
    }

    /// All that the search wants: what its best is the best of comes first.
    pub fn objectives(&self) -> impl Iterator<Item = &Objective> {
        let first = self.tasks.get(Self::ONLY_TASK).map_or(&self.objective, |task| &task.objective);
        std::iter::once(first).chain(self.beside())
    }

    /// How the bodies are simulated: all tasks of a grammar have one method.
    #[must_use]
    pub fn method(&self) -> Method {
        self.first_task().map_or(Method::Hinges, |task| task.model.method)
    }

    /// What a value of an enumeration is called.
    #[must_use]
    pub fn value_of(&self, enumeration: &str, number: f64) -> Option<&str> {
        let values = self.enumerations.get(enumeration)?;
        values.iter().enumerate().find(|(i, _)| *i as f64 == number).map(|(_, name)| name.as_str())
    }
}

/// Writes a rule set much as a grammar is written, with every number in a unit that people use.
#[must_use]
pub fn resolved(rules: &RuleSet) -> String {
    let mut out = Writer { rules, text: String::new() };
    out.rule_set();
    out.text
}

impl Writer<'_> {
    /// Everything, in the order in which grammars say it.
    fn rule_set(&mut self) {
        let rules = self.rules;
        self.line(0, format!("grammar {}", rules.name));
        self.gap();
        rules.params.iter().for_each(|(name, param)| self.param(name, param));
        rules.parts.iter().for_each(|(name, part)| self.part(name, part));
        rules.actuators.iter().for_each(|(name, actuator)| self.actuator(name, actuator));
        self.cell();
        rules.patterns.iter().for_each(|(name, value)| self.pattern(name, value));
        self.gap();
        self.begun();
        rules.rules.iter().for_each(|rule| self.rule(rule, false));
        rules.always.iter().for_each(|rule| self.rule(rule, true));
        self.gap();
        self.required();
        rules.sensors.iter().for_each(|(name, sensor)| self.sensor(name, sensor));
        rules.states.iter().for_each(|(name, state)| self.body_state(name, state));
        rules.policies.iter().for_each(|(name, policy)| self.policy(name, policy));
        rules.actuations.iter().for_each(|(name, actuation)| self.actuation(name, actuation));
        self.gap();
        rules.terms.iter().for_each(|(name, term)| self.term(name, term));
        rules.targets.iter().for_each(|(name, target)| self.target(name, target));
        rules.prototypes.iter().for_each(|(name, prototype)| self.prototype(name, prototype));
        rules.scenarios.iter().for_each(|(name, scenarios)| self.scenarios(name, scenarios));
        if !rules.observed.is_empty() {
            self.line(0, format!("observe {}", rules.observed.join(", ")));
        }
        rules.novelties.iter().for_each(|(name, novelty)| self.novelty(name, novelty));
        self.asked();
        self.search(&rules.search, rules.from.as_deref());
    }

    fn param(&mut self, name: &str, param: &Param) {
        let domain = param.domain.map_or(String::new(), |d| format!(" in {}", range(d, &param.ty)));
        let value = self.constant(param.value, &param.ty);
        self.line(0, format!("param {name} : {}{domain} = {value}", param.ty));
    }

    fn pattern(&mut self, name: &str, value: &Expr) {
        let value = self.expr(value, &Names::new());
        self.line(0, format!("pattern {name} = {value}"));
    }
}
