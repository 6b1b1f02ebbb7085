//! Simulates saved designs again, and scores motions of them.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{Expr, RuleSet, Task};
use indexmap::IndexMap;

use super::DesignError;
use super::saved::{SavedDesign, SavedTask};
use super::shift::Shift;
use crate::derive::{Candidate, Derivation};
use crate::design::Body;
use crate::design::assembly::Assembly;
use crate::drive::Drive;
use crate::score::{self, Observed, Recording, Score, score};
use crate::search::settings;
use crate::simulate::{self, Invalid, Motion, Settings, Stop};

/// A saved design that has been simulated again.
pub struct Replayed<'r> {
    /// What its steps lead to.
    pub candidate: Candidate<'r>,
    /// What it did in each task.
    pub tasks: Vec<ReplayedTask>,
    /// What was observed of its motion in the first task, in SI units; empty if that is not valid.
    pub observed: IndexMap<String, Option<Observed>>,
    /// The value of the whole grammar's objective; none if a motion is not valid.
    pub value: Option<f64>,
}

/// One task of a design that has been simulated again.
pub struct ReplayedTask {
    /// The task's name.
    pub name: String,
    /// The motion, or why there is none to score.
    pub motion: Result<Motion, Invalid>,
    /// The targets of its actuators.
    pub targets: simulate::Targets,
    /// The score of a valid motion.
    pub score: Option<Score>,
    /// The target that the task is simulated on and how fast the robot was, m/s, if the target says what that is.
    pub speed: Option<(String, f64)>,
}

/// Simulates a saved design: with a solver, and at the given part of the model's step, or at a step in s.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn replay<'r>(
    rules: &'r RuleSet,
    design: &SavedDesign,
    solver: &str,
    precision: Precision,
) -> Result<Replayed<'r>, DesignError> {
    let candidate = candidate(rules, design)?;
    let mut tasks: Vec<ReplayedTask> = Vec::new();
    for saved in &design.tasks {
        let trial = Trial { solver, precision, shift: None, stop: Stop::NEVER };
        tasks.push(replay_task(&candidate, saved, trial)?);
    }
    if tasks.len() != rules.tasks.len() {
        return Err(DesignError::OtherTasks);
    }
    let values: Option<Vec<(&str, f64)>> =
        tasks.iter().map(|t| Some((t.name.as_str(), t.score.as_ref()?.value))).collect();
    let value = match values {
        Some(values) => Some(score::outcome(rules, &candidate.derivation, &values)?),
        None => None,
    };
    let observed = match (tasks.first().map(|task| &task.motion), design.tasks.first()) {
        (Some(Ok(motion)), Some(saved)) if !rules.observed.is_empty() => {
            let recorded = recorded(&candidate, saved, motion, score::observe)?;
            rules.observed.iter().cloned().zip(recorded).collect()
        }
        _ => IndexMap::new(),
    };
    Ok(Replayed { candidate, tasks, observed, value })
}

/// Asks something of a motion of a saved design.
fn recorded<T>(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    motion: &Motion,
    ask: impl FnOnce(Recording<'_>) -> T,
) -> Result<T, DesignError> {
    let (drive, parameters) = drive_of(candidate, saved)?;
    Ok(ask(Recording::nominal(&drive, &parameters, motion)))
}

/// Quantities of the score stage for a saved design: those of its motion in the first task, simulated again.
///
/// # Errors
///
/// A sentence that says what does not fit, or that the motion is not valid.
pub fn quantities(
    rules: &RuleSet,
    design: &SavedDesign,
    wanted: &[&Expr],
) -> Result<Vec<Result<f64, EvalError>>, DesignError> {
    let candidate = candidate(rules, design)?;
    let saved = design.task(None)?;
    let trial = Trial { solver: &design.solver, precision: Precision::Model, shift: None, stop: Stop::NEVER };
    let replayed = replay_task(&candidate, saved, trial)?;
    let motion = replayed.motion?;
    recorded(&candidate, saved, &motion, |recording| {
        let one = |expr: &&Expr| {
            let values = score::quantities(recording, &[expr])?;
            Ok(values.first().copied().unwrap_or(0.0))
        };
        wanted.iter().map(one).collect()
    })
}

/// How a design is simulated again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial<'a> {
    pub(super) solver: &'a str,
    pub(super) precision: Precision,
    pub(super) shift: Option<Shift>,
    pub(super) stop: Stop<'a>,
}

