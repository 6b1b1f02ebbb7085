//! Simulates saved designs again, and scores motions of them.

use std::sync::Arc;

use grammar_lang::eval::{EvalError, UNKNOWN_HERE};
use grammar_lang::ir::{self, Expr, RuleSet, Task, UnfitStep, is_fine_enough};
use indexmap::IndexMap;
use rayon::prelude::*;

use super::DesignError;
use super::saved::{SavedDesign, SavedTask};
use crate::derive::{Candidate, Derivation};
use crate::design::Body;
use crate::drive::{ControlLaw, Drive, Trace, Traced};
use crate::scenarios::{self, Scenario};
use crate::score::{self, Observed, Recording, Score, score};
use crate::search::settings;
use crate::simulate::{self, Case, Invalid, Motion, Settings, Stop, World};

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
    /// What it comes to in the objectives beside the first; empty if a motion is not valid.
    pub beside: Vec<f64>,
}

impl Replayed<'_> {
    /// Why it has no value, if it has none.
    #[must_use]
    pub fn why_invalid(&self) -> String {
        let motion = |task: &ReplayedTask| task.motion.as_ref().err().map(|why| why.describe().to_owned());
        let world = |task: &ReplayedTask| {
            task.lost.as_ref().map(|(world, why)| format!("{} (in the world `{world}`)", why.describe()))
        };
        let why = self.tasks.iter().find_map(|task| motion(task).or_else(|| world(task)));
        why.unwrap_or_else(|| "a task has no value".to_owned())
    }
}

/// One task of a design that has been simulated again.
pub struct ReplayedTask {
    /// The task's name.
    pub name: String,
    /// The motion, or why there is none to score.
    pub motion: Result<Motion, Invalid>,
    /// The targets of its actuators.
    pub targets: simulate::Targets,
    /// The score of a valid motion; none either where the objective runs over worlds and a motion in one of them is not
    /// valid.
    pub score: Option<Score>,
    /// What each objective of the task is, where it has several and a score.
    pub each: Vec<f64>,
    /// What the objective is of the motion in the nominal world alone, where it runs over others, too.
    pub nominal: Option<f64>,
    /// The world in which the motion is not valid, and why, if there is one.
    pub lost: Option<(String, Invalid)>,
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
    replay_as(rules, design, How { solver, precision, stop: Stop::NEVER })
}

/// The same, which can be stopped.
pub(super) fn replay_as<'r>(
    rules: &'r RuleSet,
    design: &SavedDesign,
    how: How<'_>,
) -> Result<Replayed<'r>, DesignError> {
    let candidate = candidate(rules, design)?;
    let mut tasks: Vec<ReplayedTask> = Vec::new();
    for saved in &design.tasks {
        tasks.push(replay_task(&candidate, saved, how)?);
    }
    if tasks.len() != rules.tasks.len() {
        return Err(DesignError::OtherTasks);
    }
    let values: Option<Vec<(&str, f64)>> =
        tasks.iter().map(|t| Some((t.name.as_str(), t.score.as_ref()?.value))).collect();
    let (mut value, mut beside) = (None, Vec::new());
    if let Some(values) = values {
        value = Some(score::outcome(rules, &candidate.derivation, &values)?);
        let each = tasks.first().map_or(&[][..], |task| &task.each);
        beside = score::beside(rules, &candidate.derivation, &values, each)?;
    }
    let observed = match (tasks.first().map(|task| &task.motion), design.tasks.first()) {
        (Some(Ok(motion)), Some(saved)) if !rules.observed.is_empty() => {
            let recorded = recorded(&candidate, saved, motion, score::observe)?;
            rules.observed.iter().cloned().zip(recorded).collect()
        }
        _ => IndexMap::new(),
    };
    Ok(Replayed { candidate, tasks, observed, value, beside })
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
    let driven = Driven::new(&candidate, saved, Precision::Model)?;
    let motion = driven.motion(&design.solver, Stop::NEVER)??;
    recorded(&candidate, saved, &motion, |recording| {
        let one = |expr: &&Expr| {
            let values = score::quantities(recording, &[expr])?;
            Ok(values.first().copied().unwrap_or(0.0))
        };
        wanted.iter().map(one).collect()
    })
}

/// How a design is simulated.
#[derive(Clone, Copy, Debug)]
pub struct How<'a> {
    /// The solver.
    pub solver: &'a str,
    /// How closely.
    pub precision: Precision,
    /// Whether to stop.
    pub stop: Stop<'a>,
}

