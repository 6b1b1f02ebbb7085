//! What bodies are asked to do, and the world in which they do it.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer};
use super::{Expr, ExprKind, Gather, Operator, RuleSet};
use crate::source::Span;
use crate::syntax::Direction;
use crate::units::{self, Dimension};

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
    /// The targets whose limits hold in the simulation, too: one for a kind of actuator at most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub on: Vec<String>,
    /// The scenarios that it happens in beside the nominal world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scenarios: Option<Within>,
    /// What the search of curves wants: an expression over the recorded motion.
    pub objective: Objective,
    /// What it wants beside that, in a search for a front.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<Objective>,
}

/// The scenarios of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Within {
    /// Their name: the key under which [`RuleSet::scenarios`] has them.
    pub name: String,
    /// Where the task names them.
    pub span: Span,
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

/// The longest step of hinges, s.
const LONGEST_STEP: f64 = 1.0 / 60.0;
/// A motion of fewer steps has no value that could be believed.
const FEWEST_STEPS: f64 = 100.0;
/// More steps than this take minutes, and mean a slip.
const MOST_STEPS: f64 = 1e6;

/// Why a motion cannot be made of such steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnfitStep {
    /// Hinges need shorter ones.
    #[error("the step of a model with hinges must be at most 1/60 s: longer steps give wrong motions")]
    OfHinges,
    /// It is longer than the time between two samples of the drive.
    #[error("`step` must not be longer than `control`, the time between two samples of a curve")]
    AboveControl,
    /// The motion has too few of them.
    #[error("a motion of fewer than 100 steps is too coarse to have a value")]
    TooFew,
    /// The motion has too many of them.
    #[error("a motion of more than a million steps is not simulated")]
    TooMany,
}

/// Whether a value can come of a step, with so much time between the samples of the drive and for a motion of this
/// duration, all in s; the duration is infinite where it is not known.
///
/// # Errors
///
/// [`UnfitStep`] if not.
pub fn is_fine_enough(hinges: bool, step: f64, control: f64, duration: f64) -> Result<(), UnfitStep> {
    let is_above = |most: f64| step > most * (1.0 + 1e-9);
    if hinges && is_above(LONGEST_STEP) {
        Err(UnfitStep::OfHinges)
    } else if is_above(control) {
        Err(UnfitStep::AboveControl)
    } else if is_above(duration / FEWEST_STEPS) {
        Err(UnfitStep::TooFew)
    } else if duration.is_finite() && step * MOST_STEPS * (1.0 + 1e-9) < duration {
        Err(UnfitStep::TooMany)
    } else {
        Ok(())
    }
}

fn hinges() -> Method {
    Method::Hinges
}

