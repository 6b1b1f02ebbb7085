//! Evaluates saved designs again and cross-checks them.

use std::sync::Arc;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{Expr, RuleSet, Task};
use indexmap::IndexMap;

use super::describe;
use super::names::Names;
use super::saved::{Check, Grammar, Measured, SavedDesign, SavedTask};
use crate::derive::Derivation;
use crate::design::Body;
use crate::design::assembly::{Assembly, JointKind};
use crate::drive::Drive;
use crate::score::{self, Observed, Recording, Score, score};
use crate::search::{Best, keeps, settings};
use crate::simulate::{self, Invalid, Motion, Settings, Stop};

/// The names of the checks that every final best goes through.
const HALF_STEP: &str = "half the step, finer contacts";
/// What keeps its value at half the step may still live on an error that is slow to show.
const EIGHTH: &str = "an eighth of the step, finer contacts";
/// Nothing carries a body away on a floor without friction, but errors of the solver do.
const ICE: &str = "a floor of ice";
/// A centre of mass that stays this near on ice, m, has stayed: rounding is a hundredth of it.
const STAYS: f64 = 2e-4;
const RAPIER: &str = "rapier";
/// By how much friction, masses and motors are moved, one after the other.
const SHIFTS: [(&str, Shift); 6] = [
    ("friction 10 % lower", Shift::Friction(0.9)),
    ("friction 10 % higher", Shift::Friction(1.1)),
    ("masses 10 % lower", Shift::Mass(0.9)),
    ("masses 10 % higher", Shift::Mass(1.1)),
    ("motors 10 % weaker", Shift::Motors(0.9)),
    ("motors 10 % stronger", Shift::Motors(1.1)),
];

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
struct Trial<'a> {
    solver: &'a str,
    precision: Precision,
    shift: Option<Shift>,
    stop: Stop<'a>,
}

/// A body or a ground that is not quite what was thought: a factor for one of its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shift {
    /// Friction of the parts with the ground and each other.
    Friction(f64),
    /// No friction at all.
    Ice,
    /// The masses of all parts.
    Mass(f64),
    /// Largest torque, stiffness and damping of the servos.
    Motors(f64),
}