/// How closely a motion is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Precision {
    /// As the model says.
    #[default]
    Model,
    /// [`Settings::finer`].
    Finer,
    /// The same at an eighth of the step.
    Finest,
    /// With a time step (s) or a number of sweeps, all of which are made.
    Own {
        /// The step.
        step: Option<f64>,
        /// The sweeps.
        sweeps: Option<usize>,
    },
}

impl Precision {
    pub(super) fn apply(self, settings: Settings) -> Settings {
        match self {
            Self::Model => settings,
            Self::Finer => settings.finer(),
            Self::Finest => Settings { step: settings.step / 8.0, ..settings.finer() },
            Self::Own { step, sweeps } => Settings {
                step: step.unwrap_or(settings.step),
                iterations: sweeps.unwrap_or(settings.iterations),
                tolerance: if sweeps.is_some() { 0.0 } else { settings.tolerance },
                ..settings
            },
        }
    }
}

/// What the steps of a saved design lead to.
pub(crate) fn candidate<'r>(rules: &'r RuleSet, design: &SavedDesign) -> Result<Candidate<'r>, DesignError> {
    let derivation = Derivation::replay(rules, &design.derivation)?;
    Ok(Candidate::new(rules, Arc::new(derivation)))
}

/// What drives a design in a task.
struct Driven<'r> {
    drive: Drive<'r>,
    parameters: Vec<f64>,
    targets: simulate::Targets,
    settings: simulate::Settings,
}

/// The drive of a design in a saved task, and the values that were saved for it.
pub(super) fn drive_of<'r>(
    candidate: &Candidate<'r>,
    saved: &SavedTask,
) -> Result<(Drive<'r>, Vec<f64>), DesignError> {
    let task = task_of(candidate.rules, saved)?;
    let drive = Drive::new(candidate, task)?;
    let parameters = saved.parameters();
    // Whose value it is, is told by its place; earlier versions called actuators otherwise.
    let variable = |label: &str| label.split(" of ").next().unwrap_or_default().to_owned();
    let labels = drive.labels(|_| String::new());
    let same = |((saved, _), label): (&(String, f64), &String)| variable(saved) == variable(label);
    let fit = saved.drive.len() == labels.len() && saved.drive.iter().zip(&labels).all(same);
    if !fit || !drive.fits(&parameters) {
        return Err(DesignError::OtherDrive);
    }
    Ok((drive, parameters))
}

impl<'r> Driven<'r> {
    fn new(candidate: &Candidate<'r>, saved: &SavedTask, precision: Precision) -> Result<Self, DesignError> {
        let (drive, parameters) = drive_of(candidate, saved)?;
        let targets = drive.targets(&parameters)?;
        let settings = precision.apply(settings(&drive.task().model));
        Ok(Self { drive, parameters, targets, settings })
    }

    fn score(&self, motion: &Motion) -> Result<Score, DesignError> {
        Ok(score(self.recording(motion))?)
    }

    fn recording<'m>(&'m self, motion: &'m Motion) -> Recording<'m> {
        Recording::nominal(&self.drive, &self.parameters, motion)
    }

    /// How fast the robot was, as the target that it is simulated on says.
    fn speed(&self, motion: &Motion) -> Result<Option<(String, f64)>, DesignError> {
        let rules = self.drive.candidate().rules;
        let target = self.drive.task().on.as_ref().and_then(|name| rules.targets.get_key_value(name));
        let Some((name, wanted)) = target.and_then(|(name, target)| Some((name, target.speed.as_ref()?)))
        else {
            return Ok(None);
        };
        let speeds = score::quantities(self.recording(motion), &[wanted])?;
        Ok(speeds.first().map(|speed| (name.clone(), *speed)))
    }
}