fn is_hinges(method: &Method) -> bool {
    *method == Method::Hinges
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

impl Task {
    /// Whether its value depends on other worlds than the nominal one: the objective runs over its scenarios.
    #[must_use]
    pub fn runs_over_worlds(&self) -> bool {
        self.objectives().any(Objective::runs_over_worlds)
    }

    /// All that is wanted of its motion; the first is its value.
    pub fn objectives(&self) -> impl Iterator<Item = &Objective> {
        std::iter::once(&self.objective).chain(&self.beside)
    }

    /// Whether its value is the worst of a quantity over its worlds: no better than in the nominal one.
    #[must_use]
    pub fn is_worst_case(&self) -> bool {
        self.beside.is_empty() && self.objective.is_worst_case()
    }
}

impl Objective {
    /// Whether it is the worst of a quantity over worlds: it is no better than that quantity in any of them.
    fn is_worst_case(&self) -> bool {
        let worst = match self.direction {
            Direction::Maximize => Gather::Min,
            Direction::Minimize => Gather::Max,
        };
        self.gathered_over_worlds() == Some(worst)
    }

    /// Whether it is the best of a quantity over worlds.
    #[must_use]
    pub fn is_best_case(&self) -> bool {
        let best = match self.direction {
            Direction::Maximize => Gather::Max,
            Direction::Minimize => Gather::Min,
        };
        self.gathered_over_worlds() == Some(best)
    }

    /// Whether its value in each of several worlds alone tells what it is over all of them: it runs over none, or it is their
    /// mean, a quantile, the least or the greatest. What it takes away for a deviation, say, no world alone can show.
    #[must_use]
    pub fn is_told_by_each_world(&self) -> bool {
        match self.gathered_over_worlds() {
            Some(how) => matches!(how, Gather::Mean | Gather::Quantile | Gather::Min | Gather::Max),
            None => !self.runs_over_worlds(),
        }
    }

    /// What it is of, whatever the unit that it is told in.
    #[must_use]
    pub fn quantity(&self) -> &Expr {
        let mut value = &self.value;
        while let ExprKind::Convert(inner, _) = &value.kind {
            value = inner;
        }
        value
    }

    /// What is added to it whatever the motion is, in its unit: `90` in `90 deg - turning in deg`. What a motion is worth lies
    /// beyond that.
    #[must_use]
    pub fn offset(&self, rules: &RuleSet) -> f64 {
        let (fixed, varies) = addends(&self.value, rules);
        if varies { fixed } else { 0.0 }
    }

    /// How it gathers a quantity over all worlds, if it does nothing else.
    fn gathered_over_worlds(&self) -> Option<Gather> {
        let value = self.quantity();
        let ExprKind::Aggregate { how, binders, condition: None, .. } = &value.kind else { return None };
        let [binder] = binders.as_slice() else { return None };
        matches!(binder.over.kind, ExprKind::Scenarios(_)).then_some(*how)
    }

    /// Whether it depends on other worlds than the nominal one.
    fn runs_over_worlds(&self) -> bool {
        self.value.any(&mut |e| matches!(e.kind, ExprKind::Scenarios(_)))
    }
}

/// The constant part of a sum, and whether there is another.
fn addends(value: &Expr, rules: &RuleSet) -> (f64, bool) {
    let of = |e: &Expr| addends(e, rules);
    match &value.kind {
        ExprKind::Number(x) => (*x, false),
        ExprKind::Param(name) => (rules.params.get(name).map_or(0.0, |param| param.value), false),
        ExprKind::Negate(x) => {
            let (fixed, varies) = of(x);
            (-fixed, varies)
        }
        ExprKind::Convert(x, unit) => {
            let (fixed, varies) = of(x);
            (fixed / unit, varies)
        }
        ExprKind::Binary(a, operator @ (Operator::Add | Operator::Subtract), b) => {
            let ((a, one), (b, other)) = (of(a), of(b));
            (if *operator == Operator::Add { a + b } else { a - b }, one || other)
        }
        ExprKind::Aggregate {
            how: Gather::Min | Gather::Max | Gather::Mean | Gather::Quantile,
            body: Some(body),
            ..
        } => of(body),
        ExprKind::Bind { body, .. } => of(body),
        _ => (0.0, true),
    }
}

/// What an objective is of, as a grammar would write it: `travel`, `count(actuator)`.
#[must_use]
pub fn objective_name(rules: &RuleSet, objective: &Objective) -> String {
    let value = objective.quantity();
    let text = Writer { rules, text: String::new() }.expr(value, &Names::new());
    // An operation is written in brackets.
    match &value.kind {
        ExprKind::Binary(..) => {
            text.strip_prefix('(').and_then(|text| text.strip_suffix(')')).unwrap_or(&text).to_owned()
        }
        _ => text,
    }
}

impl Writer<'_> {
    /// The tasks, and what is wanted of all together.
    pub(super) fn asked(&mut self) {
        let rules = self.rules;
        for (name, task) in &rules.tasks {
            let indent = usize::from(*name != RuleSet::ONLY_TASK);
            self.gap();
            if indent > 0 {
                self.line(0, format!("task {name} {{"));
            }
            for (kind, with) in &task.actuated {
                self.line(indent, format!("actuate {kind} with {with}"));
            }
            task.objectives().for_each(|objective| self.objective(indent, objective));
            self.model(indent, task);
            if indent > 0 {
                self.line(0, "}");
            }
        }
        self.gap();
        if !rules.tasks.contains_key(RuleSet::ONLY_TASK) {
            rules.objectives().for_each(|objective| self.objective(0, objective));
        }
    }

    pub(super) fn objective(&mut self, indent: usize, objective: &Objective) {
        let value = self.expr(&objective.value, &Names::new());
        self.line(indent, format!("{} {value}", objective.direction));
    }

    pub(super) fn model(&mut self, indent: usize, Task { model, on, scenarios, .. }: &Task) {
        let part = |word: &str, name: &str| format!(" {word} {name}");
        let on = if on.is_empty() { String::new() } else { part("on", &on.join(", ")) };
        let within = scenarios.as_ref().map_or(String::new(), |within| part("in", &within.name));
        self.line(
            indent,
            format!(
                "simulate {} for {}{on}{within} {{",
                model.name,
                units::shown(model.duration, Dimension::TIME)
            ),
        );
        if let Method::Balls(filling) = &model.method {
            self.line(indent + 1, "method = balls");
            if let Some(filling) = filling {
                let spacing = units::shown(filling.spacing, Dimension::LENGTH);
                let (stiffness, damping) = (
                    units::shown(filling.stiffness, Dimension::STIFFNESS),
                    units::shown(filling.damping, Dimension::DAMPING),
                );
                self.line(
                    indent + 1,
                    format!(
                        "filling {{ spacing = {spacing}, stiffness = {stiffness}, damping = {damping} }}"
                    ),
                );
            }
        }
        for (field, value, dimension) in [
            ("step", model.step, Dimension::TIME),
            ("control", model.control, Dimension::TIME),
            ("record", model.record, Dimension::TIME),
            ("gravity", model.gravity, Dimension::ACCELERATION),
            ("ground_friction", model.ground_friction, Dimension::NUMBER),
            ("speed_limit", model.speed_limit, Dimension::VELOCITY),
        ] {
            self.line(indent + 1, format!("{field} = {}", units::shown(value, dimension)));
        }
        if let Some(limit) = model.pace_limit {
            self.line(indent + 1, format!("pace_limit = {}", units::shown(limit, Dimension::VELOCITY)));
        }
        self.line(indent + 1, format!("iterations = {}", model.iterations));
        self.line(indent + 1, format!("tolerance = {}", units::shown(model.tolerance, Dimension::NUMBER)));
        self.line(indent + 1, format!("self_collision = {}", model.self_collision));
        self.line(indent, "}");
    }
}