impl Shift {
    fn apply(self, assembly: &mut Assembly, settings: &mut Settings) {
        match self {
            Self::Ice => Self::Friction(0.0).apply(assembly, settings),
            Self::Friction(factor) => {
                settings.ground_friction *= factor;
                assembly.elements.iter_mut().for_each(|element| element.friction *= factor);
            }
            Self::Mass(factor) => assembly.elements.iter_mut().for_each(|element| element.mass *= factor),
            Self::Motors(factor) => {
                for joint in &mut assembly.joints {
                    if let JointKind::Hinge(hinge) = &mut joint.kind {
                        hinge.torque *= factor;
                        hinge.stiffness *= factor;
                        hinge.damping *= factor;
                    }
                }
                assembly.swellings.iter_mut().for_each(|swelling| swelling.gain *= factor);
            }
        }
    }
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

/// Checks that the derivation of a design leads, by its own grammar, to the body that was saved.
///
/// # Errors
///
/// A sentence: it does not.
pub fn check_body(rules: &RuleSet, design: &SavedDesign) -> Result<(), String> {
    let (derivation, body) = body_of(rules, design)?;
    if derivation.design.canonical_hash(rules) != design.body {
        return Err("its derivation does not lead to the body that was saved: it was changed".to_owned());
    }
    // Earlier versions wrote no names.
    let is_named = !design.own_names.is_empty();
    if is_named {
        design.own_names.check(&body.actuators)?;
    }
    for saved in &design.tasks {
        let (_, drive, _) = drive_of(rules, saved, (&derivation, &body))?;
        if !is_named {
            continue;
        }
        let labels = drive.labels(|id| design.own_names.get(id).unwrap_or_default().to_owned());
        let other = saved.drive.iter().zip(&labels).find(|((saved, _), label)| saved != *label);
        if let Some(((saved, _), label)) = other {
            return Err(format!(
                "`{saved}` in its drive is `{label}` by the names of its parts: the file was changed"
            ));
        }
    }
    Ok(())
}

/// Checks that a design says of itself what its simulation says: values, terms and what was observed, to the bit.
///
/// # Errors
///
/// A sentence that names the first difference.
pub fn check_values(design: &SavedDesign, replayed: &Replayed) -> Result<(), String> {
    let is_same = |a: f64, b: f64| a.to_bits() == b.to_bits();
    if !replayed.value.is_some_and(|value| is_same(value, design.value))
        || replayed.tasks.len() != design.tasks.len()
    {
        return Err(design.other_value());
    }
    let changed =
        |what: String| Err(format!("{what} is another one than the design comes to: the file was changed"));
    for (task, saved) in replayed.tasks.iter().zip(&design.tasks) {
        let Some(score) = &task.score else { return Err(design.other_value()) };
        if !is_same(score.value, saved.value) {
            return changed(format!("the saved value of the task `{}`", saved.name));
        }
        let names = |terms: &[(String, f64)]| terms.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        if names(&score.terms) != names(&saved.terms) {
            return changed("the list of saved terms".to_owned());
        }
        let other = score.terms.iter().zip(&saved.terms).find(|((_, now), (_, then))| !is_same(*now, *then));
        if let Some(((name, _), _)) = other {
            return changed(format!("the saved term `{name}`"));
        }
    }
    for (name, value) in &replayed.observed {
        if design.observed.get(name).is_some_and(|saved| saved != value) {
            return changed(format!("what was observed as `{name}`"));
        }
    }
    Ok(())
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

fn replay_task(
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

/// Makes the saved form of a best design.
///
/// # Errors
///
/// A sentence; a best design has been simulated before, so there should be none.
pub fn save(
    rules: &RuleSet,
    grammar: Grammar,
    seed: u64,
    solver: &str,
    best: &Best,
) -> Result<SavedDesign, String> {
    let body = Body::new(&best.derivation.design, rules);
    let mut design = SavedDesign::new(
        grammar,
        seed,
        solver,
        best.found_at,
        (best.value, &rules.objective.unit),
        (&best.derivation, best.derivation.design.canonical_hash(rules)),
    );
    design.penalties = score::penalties(rules, &best.derivation).map_err(|e| e.reason)?;
    design.observed = rules.observed.iter().cloned().zip(best.observed().iter().cloned()).collect();
    design.own_names = Names::of(rules, &best.derivation.design);
    let names = design.own_names.clone();
    for ((name, task), tune) in rules.tasks.iter().zip(&best.tasks) {
        let drive = Drive::new(rules, task, Arc::clone(&best.derivation), &body).map_err(|e| e.reason)?;
        let mut saved = SavedTask {
            name: name.clone(),
            value: tune.value,
            unit: task.objective.unit.clone(),
            terms: Vec::new(),
            checks: Vec::new(),
            drive: drive
                .labels(|id| names.get(id).unwrap_or_default().to_owned())
                .into_iter()
                .zip(tune.parameters.iter().copied())
                .collect(),
        };
        let trial = Trial { solver, precision: Precision::Model, shift: None, stop: Stop::NEVER };
        let replayed = replay_task(rules, &saved, (&best.derivation, &body), trial)?;
        saved.terms = replayed.score.map(|s| s.terms).unwrap_or_default();
        if let Some(half) = tune.half_step {
            let (name, value) = (HALF_STEP.to_owned(), Some(half));
            saved.checks.push(Check { name, value, measured: Measured::Value });
        }
        design.tasks.push(saved);
    }
    Ok(design)
}

/// Adds what a final best is checked with: half the step, where the search had
/// no need to, an eighth of it, the opinion of the reference solver, and other friction, masses and motors.
///
/// # Errors
///
/// A sentence that says what does not fit, or that it was stopped.
pub fn final_check(rules: &RuleSet, design: &SavedDesign, stop: Stop<'_>) -> Result<SavedDesign, String> {
    let mut design = design.clone();
    let (derivation, body) = body_of(rules, &design)?;
    let solver = design.solver.as_str();
    let plain = Trial { solver, precision: Precision::Model, shift: None, stop };
    let mut trials = vec![
        (HALF_STEP, Trial { precision: Precision::Finer, ..plain }),
        (EIGHTH, Trial { precision: Precision::Finest, ..plain }),
        (ICE, Trial { shift: Some(Shift::Ice), ..plain }),
    ];
    if solver != RAPIER {
        trials.push((RAPIER, Trial { solver: RAPIER, ..plain }));
        trials.extend(SHIFTS.map(|(name, shift)| (name, Trial { shift: Some(shift), ..plain })));
    }
    for saved in &mut design.tasks {
        for &(name, trial) in &trials {
            if saved.checks.iter().all(|check| check.name != name) {
                // A check without a value does not confirm: the best stands, and says so.
                let replayed = replay_task(rules, saved, (&derivation, &body), trial);
                // One that was given up says nothing.
                if replayed.is_err() && stop.is_asked() {
                    return Err("stopped before all cross-checks were made".to_owned());
                }
                let measured =
                    if trial.shift == Some(Shift::Ice) { Measured::Drift } else { Measured::Value };
                let value = replayed.ok().and_then(|replayed| match measured {
                    Measured::Value => Some(replayed.score?.value),
                    Measured::Drift => Some(replayed.motion.ok()?.drift(&body.assembly)),
                });
                saved.checks.push(Check { name: name.to_owned(), value, measured });
            }
        }
    }
    Ok(design)
}

/// What a cross-check says of the value of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It holds there.
    Confirmed,
    /// It is not worth as much there as a best should be.
    Worse,
    /// It is worth so much more there that the value itself is no measure of it.
    Better,
    /// There is nothing to compare, or the robot goes where nothing can go.
    Refuted,
}

impl Verdict {
    /// What is said beside the value; nothing where it holds.
    #[must_use]
    pub fn remark(self) -> &'static str {
        match self {
            Self::Confirmed => "",
            Self::Better => "   (so much more that it is in doubt: see docs/physics.md)",
            Self::Worse | Self::Refuted => "   (less than a best should keep: see docs/physics.md)",
        }
    }
}

/// What a cross-check says of the value of a task. Both must be as good as the share of the other that the search asks for.
#[must_use]
pub fn verdict(rules: &RuleSet, saved: &SavedTask, check: &Check) -> Verdict {
    let Some((task, other)) = rules.tasks.get(&saved.name).zip(check.value) else { return Verdict::Refuted };
    match check.measured {
        Measured::Drift if other <= STAYS => Verdict::Confirmed,
        Measured::Drift => Verdict::Refuted,
        Measured::Value if !keeps(rules, task, saved.value, other) => Verdict::Worse,
        Measured::Value if !keeps(rules, task, other, saved.value) => Verdict::Better,
        Measured::Value => Verdict::Confirmed,
    }
}

/// Whether a cross-check confirms the value of a task.
#[must_use]
pub fn confirmed(rules: &RuleSet, saved: &SavedTask, check: &Check) -> bool {
    verdict(rules, saved, check) == Verdict::Confirmed
}

/// What a cross-check came to, in words.
#[must_use]
pub fn outcome(saved: &SavedTask, check: &Check) -> String {
    match (check.value, check.measured) {
        (None, _) => "not a valid motion".to_owned(),
        (Some(value), Measured::Value) => describe::quantity(value, &saved.unit),
        (Some(drift), Measured::Drift) if drift <= STAYS => "it gets nowhere, as it should".to_owned(),
        (Some(drift), Measured::Drift) => {
            format!("its centre of mass goes {} astray", describe::quantity(100.0 * drift, "cm"))
        }
    }
}

/// What a broken preference adds to the value.
#[must_use]
pub fn signed(rules: &RuleSet, weight: f64) -> f64 {
    rules.objective.direction.worse_by(0.0, weight)
}

/// What was observed, in words: a line.
#[must_use]
pub fn observed(rules: &RuleSet, name: &str, value: Option<&Observed>) -> String {
    format!("  observed {name} {}\n", observed_value(rules, name, value))
}

/// The value of what was observed, in words.
#[must_use]
pub fn observed_value(rules: &RuleSet, name: &str, value: Option<&Observed>) -> String {
    match value {
        Some(Observed::Number(x)) => describe::term(rules, &rules.objective.unit, name, *x),
        Some(other) => other.to_string(),
        None => "has no value".to_owned(),
    }
}

/// The value, tasks, terms and checks of a design in words.
#[must_use]
pub fn report(rules: &RuleSet, design: &SavedDesign) -> String {
    let mut out = format!("value {}\n", describe::quantity(design.value, &design.unit));
    for (name, weight) in &design.penalties {
        out.push_str(&format!(
            "  not fulfilled: {name} ({})\n",
            describe::quantity(signed(rules, *weight), &design.unit)
        ));
    }
    for (name, value) in &design.observed {
        out.push_str(&observed(rules, name, value.as_ref()));
    }
    for saved in &design.tasks {
        if saved.name != RuleSet::ONLY_TASK {
            let value = describe::quantity(saved.value, &saved.unit);
            out.push_str(&format!("task {} {value}\n", saved.name));
        }
        for (name, value) in &saved.terms {
            out.push_str(&format!("  {name} {}\n", describe::term(rules, &saved.unit, name, *value)));
        }
        for check in &saved.checks {
            let text = outcome(saved, check);
            let remark = verdict(rules, saved, check).remark();
            out.push_str(&format!("  with {}: {text}{remark}\n", check.name));
        }
    }
    out
}