/// A motion that is recorded more often than its model asks for has at most so many poses: 170 MB of them.
const MOST_POSES: f64 = 3e6;

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
    /// The numbers of a model, simulated like this.
    pub(super) fn apply(self, model: &ir::Model) -> Result<Settings, UnfitStep> {
        let settings = settings(model);
        Ok(match self {
            Self::Model => settings,
            Self::Finer => settings.finer(),
            Self::Finest => Settings { step: settings.step / 8.0, ..settings.finer() },
            Self::Own { step, sweeps } => {
                let step = step.unwrap_or(settings.step);
                is_fine_enough(model.method == ir::Method::Hinges, step, model.control, model.duration)?;
                Settings {
                    step,
                    iterations: sweeps.unwrap_or(settings.iterations),
                    tolerance: if sweeps.is_some() { 0.0 } else { settings.tolerance },
                    ..settings
                }
            }
        })
    }
}

/// What the steps of a saved design lead to.
pub(crate) fn candidate<'r>(rules: &'r RuleSet, design: &SavedDesign) -> Result<Candidate<'r>, DesignError> {
    let derivation = Derivation::replay(rules, &design.derivation)?;
    Ok(Candidate::new(rules, Arc::new(derivation)))
}

/// The closest look records so many times as often as the model says: what shakes between two frames and between two of those at half the
/// step, which are twice as many, does not shake in time with these.
const OFTENER: f64 = 7.0;
/// Unless a motion would then have more poses than this: there may be one for each of many worlds.
const POSES_EACH: f64 = 300_000.0;

/// What drives a design in a task.
pub(super) struct Driven<'r> {
    drive: Drive<'r>,
    parameters: Vec<f64>,
    settings: Settings,
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

/// The curves of a saved design for each task of a candidate, which may be of another grammar; empty if one does not fit.
#[must_use]
pub fn curves_of(candidate: &Candidate<'_>, design: &SavedDesign) -> Vec<Vec<f64>> {
    let of = |task: &Task| {
        let saved = design.tasks.iter().find(|saved| saved.name == task.name)?;
        Some(drive_of(candidate, saved).ok()?.1)
    };
    candidate.rules.tasks.values().map(of).collect::<Option<Vec<_>>>().unwrap_or_default()
}

impl<'r> Driven<'r> {
    pub(super) fn new(
        candidate: &Candidate<'r>,
        saved: &SavedTask,
        precision: Precision,
    ) -> Result<Self, DesignError> {
        let (drive, parameters) = drive_of(candidate, saved)?;
        let model = &drive.task().model;
        let mut settings = precision.apply(model)?;
        let elements = candidate.body.assembly.elements.len() as f64;
        let often = model.record / OFTENER;
        if matches!(precision, Precision::Finest) && settings.duration / often * elements <= POSES_EACH {
            settings.record = often;
        }
        Ok(Self { drive, parameters, settings })
    }

    /// The same with so many frames a second, if the model asks for fewer; nothing where a motion would have too many poses.
    pub(super) fn recorded_often(mut self, frames: f64) -> Option<Self> {
        let elements = self.drive.candidate().body.assembly.elements.len() as f64;
        self.settings.record = self.settings.record.min(1.0 / frames);
        (self.settings.duration / self.settings.record * elements <= MOST_POSES).then_some(self)
    }

    /// Whether the objective has a value where nothing moves.
    pub(super) fn has_value_at_rest(&self) -> bool {
        score::has_value_at_rest(&self.drive, &self.parameters)
    }

