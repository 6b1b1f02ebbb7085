//! Scores a recorded motion with the grammar's terms.

pub mod ceiling;
mod observed;
mod stillness;

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{EvalError, Reference, Scope, Value, bounded, evaluate, evaluate_result};
use grammar_lang::ir::{
    Attribute, Difference, ElementAttribute, Expr, MotionWord, Objective, PartAttribute, RuleSet, Task, Term,
    Track, Word, builds_on,
};

pub use observed::{Observed, observe};
pub use stillness::{at_rest, check_designs, has_value_at_rest};

use crate::derive::{Candidate, Derivation, DesignScope};
use crate::design::Body;
use crate::drive::Drive;
use crate::scenarios::Scenario;
use crate::simulate::{Motion, Sliding};

/// The value of an objective with its terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// The objective's number, as the grammar states it.
    pub value: f64,
    /// Terms in SI units, in the order of the rule set.
    pub terms: Vec<(String, f64)>,
}

/// A recorded motion with everything that it is the motion of.
#[derive(Clone, Copy)]
pub struct Recording<'a> {
    /// The actuation, with the body and the task.
    pub drive: &'a Drive<'a>,
    /// The values of its varied quantities.
    pub parameters: &'a [f64],
    /// What was recorded.
    pub motion: &'a Motion,
    /// The world that it was recorded in, if not the nominal one.
    pub scenario: Option<&'a Scenario>,
    /// The motions of the same drive in the other worlds of the task's scenarios, in their order. Where there are
    /// none, an objective that runs over worlds is that of this motion alone.
    pub elsewhere: &'a [(Scenario, Motion)],
}

impl<'a> Recording<'a> {
    /// A motion in the nominal world, without others.
    #[must_use]
    pub fn nominal(drive: &'a Drive<'a>, parameters: &'a [f64], motion: &'a Motion) -> Self {
        Self { drive, parameters, motion, scenario: None, elsewhere: &[] }
    }
}

/// Scores a motion by its task.
///
/// # Errors
///
/// [`EvalError`] when a term or the objective has no value.
pub fn score(recording: Recording<'_>) -> Result<Score, EvalError> {
    let scope = MotionScope::new(recording)?;
    let terms = scope.named_terms()?;
    Ok(Score { value: value(recording.drive.task(), &scope)?, terms })
}

/// The terms that the objective of its task builds on, in SI units, in the order of the rule set.
///
/// # Errors
///
/// [`EvalError`] when one has no value.
pub fn terms(recording: Recording<'_>) -> Result<Vec<(String, f64)>, EvalError> {
    MotionScope::new(recording)?.named_terms()
}

/// The terms that a task's objective builds on, in the order of the rule set.
fn used<'r>(rules: &'r RuleSet, task: &'r Task) -> Vec<(&'r str, &'r Term)> {
    let names: BTreeSet<&str> = task
        .objectives()
        .flat_map(|o| builds_on(&o.value, &rules.terms))
        .filter_map(|(name, _)| name)
        .collect();
    rules.terms.iter().filter(|(n, _)| names.contains(n.as_str())).map(|(n, t)| (n.as_str(), t)).collect()
}

/// The objective of a task alone, over all worlds of which there is a motion.
///
/// # Errors
///
/// [`EvalError`] when the objective has no value.
pub fn objective(recording: Recording<'_>) -> Result<f64, EvalError> {
    value(recording.drive.task(), &MotionScope::new(recording)?)
}

/// Each objective of a task, over all worlds of which there is a motion.
///
/// # Errors
///
/// [`EvalError`] when one has no value.
pub fn objectives(recording: Recording<'_>) -> Result<Vec<f64>, EvalError> {
    let scope = MotionScope::new(recording)?;
    recording.drive.task().objectives().map(|objective| number_of(objective, &scope)).collect()
}

/// Any quantities of the score stage, in SI units; a Bool is 0 or 1.
///
/// # Errors
///
/// [`EvalError`] when one has no value.
pub fn quantities(recording: Recording<'_>, wanted: &[&Expr]) -> Result<Vec<f64>, EvalError> {
    let scope = MotionScope::new(recording)?;
    wanted.iter().map(|expr| Ok(number(&evaluate_result(expr, &scope)?))).collect()
}

/// A value as a number: a Bool is 0 or 1, a value of an enumeration its place.
fn number(value: &Value) -> f64 {
    match value {
        Value::Bool(yes) => f64::from(u8::from(*yes)),
        value => value.as_number().unwrap_or(0.0),
    }
}

fn value(task: &Task, scope: &MotionScope<'_>) -> Result<f64, EvalError> {
    number_of(&task.objective, scope)
}

fn number_of(objective: &Objective, scope: &dyn Scope) -> Result<f64, EvalError> {
    Ok(evaluate_result(&objective.value, scope)?.as_number().unwrap_or(0.0))
}

