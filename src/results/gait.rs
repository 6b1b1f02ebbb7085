//! The gait of a saved design as what a board plays, compared with what was simulated.

use grammar_lang::eval::{EvalError, Made, MadeActuator, Unmade};
use grammar_lang::ir::{JointKind, Kind, RuleSet, Target, Task};
use thiserror::Error;

use super::DesignError;
use super::names::Names;
use super::replay;
use super::saved::SavedDesign;
use crate::derive::Candidate;
use crate::design::{Design, PartId};
use crate::drive::Bends;
use crate::hardware::backend::{self, POINTS, backend};
use crate::hardware::compared::{Compared, in_words, same};
use crate::hardware::contents::{self, Driven};
use crate::hardware::{Limits, Problem, Schedule};

/// A gait for a board.
#[derive(Clone, Debug)]
pub struct Gait {
    /// What the board plays.
    pub schedule: Schedule,
    /// What the target leaves out of what the actuators are asked for: a sentence for each actuator.
    pub cut: Vec<String>,
    /// What the target says otherwise than the one that the design was simulated on, in words.
    pub contents: Vec<String>,
    /// The bends of all actuators, simulated and played; empty if they are the same motion, but for the way from rest into it.
    pub changed: Vec<Compared>,
    /// Whether they are another one only because a board goes straight between the points of a period.
    pub coarse: bool,
    /// Whether the first period, from rest, is another one: it is where the motion is not.
    pub begins_otherwise: bool,
    /// Actuators that the design moves and the target does not drive, by name.
    pub elsewhere: Vec<String>,
}

/// Why a board cannot play a design.
#[derive(Debug, Error)]
pub enum NoGait {
    /// The design is none of its grammar, or has no such task.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// Its grammar has no target at all.
    #[error("the grammar `{grammar}` has no target: declare one with `target NAME on pneumatic for ...`")]
    NoTarget {
        /// Its name.
        grammar: String,
    },
    /// With the ranges and speeds of the other grammar, an actuator of the design makes no sense.
    #[error("under the other grammar the design has an actuator that is not possible: {0}")]
    Unmade(#[from] Unmade),
    /// How its actuators move under the other grammar depends on its steps, and that grammar cannot make them.
    #[error(
        "how fast or how far a `{kind}` moves depends on what rules set there (`{field}` reads it), and the other grammar cannot make this design: {why}"
    )]
    OtherSteps {
        /// The kind of the actuators.
        kind: String,
        /// The field.
        field: String,
        /// Why.
        why: String,
    },
    /// It has several, and none was named.
    #[error("there are several targets: write --target with one of: {}", there.join(", "))]
    WhichTarget {
        /// Their names.
        there: Vec<String>,
    },
    /// It has not this one.
    #[error("the grammar `{grammar}` has no target `{name}`; it has: {}", or_none(there))]
    UnknownTarget {
        /// Its name.
        grammar: String,
        /// The target's.
        name: String,
        /// Those that it has.
        there: Vec<String>,
    },
    /// The motion does not repeat.
    #[error(
        "the commands for the actuators do not repeat: a board plays one period over and over; give the actuation \
         a `period`, and let it read the time as `t / period` only"
    )]
    NoPeriod,
    /// It reacts.
    #[error(
        "the actuation of `{kind}` reads sensors, has a `state` or leaves actions to a policy, but a board of sgc plays a period that is known in advance: a robot that \
         reacts needs a controller of its own (`sgc export --to drive` writes the commands of the simulated motion)"
    )]
    Reacts {
        /// The kind.
        kind: String,
    },
    /// No actuator is of the kind that the target drives.
    #[error("the design has no `{kind}` for the target `{target}` to drive")]
    NothingToDrive {
        /// The kind.
        kind: String,
        /// The target's name.
        target: String,
    },
    /// No board can run the schedule: a line for each reason.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Schedule(Vec<Problem>),
}

impl From<EvalError> for NoGait {
    fn from(error: EvalError) -> Self {
        Self::Design(error.into())
    }
}

impl From<Vec<Problem>> for NoGait {
    fn from(problems: Vec<Problem>) -> Self {
        Self::Schedule(problems)
    }
}

