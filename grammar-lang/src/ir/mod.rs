//! The typed rule set: what the engine runs. SI numbers, spans kept, serialisable.

mod expr;
mod form;
mod hardware;
mod kind;
mod lattice;
mod novelty;
mod resolved;
mod search;
mod spans;
mod table;
mod terms;
mod ty;
mod words;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

pub use expr::{Binder, Expr, ExprKind, Gather, Group, Operator, Painting};
pub use form::{Form, Solid};
pub use hardware::{Backend, PINS, Pneumatic, Prototype, Supply, Target, Tendon};
pub use kind::Kind;
pub use lattice::{Cell, Cells, Fallback, JOINED, Lattice};
pub use novelty::{Feature, Novelty};
pub use resolved::resolved;
pub use search::{
    Annealing, Archive, BodyLoop, BodyMethod, CmaEs, CurveLoop, CurveMethod, Descriptor, Schedule, Search,
    SearchMethod,
};
pub use spans::without_spans;
pub use table::Table;
pub use terms::{Lacking, builds_on, lacking};
pub use ty::Ty;
pub use words::{
    Attribute, Axis, CellAttribute, DesignFunction, DesignWord, ElementAttribute, Function, JointAttribute,
    MotionWord, PartAttribute, PortAttribute, SearchWord, StepAttribute, Track, Word,
};

pub use crate::syntax::Direction;

use crate::source::Span;

/// The ports of every block that declares none.
pub const BLOCK_PORTS: &[&str] = &["front", "back", "left", "right", "top", "bottom"];

/// The ports of an actuator.
pub const ACTUATOR_PORTS: &[&str] = &["base", "tip"];

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
    /// Rules that alone are drawn while something holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fallbacks: Vec<Fallback>,
    /// What every design must fulfil.
    pub requirements: Vec<Requirement>,
    /// What a design should fulfil.
    pub preferences: Vec<Preference>,
    /// Hand-picked derivations.
    pub examples: IndexMap<String, Example>,
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
    /// How it searches.
    pub search: Search,
    /// The example that the search starts from, instead of the initial design.
    pub from: Option<String>,
}

/// What a body is asked to do, with its own actuation and its own search of curves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Its name: the key under which [`RuleSet::tasks`] has it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Which actuation drives which actuator.
    pub actuated: IndexMap<String, String>,
    /// The simulation model.
    pub model: Model,
    /// The target whose limits hold in the simulation, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// What the search of curves wants: an expression over the recorded motion.
    pub objective: Objective,
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
    /// Where it is declared.
    pub span: Span,
}

/// A passive part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its shape.
    pub shape: Form,
    /// Mass in kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// `#rrggbb`
    pub colour: String,
    /// Its ports, if they are not the six that every block has.
    pub ports: Vec<Port>,
    /// Where it is declared.
    pub span: Span,
}

/// A port that a part declares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Port {
    /// Its name; several may share one.
    pub name: String,
    /// Its number among those that share the name.
    pub index: f64,
    /// Its place in the part's frame, m.
    pub at: [f64; 3],
    /// The unit vector that points outwards.
    pub facing: [f64; 3],
}

/// How fast an actuator bends, rad/s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Speed {
    /// Always alike.
    Constant(f64),
    /// By its bend in rad.
    ByBend(Table),
}

impl Speed {
    /// The speed at a bend in rad.
    #[must_use]
    pub fn at(&self, bend: f64) -> f64 {
        match self {
            Self::Constant(speed) => *speed,
            Self::ByBend(table) => table.at(bend),
        }
    }

    /// The greatest speed.
    #[must_use]
    pub fn most(&self) -> f64 {
        match self {
            Self::Constant(speed) => *speed,
            Self::ByBend(table) => table.range().1,
        }
    }
}

/// An actuator: a row of equal segments joined by driven hinges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// One segment.
    pub segment: Form,
    /// Mass of one segment in kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// Total bend from base to tip in rad, least and greatest.
    pub bend: (f64, f64),
    /// Speed of the total bend while it grows, rad/s.
    pub bending_speed: Speed,
    /// Speed of the total bend while it goes back to zero, rad/s.
    pub relaxing_speed: Speed,
    /// Greatest torque of a hinge, N m.
    pub torque: f64,
    /// Stiffness of a hinge's servo, N m/rad.
    pub stiffness: f64,
    /// Damping of a hinge's servo, N m s/rad.
    pub damping: f64,
    /// `#rrggbb`
    pub colour: String,
    /// Parameters of an instance.
    pub params: IndexMap<String, InstanceParam>,
    /// Where it is declared.
    pub span: Span,
}