/// What terms can read: the design and the whole recorded motion; and objectives, the motions in other worlds.
struct MotionScope<'a> {
    design: DesignScope<'a>,
    recording: Recording<'a>,
    period: f64,
    /// Terms that have been evaluated: several may build on one that runs over all elements and moments.
    terms: RefCell<BTreeMap<String, Value>>,
    /// How each element went over the ground, once that is asked.
    sliding: OnceCell<Vec<Sliding>>,
    /// By how much each element turned about the vertical, likewise.
    turned: OnceCell<Vec<f64>>,
    /// The same motion in other worlds.
    elsewhere: Vec<MotionScope<'a>>,
}

impl<'a> MotionScope<'a> {
    fn new(recording: Recording<'a>) -> Result<Self, EvalError> {
        let Candidate { rules, derivation, .. } = recording.drive.candidate();
        let period = recording.drive.period(recording.parameters)?;
        let within = |recording, elsewhere| Self {
            design: DesignScope::new(rules, derivation),
            recording,
            period,
            terms: RefCell::default(),
            sliding: OnceCell::new(),
            turned: OnceCell::new(),
            elsewhere,
        };
        let other = |(scenario, motion): &'a (Scenario, Motion)| {
            let scenario = Some(scenario);
            within(Recording { motion, scenario, elsewhere: &[], ..recording }, Vec::new())
        };
        Ok(within(recording, recording.elsewhere.iter().map(other).collect()))
    }

    /// What a world differs in; 0 is that of this motion.
    fn difference(&self, world: u32, difference: Difference) -> Option<f64> {
        let scenario = match world.checked_sub(1) {
            Some(other) => self.elsewhere.get(other as usize)?.recording.scenario,
            None => self.recording.scenario,
        };
        let given = scenario.and_then(|scenario| scenario.differences.get(&difference).copied());
        Some(given.unwrap_or_else(|| match difference {
            Difference::GroundFriction => self.recording.drive.task().model.ground_friction,
            Difference::Friction
            | Difference::Mass
            | Difference::Torque
            | Difference::Speed
            | Difference::Pressure => 1.0,
            Difference::Tilt | Difference::Slope | Difference::Late => 0.0,
        }))
    }

    fn named_terms(&self) -> Result<Vec<(String, f64)>, EvalError> {
        let (rules, task) = (self.recording.drive.candidate().rules, self.recording.drive.task());
        let one = |(name, term): (&str, &Term)| {
            let value = bounded(observed::value(name, term, self)?, &term.value)?;
            Ok((name.to_owned(), number(&value)))
        };
        used(rules, task).into_iter().map(one).collect()
    }

    fn body(&self) -> &'a Body {
        &self.recording.drive.candidate().body
    }

    /// The element that stands for a thing: itself, or the first one of a part.
    fn element(&self, of: Reference) -> Option<usize> {
        match of {
            Reference::Element(element) => Some(element as usize),
            Reference::Part(part) => self.body().elements_of(part).next(),
            _ => None,
        }
    }

    /// What the whole motion says of an element.
    fn element_attribute(&self, element: usize, attribute: ElementAttribute) -> Option<Value> {
        let motion = self.recording.motion;
        let sliding = || self.sliding.get_or_init(|| motion.sliding()).get(element);
        Some(match attribute {
            ElementAttribute::Size => Value::Number(motion.size(element)?),
            ElementAttribute::Path => Value::Number(sliding()?.path),
            ElementAttribute::Slid => Value::Number(sliding()?.slid),
            ElementAttribute::Yaw => {
                Value::Number(*self.turned.get_or_init(|| motion.turned()).get(element)?)
            }
            ElementAttribute::Touching => Value::Number(sliding()?.touching),
            ElementAttribute::Sliding => Value::Number(sliding()?.sliding),
            ElementAttribute::Part | ElementAttribute::Cell => {
                Value::Reference(Reference::Part(*self.body().parts_of_elements.get(element)?))
            }
        })
    }
}

