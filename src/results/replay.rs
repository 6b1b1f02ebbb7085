//! Simulates saved designs again, and scores motions of them.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{Expr, RuleSet, Task};
use indexmap::IndexMap;

use super::robustness::Shift;
use super::saved::{SavedDesign, SavedTask};
use crate::derive::Derivation;
use crate::design::Body;
use crate::design::assembly::Assembly;
use crate::drive::Drive;
use crate::score::{self, Observed, Recording, Score, score};
use crate::search::settings;
use crate::simulate::{self, Invalid, Motion, Settings, Stop};

/// A saved design that has been simulated again.
pub struct Replayed {
    /// The derivation that its steps lead to.
    pub derivation: Arc<Derivation>,
    /// Elements and joints.
    pub body: Body,
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
pub fn replay(
    rules: &RuleSet,
    design: &SavedDesign,
    solver: &str,
    precision: Precision,
) -> Result<Replayed, String> {
    let (derivation, body) = body_of(rules, design)?;
    let mut tasks: Vec<ReplayedTask> = Vec::new();
    for saved in &design.tasks {
        let trial = Trial { solver, precision, shift: None, stop: Stop::NEVER };
        tasks.push(replay_task(rules, saved, (&derivation, &body), trial)?);
    }
    if tasks.len() != rules.tasks.len() {
        return Err("its tasks are not those of this grammar".to_owned());
    }
    let values: Option<Vec<(&str, f64)>> =
        tasks.iter().map(|t| Some((t.name.as_str(), t.score.as_ref()?.value))).collect();
    let value = match values {
        Some(values) => Some(score::outcome(rules, &derivation, &values).map_err(|e| e.reason)?),
        None => None,
    };
    let observed = match (tasks.first().map(|task| &task.motion), design.tasks.first()) {
        (Some(Ok(motion)), Some(saved)) if !rules.observed.is_empty() => {
            let recorded = recorded(rules, saved, (&derivation, &body), motion, |recording| {
                score::observe(rules, recording)
            })?;
            rules.observed.iter().cloned().zip(recorded).collect()
        }
        _ => IndexMap::new(),
    };
    Ok(Replayed { derivation, body, tasks, observed, value })
}

/// Asks something of a motion of a saved design.
fn recorded<T>(
    rules: &RuleSet,
    saved: &SavedTask,
    (derivation, body): (&Arc<Derivation>, &Body),
    motion: &Motion,
    ask: impl FnOnce(Recording<'_>) -> T,
) -> Result<T, String> {
    let (_, drive, parameters) = drive_of(rules, saved, (derivation, body))?;
    Ok(ask(Recording { derivation, body, motion, drive: &drive, parameters: &parameters }))
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
) -> Result<Vec<Result<f64, EvalError>>, String> {
    let of = body_of(rules, design)?;
    let of = (&of.0, &of.1);
    let saved = design.task(None)?;
    let trial = Trial { solver: &design.solver, precision: Precision::Model, shift: None, stop: Stop::NEVER };
    let replayed = replay_task(rules, saved, of, trial)?;
    let motion = replayed.motion.map_err(|why| format!("its motion is not valid: {}", why.describe()))?;
    recorded(rules, saved, of, &motion, |recording| {
        let one = |expr: &&Expr| {
            let values = score::quantities(rules, recording, &[expr])?;
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
    fn apply(self, settings: Settings) -> Settings {
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

/// The body that the steps of a saved design lead to.
pub(crate) fn body_of(rules: &RuleSet, design: &SavedDesign) -> Result<(Arc<Derivation>, Body), String> {
    let derivation = Derivation::replay(rules, &design.derivation)
        .map_err(|(n, reason)| format!("step {n} of its derivation cannot be applied: {reason}"))?;
    let body = Body::new(&derivation.design, rules);
    Ok((Arc::new(derivation), body))
}

/// A task with what drives the design in it.
struct Driven<'a> {
    task: &'a Task,
    drive: Drive<'a>,
    parameters: Vec<f64>,
    targets: simulate::Targets,
    settings: simulate::Settings,
}

/// A task with its drive and the values that were saved for it.
pub(super) fn drive_of<'a>(
    rules: &'a RuleSet,
    saved: &SavedTask,
    (derivation, body): (&Arc<Derivation>, &Body),
) -> Result<(&'a Task, Drive<'a>, Vec<f64>), String> {
    let task = task_of(rules, saved)?;
    let drive = Drive::new(rules, task, Arc::clone(derivation), body).map_err(|e| e.reason)?;
    let parameters = saved.parameters();
    // Whose value it is, is told by its place; earlier versions called actuators otherwise.
    let variable = |label: &str| label.split(" of ").next().unwrap_or_default().to_owned();
    let labels = drive.labels(|_| String::new());
    let same = |((saved, _), label): (&(String, f64), &String)| variable(saved) == variable(label);
    let fit = saved.drive.len() == labels.len() && saved.drive.iter().zip(&labels).all(same);
    if !fit || !drive.fits(&parameters) {
        return Err("its drive does not fit the actuation of this grammar".to_owned());
    }
    Ok((task, drive, parameters))
}

impl<'a> Driven<'a> {
    fn new(
        rules: &'a RuleSet,
        saved: &SavedTask,
        of: (&Arc<Derivation>, &Body),
        precision: Precision,
    ) -> Result<Self, String> {
        let (task, drive, parameters) = drive_of(rules, saved, of)?;
        let targets = drive.targets(&parameters).map_err(|e| e.reason)?;
        let settings = precision.apply(settings(&task.model));
        Ok(Self { task, drive, parameters, targets, settings })
    }

    fn score(
        &self,
        rules: &RuleSet,
        (derivation, body): (&Arc<Derivation>, &Body),
        motion: &Motion,
    ) -> Result<Score, String> {
        score(rules, self.task, self.recording((derivation, body), motion)).map_err(|e| e.reason)
    }

    fn recording<'m>(
        &'m self,
        (derivation, body): (&'m Arc<Derivation>, &'m Body),
        motion: &'m Motion,
    ) -> Recording<'m> {
        Recording { derivation, body, motion, drive: &self.drive, parameters: &self.parameters }
    }
}

impl Driven<'_> {
    /// How fast the robot was, as the target that it is simulated on says.
    fn speed(
        &self,
        rules: &RuleSet,
        (derivation, body): (&Arc<Derivation>, &Body),
        motion: &Motion,
    ) -> Result<Option<(String, f64)>, String> {
        let target = self.task.on.as_ref().and_then(|name| rules.targets.get_key_value(name));
        let Some((name, wanted)) = target.and_then(|(name, target)| Some((name, target.speed.as_ref()?)))
        else {
            return Ok(None);
        };
        let recording = self.recording((derivation, body), motion);
        let speeds = score::quantities(rules, recording, &[wanted]).map_err(|e| e.reason)?;
        Ok(speeds.first().map(|speed| (name.clone(), *speed)))
    }
}

pub(super) fn replay_task(
    rules: &RuleSet,
    saved: &SavedTask,
    of: (&Arc<Derivation>, &Body),
    trial: Trial<'_>,
) -> Result<ReplayedTask, String> {
    let mut driven = Driven::new(rules, saved, of, trial.precision)?;
    let mut assembly = of.1.assembly.clone();
    if let Some(shift) = trial.shift {
        shift.apply(&mut assembly, &mut driven.settings);
    }
    let motion = simulated(&assembly, &driven.settings, &driven.targets, (trial.solver, trial.stop))?;
    let score = match &motion {
        Ok(motion) => Some(driven.score(rules, of, motion)?),
        Err(_) => None,
    };
    let speed = match &motion {
        Ok(motion) => driven.speed(rules, of, motion)?,
        Err(_) => None,
    };
    Ok(ReplayedTask { name: saved.name.clone(), motion, targets: driven.targets, score, speed })
}

fn simulated(
    assembly: &Assembly,
    settings: &simulate::Settings,
    targets: &simulate::Targets,
    (solver, stop): (&str, Stop<'_>),
) -> Result<Result<Motion, Invalid>, String> {
    let model = simulate::model(solver).ok_or_else(|| format!("there is no solver `{solver}`"))?;
    let mut simulation = model.prepare(assembly, settings).map_err(|u| u.reason)?;
    let outcomes = simulation.run_until(stop, std::slice::from_ref(targets));
    let outcomes = outcomes.ok_or_else(|| "stopped before the simulation was complete".to_owned())?;
    Ok(outcomes.into_iter().next().unwrap_or(Err(Invalid::NotFinite)))
}

/// What is simulated when a design does a task.
pub struct Setup {
    /// Elements and joints.
    pub body: Body,
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
    pub fn motion(&self, solver: &str) -> Result<Motion, String> {
        simulated(&self.body.assembly, &self.settings, &self.targets, (solver, Stop::NEVER))?
            .map_err(|why| format!("the motion is not valid: {}", why.describe()))
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
) -> Result<Setup, String> {
    let (derivation, body) = body_of(rules, design)?;
    let Driven { targets, settings, .. } =
        Driven::new(rules, design.task(task)?, (&derivation, &body), precision)?;
    Ok(Setup { body, settings, targets })
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
) -> Result<(Score, Vec<Option<Observed>>), String> {
    let (derivation, body) = body_of(rules, design)?;
    let saved = design.task(task)?;
    let driven = Driven::new(rules, saved, (&derivation, &body), Precision::Model)?;
    let motion = simulate::export::read_motion(motion, &body.assembly, driven.settings.duration)?;
    let score = driven.score(rules, (&derivation, &body), &motion)?;
    let is_first = design.tasks.first().is_some_and(|first| first.name == saved.name);
    let recording = driven.recording((&derivation, &body), &motion);
    Ok((score, if is_first { score::observe(rules, recording) } else { Vec::new() }))
}

fn task_of<'r>(rules: &'r RuleSet, saved: &SavedTask) -> Result<&'r Task, String> {
    rules.tasks.get(&saved.name).ok_or_else(|| format!("this grammar has no task `{}`", saved.name))
}