    /// What drives the body in the nominal world.
    fn control_law(&self) -> Result<ControlLaw<'r>, DesignError> {
        Ok(self.drive.control_law(&self.parameters)?)
    }

    /// The worlds that the value of the task depends on, the nominal one first.
    fn worlds(&self) -> Vec<Scenario> {
        let task = self.drive.task();
        let within = task.scenarios.as_ref().filter(|_| task.runs_over_worlds());
        let set = within.and_then(|within| {
            Some((&within.name, self.drive.candidate().rules.scenarios.get(&within.name)?))
        });
        set.map_or_else(|| vec![Scenario::nominal()], |(name, set)| scenarios::worlds(name, set))
    }

    /// The motions in several worlds, side by side.
    pub(super) fn motions(
        &self,
        scenarios: &[Scenario],
        solver: &str,
        stop: Stop<'_>,
    ) -> Result<Vec<Result<Motion, Invalid>>, DesignError> {
        let body = &self.drive.candidate().body;
        let count = body.actuators.len();
        let driven: Result<Vec<(ControlLaw<'_>, World)>, EvalError> = scenarios
            .iter()
            .map(|one| {
                let law = self.drive.control_law_under(&self.parameters, &one.conditions(count))?;
                Ok((law, one.world()))
            })
            .collect();
        let driven = driven?;
        let cases: Vec<Case<'_>> = driven.iter().map(|(law, world)| law.case(world)).collect();
        self.run(solver, stop, &cases)
    }

    /// The motions of some cases, side by side.
    fn run(
        &self,
        solver: &str,
        stop: Stop<'_>,
        cases: &[Case<'_>],
    ) -> Result<Vec<Result<Motion, Invalid>>, DesignError> {
        let body = &self.drive.candidate().body;
        let model = simulate::model(solver).ok_or_else(|| DesignError::NoSolver(solver.to_owned()))?;
        let mut first = model.prepare(&body.assembly, &self.settings)?;
        let lanes = first.lanes();
        let cut = || DesignError::Stopped("the simulation was complete");
        if cases.len() <= lanes {
            return first.run_cases(stop, cases).ok_or_else(cut);
        }
        let rows = cases.par_chunks(lanes).map(|row| {
            let mut simulation = model.prepare(&body.assembly, &self.settings)?;
            simulation.run_cases(stop, row).ok_or_else(cut)
        });
        Ok(rows.collect::<Result<Vec<_>, DesignError>>()?.into_iter().flatten().collect())
    }

    /// The motion in the nominal world.
    pub(super) fn motion(
        &self,
        solver: &str,
        stop: Stop<'_>,
    ) -> Result<Result<Motion, Invalid>, DesignError> {
        self.motion_in(&Scenario::nominal(), solver, stop)
    }

    /// The motion in the nominal world with all actuators held where they begin, and those in the other worlds that the value of the task
    /// depends on.
    pub(super) fn held(
        &self,
        solver: &str,
        stop: Stop<'_>,
    ) -> Result<(Motion, Vec<(Scenario, Motion)>), DesignError> {
        let law = ControlLaw::holding(&self.drive);
        let scenarios = self.worlds();
        let worlds: Vec<World> = scenarios.iter().map(Scenario::world).collect();
        let cases: Vec<Case<'_>> = worlds.iter().map(|world| law.case(world)).collect();
        let motions = self.run(solver, stop, &cases)?.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut motions = scenarios.into_iter().zip(motions);
        let (_, nominal) = motions.next().ok_or(Invalid::NotFinite)?;
        Ok((nominal, motions.collect()))
    }

    /// The motion in one world.
    pub(super) fn motion_in(
        &self,
        world: &Scenario,
        solver: &str,
        stop: Stop<'_>,
    ) -> Result<Result<Motion, Invalid>, DesignError> {
        let motions = self.motions(std::slice::from_ref(world), solver, stop)?;
        Ok(motions.into_iter().next().unwrap_or(Err(Invalid::NotFinite)))
    }

    /// A motion in a world, the nominal one if none is named, without others.
    pub(super) fn recording<'m>(
        &'m self,
        motion: &'m Motion,
        scenario: Option<&'m Scenario>,
    ) -> Recording<'m> {
        Recording { scenario, ..Recording::nominal(&self.drive, &self.parameters, motion) }
    }

    /// How fast the robot was, as the first target that it is simulated on and that says so has it.
    fn speed(&self, motion: &Motion) -> Result<Option<(String, f64)>, DesignError> {
        let rules = self.drive.candidate().rules;
        let mut targets = rules.targets_of(self.drive.task());
        let Some((name, wanted)) = targets.find_map(|(name, target)| Some((name, target.speed.as_ref()?)))
        else {
            return Ok(None);
        };
        let speeds = score::quantities(self.recording(motion, None), &[wanted])?;
        Ok(speeds.first().map(|speed| (name.to_owned(), *speed)))
    }
}

/// Simulates a design in a task again, in all worlds that its value depends on.
pub(super) fn replay_task(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    how: How<'_>,
) -> Result<ReplayedTask, DesignError> {
    let driven = Driven::new(candidate, saved, how.precision)?;
    let worlds = driven.worlds();
    let mut motions = driven.motions(&worlds, how.solver, how.stop)?.into_iter();
    let motion = motions.next().unwrap_or(Err(Invalid::NotFinite));
    let (mut elsewhere, mut lost) = (Vec::with_capacity(worlds.len()), None);
    for (scenario, motion) in worlds.into_iter().skip(1).zip(motions) {
        match motion {
            Ok(motion) => elsewhere.push((scenario, motion)),
            Err(why) => lost = lost.or(Some((scenario.name, why))),
        }
    }
    let (mut scored, mut nominal, mut speed, mut each) = (None, None, None, Vec::new());
    if let Ok(motion) = &motion {
        let recording = driven.recording(motion, None);
        if lost.is_none() {
            let everywhere = Recording { elsewhere: &elsewhere, ..recording };
            scored = Some(score(everywhere)?);
            if !driven.drive.task().beside.is_empty() {
                each = score::objectives(everywhere)?;
            }
        }
        if driven.drive.task().runs_over_worlds() {
            nominal = Some(score::objective(recording)?);
        }
        speed = driven.speed(motion)?;
    }
    // What reacts was asked for what its motion says.
    let commands = motion.as_ref().ok().and_then(|motion| motion.commands.clone());
    let (name, targets) = (
        saved.name.clone(),
        commands.map_or_else(|| Ok(driven.control_law()?.targets), Ok::<_, DesignError>)?,
    );
    Ok(ReplayedTask { name, motion, targets, score: scored, each, nominal, lost, speed })
}