impl Scope for MotionScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn left(&self) -> Option<&AtomicU64> {
        self.recording.drive.left()
    }

    fn word(&self, word: Word) -> Option<Value> {
        let motion = self.recording.motion;
        let Word::Motion(word) = word else { return self.design.word(word) };
        Some(match word {
            MotionWord::Start => Value::Number(0.0),
            MotionWord::End | MotionWord::Duration => Value::Number(motion.duration),
            MotionWord::FrameInterval => Value::Number(motion.interval),
            MotionWord::Period => Value::Number(self.period),
            MotionWord::Elements => {
                let count = motion.placements.len() as u32;
                Value::List((0..count).map(|i| Value::Reference(Reference::Element(i))).collect())
            }
        })
    }

    fn worlds(&self) -> Option<u32> {
        Some(1 + self.elsewhere.len() as u32)
    }

    fn world(&self, place: u32) -> Option<&dyn Scope> {
        let scope = match place.checked_sub(1) {
            Some(other) => self.elsewhere.get(other as usize)?,
            None => self,
        };
        Some(scope)
    }

    fn remembered(&self, term: &str) -> Option<Value> {
        self.terms.borrow().get(term).cloned()
    }

    fn remember(&self, term: &str, value: &Value) {
        self.terms.borrow_mut().insert(term.to_owned(), value.clone());
    }

    fn shared(&self, actuation: &str, variable: &str) -> Option<Value> {
        self.recording.drive.shared(actuation, variable, self.recording.parameters)
    }

    fn attribute(&self, of: Reference, attribute: &Attribute) -> Option<Value> {
        match (attribute, of) {
            (Attribute::Element(attribute), Reference::Element(element)) => {
                self.element_attribute(element as usize, *attribute)
            }
            // In a world, it is the only one.
            (Attribute::World(difference), Reference::World(world)) => {
                let world = if self.elsewhere.is_empty() { 0 } else { world };
                self.difference(world, *difference).map(Value::Number)
            }
            (Attribute::Part(PartAttribute::Work), Reference::Part(part)) => {
                let actuator = self.body().actuators.iter().position(|a| *a == part)?;
                self.recording.motion.work.get(actuator).copied().map(Value::Number)
            }
            _ => self.design.attribute(of, attribute),
        }
    }

    fn track(&self, of: Reference, track: Track, time: f64) -> Option<Value> {
        let element = self.element(of)?;
        let motion = self.recording.motion;
        Some(match track {
            Track::Lowest => Value::Number(motion.lowest(element, time)?),
            Track::Position => {
                let p = motion.pose(element, time)?.translation.vector;
                Value::Vector([p.x, p.y, p.z])
            }
            Track::Rotation => {
                let r = (motion.pose(element, time)?.rotation
                    * self.recording.drive.candidate().lies(element)?.inverse())
                .into_inner();
                Value::Rotation([r.w, r.i, r.j, r.k])
            }
            // Only sensors read these.
            Track::Velocity
            | Track::AngularVelocity
            | Track::Load
            | Track::Angle
            | Track::AngleRate
            | Track::Distance
            | Track::DistanceRate
            | Track::Speed => return None,
        })
    }
}

/// What the objective of a whole grammar reads: the values of its tasks, and the design.
struct OutcomeScope<'a> {
    design: DesignScope<'a>,
    values: &'a [(&'a str, f64)],
}

impl Scope for OutcomeScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn task(&self, name: &str) -> Option<Value> {
        self.values.iter().find(|(n, _)| *n == name).map(|(_, value)| Value::Number(*value))
    }
}

/// What a design gives up by the preferences that it does not fulfil.
///
/// # Errors
///
/// [`EvalError`] when a preference has no value.
pub fn penalties(rules: &RuleSet, derivation: &Derivation) -> Result<Vec<(String, f64)>, EvalError> {
    let scope = DesignScope::new(rules, derivation);
    let mut found = Vec::new();
    for preference in &rules.preferences {
        if evaluate(&preference.condition, &scope, &mut Vec::new())? != Value::Bool(true) {
            let weight = evaluate_result(&preference.weight, &scope)?.as_number().unwrap_or(0.0);
            found.push((preference.name.clone(), weight));
        }
    }
    Ok(found)
}

/// What a design comes to in the objectives beside the first, in their order: from the values of its tasks by name, and, where the grammar names no
/// tasks, from `each`, what all objectives are of its motion.
///
/// # Errors
///
/// [`EvalError`] when an objective has no value.
pub fn beside(
    rules: &RuleSet,
    derivation: &Derivation,
    values: &[(&str, f64)],
    each: &[f64],
) -> Result<Vec<f64>, EvalError> {
    if rules.tasks.contains_key(RuleSet::ONLY_TASK) {
        return Ok(each.iter().skip(1).copied().collect());
    }
    let scope = OutcomeScope { design: DesignScope::new(rules, derivation), values };
    rules.beside().iter().map(|objective| number_of(objective, &scope)).collect()
}

/// The value of the whole grammar's objective, from the values of its tasks by name.
///
/// # Errors
///
/// [`EvalError`] when the objective or a preference has no value.
pub fn outcome(rules: &RuleSet, derivation: &Derivation, values: &[(&str, f64)]) -> Result<f64, EvalError> {
    let scope = OutcomeScope { design: DesignScope::new(rules, derivation), values };
    let value = number_of(&rules.objective, &scope)?;
    let lost: f64 = penalties(rules, derivation)?.iter().map(|(_, weight)| weight).sum();
    Ok(rules.objective.direction.worse_by(value, lost))
}