fn or_none(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// The gait of a design in a task (the first, if none is named) on a target: the one that is named, or the one that the
/// task is simulated on, or the only one. The target, and how fast and far its actuators bend, are those of `of`, if that
/// is given, else of the design's own rules; all else is the design's.
///
/// # Errors
///
/// What does not fit.
pub fn gait(
    rules: &RuleSet,
    of: Option<&RuleSet>,
    design: &SavedDesign,
    task: Option<&str>,
    target: Option<&str>,
) -> Result<Gait, NoGait> {
    let saved = design.task(task)?;
    let candidate = replay::candidate(rules, design)?;
    let (simulated, parameters) = replay::drive_of(&candidate, saved)?;
    let own = simulated.task();
    let name = target_name(of.unwrap_or(rules), target, &own.on)?;
    let played = on_target(rules, of, &saved.name, &name);
    let mut under = candidate.under(&played)?;
    if let Some(of) = of {
        let there = made_under(of, design, candidate.design())?;
        under = under.moving_as(of, there.as_ref().map(Candidate::design))?;
    }
    let (drive, _) = replay::drive_of(&under, saved)?;
    let Some(target) = played.targets.get(&name) else {
        return Err(no_target(rules, &name));
    };
    if drive.reacts_with(&target.kind) {
        return Err(NoGait::Reacts { kind: target.kind.clone() });
    }
    let cycle = drive.cycle(&target.kind, &parameters, POINTS)?;
    let cycle = cycle.ok_or(NoGait::NoPeriod)?;
    if cycle.actuators.is_empty() {
        return Err(NoGait::NothingToDrive { kind: target.kind.clone(), target: name });
    }
    let driven: Vec<PartId> = cycle.actuators.iter().map(|(id, _)| *id).collect();
    let called = design.names(rules, &candidate.derivation);
    let names = called.all(&driven);
    let backend = backend(target);
    let schedule = backend::schedule(&*backend, &cycle, &names)?;
    // Better told before a board is asked.
    let problems = schedule.check(&Limits::default());
    if !problems.is_empty() {
        return Err(problems.into());
    }

    let bends = drive.bends_over_time(&parameters)?;
    let mut cut: Vec<String> = cycle
        .actuators
        .iter()
        .zip(&names)
        .filter_map(|((_, asked), name)| Some(format!("{name}: {}", backend.cut(asked)?)))
        .collect();
    let period = drive.period(&parameters)?;
    for (id, name) in driven.iter().zip(&names) {
        if !cut.iter().any(|text| text.starts_with(&format!("{name}: "))) {
            cut.extend(
                lagging(&bends, *id, period, joint_of(rules, candidate.design(), *id))
                    .map(|text| format!("{name}: {text}")),
            );
        }
    }
    let before = simulated.bends_over_time(&parameters)?;
    let made = driven.iter().zip(&names).filter_map(|(id, name)| {
        Some(Driven { name, before: row(candidate.design(), *id)?, now: row(under.design(), *id)? })
    });
    let contents =
        contents::changes(simulated_on(rules, own, &target.kind), target, &made.collect::<Vec<_>>());
    let is_same = |all: &[Compared]| all.iter().all(Compared::is_same);
    // What other boards drive, this one does not change.
    let compared = |before, now| {
        let joint = |id| driven.contains(&id).then(|| joint_of(rules, candidate.design(), id));
        compared((before, now), &called, period, joint)
    };
    let by_points = drive.bends_by_points(&parameters, &cycle)?;
    let mut changed = compared(&before, &by_points);
    let coarse = !is_same(&changed) && is_same(&compared(&before, &bends));
    let from_rest = changed.iter().map(|one| Compared { from: 0, ..one.clone() }).collect::<Vec<_>>();
    let begins_otherwise = !is_same(&from_rest);
    if is_same(&changed) {
        changed.clear();
    }
    let all = &candidate.body.actuators;
    let others: Vec<PartId> = all.iter().filter(|id| !driven.contains(id)).copied().collect();
    let elsewhere = called.all(&others);
    Ok(Gait { schedule, cut, contents, changed, coarse, begins_otherwise, elsewhere })
}

/// The name of the target that is meant.
fn target_name(rules: &RuleSet, named: Option<&str>, on: &[String]) -> Result<String, NoGait> {
    let on = only(on.iter().map(String::as_str).filter(|on| rules.targets.contains_key(*on)));
    let one = only(rules.targets.keys().map(String::as_str));
    match named.or(on).or(one) {
        Some(name) if rules.targets.contains_key(name) => Ok(name.to_owned()),
        Some(name) => Err(no_target(rules, name)),
        None if rules.targets.is_empty() => Err(NoGait::NoTarget { grammar: rules.name.clone() }),
        None => Err(NoGait::WhichTarget { there: rules.targets.keys().cloned().collect() }),
    }
}

/// What there is one of.
fn only<'n>(mut names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    names.next().filter(|_| names.next().is_none())
}