/// A parameter of an actuator instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceParam {
    /// Its type.
    pub ty: Ty,
    /// The values it may take: low and high, in SI units.
    pub domain: Option<(f64, f64)>,
    /// Its value if a rule does not say otherwise.
    pub default: Option<Expr>,
}

/// How rule applications are mirrored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Not at all.
    None,
    /// In the plane through the core's centre with this normal: 0, 1, 2 for x, y, z.
    Mirror(usize),
    /// Rotated so many times in all, about this axis through the core's centre.
    Radial(usize, usize),
}

/// A part of the initial design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// What rules call it.
    pub name: String,
    /// What it is: a kind with its parameters.
    pub what: Expr,
    /// What holds it; nothing holds the core.
    pub on: Option<Holding>,
    /// Where this is said.
    pub span: Span,
}

/// How a part is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holding {
    /// The port that holds it.
    pub port: Expr,
    /// By how much it is turned about that port's normal.
    pub turned: Option<Expr>,
    /// The port of its own that it is held by; if none is named, `back`, `base`
    /// or the first one that it has.
    pub by: Option<String>,
}

/// A rule of the grammar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rule {
    /// Its name.
    pub name: String,
    /// What it needs, in order; each takes the next local slots.
    pub matches: Vec<Match>,
    /// What it draws, in order; each takes the next local slot.
    pub choices: Vec<Choice>,
    /// Conditions, each with the number of local slots that it needs to be bound.
    pub guards: Vec<Guard>,
    /// What it does.
    pub effects: Vec<Effect>,
    /// How often it is drawn, relative to the others.
    pub weight: Expr,
    /// What its locals are called, by slot.
    pub locals: Vec<String>,
    /// Where it is declared.
    pub span: Span,
}

/// One thing that a rule matches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// What it is.
    pub what: Matched,
    /// A condition on it and on what was matched before it.
    pub condition: Option<Expr>,
}

/// What is matched. Two matches of a rule never bind the same part, port or step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Matched {
    /// A part of a kind, in the next slot.
    Part {
        /// Which parts.
        kind: Group,
        /// Whether one of its free ports takes the slot after it.
        port: bool,
        /// The slot of the part that it must be joined to.
        joined_to: Option<usize>,
    },
    /// A port, in the next slot.
    Port {
        /// The slot of the part whose port it is; any part's if none.
        of: Option<usize>,
    },
    /// A joint, in the next slot.
    Joint,
    /// A step of the derivation, in the next slot.
    Step,
}

impl Match {
    /// How many local slots it takes.
    #[must_use]
    pub fn slots(&self) -> usize {
        if matches!(self.what, Matched::Part { port: true, .. }) { 2 } else { 1 }
    }
}

/// A choice of a rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Its name.
    pub name: String,
    /// The values to draw from.
    pub domain: Expr,
    /// How they are distributed; evenly if nothing is said.
    pub spread: Spread,
}

/// How a choice is distributed over its domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spread {
    /// Evenly.
    Even,
    /// There is only one value: a `let` of the rule.
    Fixed,
    /// As a normal distribution that is cut at the ends: mean, standard deviation.
    Normal(Expr, Expr),
    /// Evenly within these ends, and within the domain.
    Uniform(Expr, Expr),
    /// By a list of weights, one for each value.
    Weights(Expr),
}

/// A condition of a rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guard {
    /// How many locals must be bound before it can be asked.
    pub needs: usize,
    /// What must hold.
    pub condition: Expr,
}

/// What a rule does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Attaches a part to a port.
    Attach {
        /// What: a kind, or a kind with parameters. It takes the next local slot.
        what: Expr,
        /// Where and how.
        on: Holding,
    },
    /// Takes a part away, with all that hangs on it.
    Remove(Expr),
    /// Puts a part in the place of another.
    Replace {
        /// The part that goes.
        part: Expr,
        /// What comes: it takes the next local slot.
        with: Expr,
        /// The neighbours at its base or back, and at its tip or front.
        between: Option<(Expr, Expr)>,
    },
    /// Sets an attribute of a part.
    Set {
        /// The part.
        part: Expr,
        /// What of it.
        attribute: Settable,
        /// Its new value.
        value: Expr,
    },
    /// Takes back a step.
    Revert(Expr),
    /// Fills, paints or clears places of the lattice.
    Cells(Cells),
}

/// What a rule can set of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Settable {
    /// Its rotation about the port that holds it.
    Turn,
    /// A parameter of the actuator, by its name.
    Param(String),
}