pub(super) fn replay_task(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    trial: Trial<'_>,
) -> Result<ReplayedTask, DesignError> {
    let mut driven = Driven::new(candidate, saved, trial.precision)?;
    let mut assembly = candidate.body.assembly.clone();
    if let Some(shift) = trial.shift {
        shift.apply(&mut assembly, &mut driven.settings);
    }
    let motion = simulated(&assembly, &driven.settings, &driven.targets, trial.solver, trial.stop)?;
    let score = match &motion {
        Ok(motion) => Some(driven.score(motion)?),
        Err(_) => None,
    };
    let speed = match &motion {
        Ok(motion) => driven.speed(motion)?,
        Err(_) => None,
    };
    Ok(ReplayedTask { name: saved.name.clone(), motion, targets: driven.targets, score, speed })
}

fn simulated(
    assembly: &Assembly,
    settings: &simulate::Settings,
    targets: &simulate::Targets,
    solver: &str,
    stop: Stop<'_>,
) -> Result<Result<Motion, Invalid>, DesignError> {
    let model = simulate::model(solver).ok_or_else(|| DesignError::NoSolver(solver.to_owned()))?;
    let mut simulation = model.prepare(assembly, settings)?;
    let outcomes = simulation.run_until(stop, std::slice::from_ref(targets));
    let outcomes = outcomes.ok_or(DesignError::Stopped("the simulation was complete"))?;
    Ok(outcomes.into_iter().next().unwrap_or(Err(Invalid::NotFinite)))
}

/// What is simulated when a design does a task.
pub struct Setup {
    /// Elements and joints.
    pub body: Arc<Body>,
    /// The numbers of the simulation.
    pub settings: simulate::Settings,
    /// The targets of its actuators.
    pub targets: simulate::Targets,
}

impl Setup {
    /// The motion that a solver makes of it.
    ///
    /// # Errors
    ///
    /// A sentence that says what does not fit, or that the motion is not valid.
    pub fn motion(&self, solver: &str) -> Result<Motion, DesignError> {
        Ok(simulated(&self.body.assembly, &self.settings, &self.targets, solver, Stop::NEVER)??)
    }
}

/// What a saved design does in a task (the first, if none is named) before anything simulates it.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn setup(
    rules: &RuleSet,
    design: &SavedDesign,
    task: Option<&str>,
    precision: Precision,
) -> Result<Setup, DesignError> {
    let candidate = candidate(rules, design)?;
    let Driven { targets, settings, .. } = Driven::new(&candidate, design.task(task)?, precision)?;
    Ok(Setup { body: candidate.body, settings, targets })
}

/// Scores a motion that another program has made of a design (see
/// [`simulate::export::read_motion`]) by a task, the first if none is named; with what is observed of it in
/// the first task.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn score_of(
    rules: &RuleSet,
    design: &SavedDesign,
    task: Option<&str>,
    motion: &str,
) -> Result<(Score, Vec<Option<Observed>>), DesignError> {
    let candidate = candidate(rules, design)?;
    let driven = Driven::new(&candidate, design.task(task)?, Precision::Model)?;
    let motion = simulate::export::read_motion(motion, &candidate.body.assembly, driven.settings.duration)?;
    let score = driven.score(&motion)?;
    let is_first = rules.is_first(driven.drive.task());
    Ok((score, if is_first { score::observe(driven.recording(&motion)) } else { Vec::new() }))
}

fn task_of<'r>(rules: &'r RuleSet, saved: &SavedTask) -> Result<&'r Task, DesignError> {
    rules.tasks.get(&saved.name).ok_or_else(|| DesignError::NotInGrammar(saved.name.clone()))
}