fn no_target(rules: &RuleSet, name: &str) -> NoGait {
    let there = rules.targets.keys().cloned().collect();
    NoGait::UnknownTarget { grammar: rules.name.clone(), name: name.to_owned(), there }
}

/// The target that drives a kind of actuators where a task is simulated.
fn simulated_on<'r>(rules: &'r RuleSet, task: &'r Task, kind: &str) -> Option<&'r Target> {
    rules.targets_of(task).find_map(|(_, target)| (target.kind == kind).then_some(target))
}

/// What the steps of a design make under other rules, which gives parameters their values. Where these cannot make it, nobody knows how
/// actuators move whose fields read one.
fn made_under<'r>(
    of: &'r RuleSet,
    saved: &SavedDesign,
    design: &Design,
) -> Result<Option<Candidate<'r>>, NoGait> {
    let there = match replay::candidate(of, saved) {
        Ok(there) => return Ok(Some(there)),
        Err(why) => why,
    };
    let read = |kind: &str| {
        let kind = of.actuators.get(kind).map(Kind::Actuator);
        let fields = kind.into_iter().flat_map(Kind::varying);
        { fields }.find(|(name, _)| MOTION.contains(name)).map(|(name, _)| name.to_owned())
    };
    match design.parts.values().find_map(|part| Some((part.kind.clone(), read(&part.kind)?))) {
        Some((kind, field)) => Err(NoGait::OtherSteps { kind, field, why: there.to_string() }),
        None => Ok(None),
    }
}

/// The fields of actuators that are taken from another grammar.
const MOTION: [&str; 5] = ["bend", "range", "speed", "bending_speed", "relaxing_speed"];

/// The rules of a design with the targets of others; the task is on the target.
fn on_target(rules: &RuleSet, of: Option<&RuleSet>, task: &str, target: &str) -> RuleSet {
    let mut played = rules.clone();
    if let Some(of) = of {
        played.targets.clone_from(&of.targets);
    }
    let targets = &played.targets;
    let kind = |name: &str| targets.get(name).map(|target| &target.kind);
    if let Some(task) = played.tasks.get_mut(task) {
        // Actuators of other kinds keep their own targets.
        task.on.retain(|on| kind(on).is_some() && kind(on) != kind(target));
        task.on.push(target.to_owned());
    }
    played
}

/// That an actuator does not follow what it is asked for, once it has come to it, in words.
fn lagging(bends: &Bends, actuator: PartId, period: f64, joint: JointKind) -> Option<String> {
    let column = bends.actuators.iter().position(|id| *id == actuator)?;
    // The first period begins from rest.
    let (time, asked, followed) = bends.asked.furthest(&bends.followed, column, period)?;
    ((asked - followed).abs() > same(joint)).then(|| {
        let [followed, asked] = [followed, asked].map(|value| in_words(joint, value));
        format!("it is too slow for its curve: it reaches {followed} instead of {asked} at {time:.2} s")
    })
}

/// What an actuator of a design is.
fn row(design: &Design, actuator: PartId) -> Option<&MadeActuator> {
    match design.parts.get(&actuator)?.made.as_ref() {
        Made::Actuator(row) => Some(row),
        Made::Block(_) | Made::Cell(_) => None,
    }
}

/// How an actuator of a design moves.
fn joint_of(rules: &RuleSet, design: &Design, actuator: PartId) -> JointKind {
    let kind = design.parts.get(&actuator).and_then(|part| rules.actuators.get(&part.kind));
    kind.map_or(JointKind::Bend, |kind| kind.joint.kind)
}

/// The bends of the actuators that have a joint here, compared after the first period where there is a second.
fn compared(
    (simulated, played): (&Bends, &Bends),
    names: &Names,
    period: f64,
    joint: impl Fn(PartId) -> Option<JointKind>,
) -> Vec<Compared> {
    let samples = simulated.followed.samples();
    let first = libm::ceil(period / simulated.followed.interval) as usize;
    let from = if 2 * first < samples { first } else { 0 };
    let times = || (0..samples).map(|sample| sample as f64 * simulated.followed.interval);
    let columns = simulated.actuators.iter().enumerate();
    let all = columns.filter_map(|(column, id)| {
        Some(Compared {
            name: names.get(*id).unwrap_or_default().to_owned(),
            joint: joint(*id)?,
            interval: simulated.followed.interval,
            simulated: times().map(|time| simulated.followed.at(column, time)).collect(),
            played: times().map(|time| played.followed.at(column, time)).collect(),
            from,
        })
    });
    all.collect()
}