/// What is simulated when a design does a task.
pub struct Setup<'r> {
    /// Elements and joints.
    pub body: Arc<Body>,
    /// The numbers of the simulation.
    pub settings: simulate::Settings,
    /// What drives its actuators.
    pub law: ControlLaw<'r>,
}

impl Setup<'_> {
    /// The motion that a solver makes of it.
    ///
    /// # Errors
    ///
    /// A sentence that says what does not fit, or that the motion is not valid.
    pub fn motion(&self, solver: &str) -> Result<Motion, DesignError> {
        let model = simulate::model(solver).ok_or_else(|| DesignError::NoSolver(solver.to_owned()))?;
        let mut simulation = model.prepare(&self.body.assembly, &self.settings)?;
        let motions =
            simulation.run_cases(Stop::NEVER, &[self.law.case(&World::NOMINAL)]).unwrap_or_default();
        Ok(motions.into_iter().next().unwrap_or(Err(Invalid::NotFinite))?)
    }
}

/// What a saved design does in a task (the first, if none is named) before anything simulates it.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn setup<'r>(
    rules: &'r RuleSet,
    design: &SavedDesign,
    task: Option<&str>,
    precision: Precision,
) -> Result<Setup<'r>, DesignError> {
    let candidate = candidate(rules, design)?;
    let driven = Driven::new(&candidate, design.task(task)?, precision)?;
    let law = driven.control_law()?;
    Ok(Setup { body: candidate.body, settings: driven.settings, law })
}

/// The motion of a saved design in a world, in a task (the first, if none is named), or why it is not valid.
///
/// # Errors
///
/// A sentence that says what does not fit.
pub fn motion_in(
    rules: &RuleSet,
    design: &SavedDesign,
    task: Option<&str>,
    world: &Scenario,
    solver: &str,
    precision: Precision,
) -> Result<Result<Motion, Invalid>, DesignError> {
    let candidate = candidate(rules, design)?;
    let driven = Driven::new(&candidate, design.task(task)?, precision)?;
    driven.motion_in(world, solver, Stop::NEVER)
}

/// What a saved design feels, remembers and is asked for in a task (the first, if none is named) in a world; none where nothing of
/// it reacts.
///
/// # Errors
///
/// A sentence that says what does not fit, or that the motion is not valid.
pub fn signals(
    rules: &RuleSet,
    design: &SavedDesign,
    task: Option<&str>,
    world: &Scenario,
    solver: &str,
    precision: Precision,
) -> Result<Option<Trace>, DesignError> {
    let candidate = candidate(rules, design)?;
    let driven = Driven::new(&candidate, design.task(task)?, precision)?;
    if !driven.control_law()?.is_closed_loop() {
        return Ok(None);
    }
    let conditions = world.conditions(candidate.body.actuators.len());
    let traced = Traced::new(&driven.drive, &driven.parameters, &conditions)?;
    let model = simulate::model(solver).ok_or_else(|| DesignError::NoSolver(solver.to_owned()))?;
    let mut simulation = model.prepare(&candidate.body.assembly, &driven.settings)?;
    let motions = simulation.run_cases(Stop::NEVER, &[traced.case(&world.world())]).unwrap_or_default();
    motions.into_iter().next().unwrap_or(Err(Invalid::NotFinite))?;
    Ok(Some(traced.trace()))
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
    let motion = simulate::export::read_motion(motion, &candidate.body.assembly, &driven.settings)?;
    let recording = driven.recording(&motion, None);
    let is_first = rules.is_first(driven.drive.task());
    let scored = score(recording).map_err(|error| match error.reason == UNKNOWN_HERE {
        true => DesignError::NotInMotion,
        false => error.into(),
    });
    Ok((scored?, if is_first { score::observe(recording) } else { Vec::new() }))
}

fn task_of<'r>(rules: &'r RuleSet, saved: &SavedTask) -> Result<&'r Task, DesignError> {
    rules.tasks.get(&saved.name).ok_or_else(|| DesignError::NotInGrammar(saved.name.clone()))
}