impl Settable {
    /// What a grammar calls it.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Turn => PartAttribute::Turn.text(),
            Self::Param(name) => name,
        }
    }
}

/// What every design must fulfil.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// Its name, or the text of its condition.
    pub name: String,
    /// What must hold.
    pub condition: Expr,
    /// Why.
    pub because: Option<String>,
    /// Where it is said.
    pub span: Span,
}

/// What a design should fulfil: a penalty if it does not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Preference {
    /// Its name, or the text of its condition.
    pub name: String,
    /// What should hold.
    pub condition: Expr,
    /// What the objective loses if it does not.
    pub weight: Expr,
    /// Why.
    pub because: Option<String>,
    /// Where it is said.
    pub span: Span,
}

/// A hand-picked derivation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// What it does and expects, in order. Step number `i` (from 0) fills two
    /// local slots: `2 i` with the step itself, `2 i + 1` with the first part
    /// that it made (or the step again, if it made none).
    pub clauses: Vec<ExampleClause>,
    /// Where it is declared.
    pub span: Span,
}

/// A clause of an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExampleClause {
    /// A rule applied with chosen values.
    Step {
        /// What the example calls it.
        name: String,
        /// What is applied.
        application: Application,
    },
    /// A rule that must not be applicable with these values.
    Refuse {
        /// What must not be applicable.
        application: Application,
        /// The requirement that must stop it.
        by: Option<String>,
    },
    /// What must hold of the design so far.
    Expect(Expr),
}

/// A rule with a value for each of its locals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Application {
    /// The rule.
    pub rule: String,
    /// A value for each thing that it matches and chooses, by local slot;
    /// none for what follows from the others.
    pub values: Vec<Option<Expr>>,
    /// Where it is said.
    pub span: Span,
}

/// A parameterised curve for actuators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuation {
    /// What the search varies.
    pub variables: Vec<Variable>,
    /// Values that do not depend on time, in order. Locals: the actuator is 0,
    /// then the variables, then these.
    pub lets: Vec<(String, Expr)>,
    /// Values that depend on time, in order, with the next local slots.
    pub moving: Vec<(String, Expr)>,
    /// The target of the total bend angle, or the states of valves: its type says which.
    pub drive: Expr,
    /// Where it is declared.
    pub span: Span,
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
    /// How it is mutated.
    pub mutation: Mutation,
}

/// Who has a varied quantity of its own. Images always follow their originals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Owner {
    /// The whole body.
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

/// How bodies are simulated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Rigid pieces joined by driven hinges.
    Hinges,
    /// Balls joined by springs. A body that is made of parts is filled with them.
    Balls(Option<Filling>),
}

/// Balls that the parts of a body are filled with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Filling {
    /// The distance between neighbours, m.
    pub spacing: f64,
    /// Of a spring, N/m.
    pub stiffness: f64,
    /// Of a spring, N s/m.
    pub damping: f64,
}

/// The simulation model and its numbers, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// How it works.
    #[serde(default = "hinges", skip_serializing_if = "is_hinges")]
    pub method: Method,
    /// Simulated time, s.
    pub duration: f64,
    /// Time step, s.
    pub step: f64,
    /// Time between two samples of the drive, s.
    pub control: f64,
    /// Time between two recorded frames, s.
    pub record: f64,
    /// Gravity, m/s^2.
    pub gravity: f64,
    /// Coulomb coefficient of the ground.
    pub ground_friction: f64,
    /// Sweeps of the contact solver in a step, at most.
    pub iterations: usize,
    /// A sweep that changes no impulse by more than this share of all is the last.
    pub tolerance: f64,
    /// Whether parts of a body collide with each other.
    pub self_collision: bool,
    /// Greatest speed of an element in a valid evaluation, m/s.
    pub speed_limit: f64,
    /// How fast any element may be on its way to where it ends, along the ground and in the mean from any
    /// whole second until the end, at least two seconds, m/s; a motion that is faster is invalid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pace_limit: Option<f64>,
}

fn hinges() -> Method {
    Method::Hinges
}

fn is_hinges(method: &Method) -> bool {
    *method == Method::Hinges
}

/// A named term of an objective.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Its type.
    pub ty: Ty,
    /// Its value.
    pub value: Expr,
    /// Where it is declared.
    pub span: Span,
}

/// What the search wants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Objective {
    /// What is better.
    pub direction: Direction,
    /// A number.
    pub value: Expr,
    /// The unit of that number, for people; empty if it has none.
    pub unit: String,
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
