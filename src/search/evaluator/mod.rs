//! Evaluates parameters of one body: drive, simulation, score.

mod closely;
mod worlds;

use super::evaluated::{Evaluated, Valued};
use super::fidelity::{Each, Fidelity};
use std::collections::BTreeMap;
use std::sync::Mutex;

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{self, Expr, RuleSet, Task};
use rayon::prelude::*;

use super::Failure;
use super::aim::Aim;
use super::cache::{self, Cache, Key, Subject};
use super::crew::Crew;
use super::tally::Missing;
use crate::derive::Candidate;
use crate::drive::{Conditions, ControlLaw, Drive, Exploration, Explorer, Parameters};
use crate::score::ceiling::{self, Underway};
use crate::score::{self, Observed, Recording};
use crate::simulate::{
    self, Case, Invalid, Model, Motion, Settings, Simulation, SolverName, Stop, Unfit, Watch, World,
};
use closely::WithRods;
use worlds::Worlds;
pub(super) use worlds::WorstCase;

/// What evaluations are made with.
#[derive(Clone, Copy)]
pub(super) struct Engine<'r> {
    /// What simulates.
    pub(super) model: &'r dyn Model,
    /// What is known already.
    pub(super) cache: &'r Cache,
    /// The threads.
    pub(super) crew: &'r Crew,
}

/// Evaluates parameters of one body for one task, several at a time.
pub(super) struct Evaluator<'r> {
    engine: Engine<'r>,
    /// Names evaluations of this body.
    subjects: Each<Subject>,
    /// The actuation of the body.
    pub(super) drive: Drive<'r>,
    settings: Settings,
    /// One simulation for each thread that has been needed; at least one.
    workers: Vec<Box<dyn Simulation>>,
    /// The simulation at half the step.
    fine: Box<dyn Simulation>,
    /// Those with rods in place of rows that bend, where a best must keep its value with them.
    rods: Option<WithRods>,
    /// The worlds that its value depends on.
    worlds: Option<Worlds>,
    /// Whether anything is observed of this task.
    observes: bool,
    /// The value, where more is better, above which motions are observed: others will not be asked for it.
    pub(super) observed_above: f64,
    /// What the move is after, where a front is searched for.
    pub(super) aim: Option<Aim>,
}

/// The solver that a grammar's models are meant for.
#[must_use]
pub fn solver(rules: &RuleSet) -> SolverName {
    match rules.method() {
        ir::Method::Balls(_) => SolverName::Balls,
        ir::Method::Hinges => SolverName::Articulated,
    }
}

/// Why a solver cannot simulate a design, if it cannot; [`solver`] is the one that the grammar's models are meant for.
#[must_use]
pub fn unfit(candidate: &Candidate<'_>, solver: &str) -> Option<Unfit> {
    let rules = candidate.rules;
    let model = simulate::model(solver)?;
    let assembly = &candidate.body.assembly;
    rules.tasks.values().find_map(|task| model.prepare(assembly, &settings(&task.model)).err())
}

/// A model's numbers as a solver takes them.
#[must_use]
pub fn settings(model: &ir::Model) -> Settings {
    Settings {
        step: model.step,
        duration: model.duration,
        record: model.record,
        gravity: model.gravity,
        ground_friction: model.ground_friction,
        iterations: model.iterations,
        tolerance: model.tolerance,
        self_collision: model.self_collision,
        speed_limit: model.speed_limit,
        pace_limit: model.pace_limit,
    }
}

impl<'r> Evaluator<'r> {
    /// Prepares a body.
    ///
    /// # Errors
    ///
    /// [`Failure`] when the model cannot simulate it, or an expression has no value.
    pub(super) fn new(
        candidate: &Candidate<'r>,
        task: &'r Task,
        engine: Engine<'r>,
        aim: Option<Aim>,
    ) -> Result<Self, Failure> {
        let Candidate { rules, derivation, body } = candidate;
        let drive = Drive::new(candidate, task)?;
        if let Some(unfit) = drive.unfit() {
            return Err(unfit.into());
        }
        let settings = settings(&task.model);
        let workers = vec![engine.model.prepare(&body.assembly, &settings)?];
        let fine = engine.model.prepare(&body.assembly, &settings.finer())?;
        let rods = closely::with_rods(candidate, engine, &settings);
        let subjects =
            Each::of(|fidelity| of_aim(cache::subject(derivation, &task.name, fidelity), aim.as_ref()));
        let observes = !rules.observed.is_empty() && rules.is_first(task);
        let observed_above = f64::NEG_INFINITY;
        let worlds = Worlds::of(candidate, task, aim.as_ref());
        Ok(Self {
            engine,
            subjects,
            drive,
            settings,
            workers,
            fine,
            rods,
            worlds,
            observes,
            observed_above,
            aim,
        })
    }

    /// How many evaluations can go on at once now: threads, and lanes of each.
    pub(super) fn room(&self) -> (usize, usize) {
        (self.engine.crew.threads(), self.workers.iter().map(|worker| worker.lanes()).min().unwrap_or(1))
    }

    /// How many joints of the body move.
    pub(super) fn hinges(&self) -> usize {
        let joints = &self.drive.candidate().body.assembly.joints;
        joints.iter().map(|joint| joint.kind.dofs().len()).sum()
    }

    /// Evaluates several parameters at once; each as if it were alone. None if it was
    /// asked to stop before all were done.
    pub(super) fn evaluate(&mut self, stop: Stop<'_>, batch: &[Parameters]) -> Option<Vec<Evaluated>> {
        let batch: Vec<_> = batch.iter().map(|one| (one.clone(), f64::NEG_INFINITY)).collect();
        self.evaluate_above(stop, &batch)
    }

    /// The same for parameters that are no use below a value, where more is better: what certainly stays
    /// below is given up on the way.
    pub(super) fn evaluate_above(
        &mut self,
        stop: Stop<'_>,
        batch: &[(Parameters, f64)],
    ) -> Option<Vec<Evaluated>> {
        let keys: Vec<Key> =
            batch.iter().map(|(one, _)| Cache::key(self.subjects.get(Fidelity::Model), one)).collect();
        // One that was no best of an earlier body may be one of this.
        let is_enough = |known: &Evaluated| known.observed.is_some() || !self.is_observed(&known.value);
        let mut values: Vec<Option<Evaluated>> = keys
            .iter()
            .zip(batch)
            .map(|(key, (_, need))| self.engine.cache.get(key, *need).filter(is_enough))
            .collect();
        let open: Vec<usize> = (0..batch.len()).filter(|&i| values[i].is_none()).collect();
        if !open.is_empty() {
            // What is asked for twice is simulated once, for the lesser need.
            let mut places: BTreeMap<Key, usize> = BTreeMap::new();
            let mut unknown: Vec<(Parameters, f64)> = Vec::new();
            for &i in &open {
                let place = *places.entry(keys[i]).or_insert(unknown.len());
                match unknown.get_mut(place) {
                    Some((_, needed)) => *needed = needed.min(batch[i].1),
                    None => unknown.push(batch[i].clone()),
                }
            }
            let simulated = self.simulate(stop, &unknown)?;
            for i in open {
                let value = &simulated[places[&keys[i]]];
                self.engine.cache.keep(keys[i], value);
                values[i] = Some(value.clone());
            }
        }
        values.into_iter().collect()
    }

    /// The value of parameters that were evaluated before.
    pub(super) fn known(&self, parameters: &Parameters) -> Option<Valued> {
        let key = Cache::key(self.subjects.get(Fidelity::Model), parameters);
        self.engine.cache.get(&key, f64::NEG_INFINITY).map(|known| known.value)
    }

    /// Whether a motion of this value is observed.
    fn is_observed(&self, value: &Valued) -> bool {
        self.judging().is_observed(value)
    }

    /// What values motions.
    fn judging(&self) -> Judging<'_> {
        let Self { drive, aim, observes, observed_above, .. } = self;
        Judging { drive, aim: aim.as_ref(), observed_above: observes.then_some(*observed_above) }
    }

    /// What is observed of the motion in the nominal world; none outside if it was asked to stop, none inside where the motion has no
    /// value.
    fn observe(&mut self, stop: Stop<'_>, parameters: &Parameters) -> Option<Option<Vec<Option<Observed>>>> {
        let Self { drive, aim, workers, .. } = self;
        let judging = Judging { drive, aim: aim.as_ref(), observed_above: Some(f64::NEG_INFINITY) };
        let one = (parameters.clone(), f64::NEG_INFINITY);
        let worker = workers.first_mut()?;
        Some(judging.values(stop, worker.as_mut(), &[one])?.into_iter().next()?.observed)
    }

    /// Sees that each thread has a simulation, as far as there is work for it; how many threads that are, at least one.
    fn hire(&mut self, cases: usize) -> usize {
        let Engine { model, crew, .. } = self.engine;
        let threads = crew.threads().min(cases);
        while self.workers.len() < threads {
            // What could be prepared once can be prepared again.
            let assembly = &self.drive.candidate().body.assembly;
            let Ok(worker) = model.prepare(assembly, &self.settings) else { break };
            self.workers.push(worker);
        }
        threads.clamp(1, self.workers.len())
    }

    fn simulate(&mut self, stop: Stop<'_>, batch: &[(Parameters, f64)]) -> Option<Vec<Evaluated>> {
        self.hire(batch.len());
        let Self { engine, drive, aim, workers, observes, observed_above, .. } = self;
        let one = Judging { drive, aim: aim.as_ref(), observed_above: observes.then_some(*observed_above) };
        one.on_threads(stop, engine.crew, workers, batch)
    }

    /// Makes motions in which the policy is explored that has these weights, side by side; they are counted from the first on. What each
    /// came to; none if it was asked to stop before all were made.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub(super) fn explore(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        (first, in_worlds): (u64, bool),
        explorers: Vec<&mut dyn Explorer>,
    ) -> Result<Option<Vec<Result<(), Missing>>>, EvalError> {
        let threads = self.hire(explorers.len());
        let Self { engine, drive, workers, worlds, .. } = self;
        let crew = engine.crew;
        let scenarios = worlds.as_ref().filter(|_| in_worlds).map_or(&[][..], Worlds::scenarios);
        let actuators = drive.candidate().body.actuators.len();
        let explorations: Result<Vec<(Exploration<'_, '_>, World)>, EvalError> = explorers
            .into_iter()
            .zip(first..)
            .map(|(explorer, number)| {
                let turn = number.checked_rem(scenarios.len() as u64).unwrap_or(0);
                let scenario = scenarios.get(turn as usize);
                let (world, conditions) = scenario
                    .map_or((World::NOMINAL, Conditions::NOMINAL), |scenario| {
                        (scenario.world(), scenario.conditions(actuators))
                    });
                // Sensors are not noisy in the same way each time.
                let conditions = Conditions { world: format!("motion {number}"), ..conditions };
                Ok((Exploration::new(drive, parameters, &conditions, explorer)?, world))
            })
            .collect();
        let explorations = explorations?;
        let share = explorations.len().div_ceil(threads).max(1);
        let run = |(worker, part): (&mut Box<dyn Simulation>, &[(Exploration<'_, '_>, World)])| {
            let cases: Vec<Case<'_>> = part.iter().map(|(one, world)| one.case(world)).collect();
            worker.run_cases(stop, &cases)
        };
        let parts: Option<Vec<_>> = if threads > 1 {
            crew.run(|| workers.par_iter_mut().zip(explorations.par_chunks(share)).map(run).collect())
        } else {
            workers.iter_mut().zip(explorations.chunks(share)).map(run).collect()
        };
        let Some(parts) = parts else { return Ok(None) };
        let motions = parts.into_iter().flatten();
        let came_to = |((exploration, _), motion): (
            (Exploration<'_, '_>, World),
            Result<Motion, Invalid>,
        )| match (exploration.failed(), motion) {
            (Some(error), _) => Err(Missing::Expression(error)),
            (None, Err(why)) => Err(Missing::Motion(why)),
            (None, Ok(_)) => Ok(()),
        };
        Ok(Some(explorations.into_iter().zip(motions).map(came_to).collect()))
    }

    /// The threads of the search.
    pub(super) fn crew(&self) -> &'r Crew {
        self.engine.crew
    }

    /// What an archive's descriptors say of a motion, in their order; none if it was asked to stop.
    pub(super) fn describe(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        described: &[&Expr],
    ) -> Option<Result<Vec<f64>, Missing>> {
        let Self { drive, workers, .. } = self;
        let worker = workers.first_mut()?;
        let law = match drive.control_law(parameters) {
            Ok(law) => law,
            Err(error) => return Some(Err(Missing::Expression(error))),
        };
        let motion = worker.run_cases(stop, &[law.case(&World::NOMINAL)])?.into_iter().next()?;
        Some(motion.map_err(Missing::Motion).and_then(|motion| {
            let recording = Recording::nominal(drive, parameters, &motion);
            score::quantities(recording, described).map_err(Missing::Expression)
        }))
    }
}

/// The name of evaluations by an aim.
fn of_aim(subject: Subject, aim: Option<&Aim>) -> Subject {
    aim.map_or(subject, |aim| cache::named(&subject, &aim.bits()))
}

/// What turns parameters into a value, apart from the simulation.
struct Judging<'a> {
    drive: &'a Drive<'a>,
    aim: Option<&'a Aim>,
    /// The value, where more is better, above which motions are observed, if any are.
    observed_above: Option<f64>,
}

impl Judging<'_> {
    /// Whether a motion of this value is observed.
    fn is_observed(&self, value: &Valued) -> bool {
        let fitness = |value: f64| self.drive.task().objective.direction.fitness(value);
        self.observed_above.is_some_and(|above| value.as_ref().is_ok_and(|value| fitness(*value) > above))
    }

    /// The values of parameters, simulated side by side; none if that was stopped.
    fn values(
        &self,
        stop: Stop<'_>,
        simulation: &mut dyn Simulation,
        batch: &[(Parameters, f64)],
    ) -> Option<Vec<Evaluated>> {
        let laws: Vec<_> = batch.iter().map(|(parameters, _)| self.drive.control_law(parameters)).collect();
        let driven: Vec<(&ControlLaw<'_>, &(Parameters, f64))> =
            laws.iter().zip(batch).filter_map(|(law, one)| Some((law.as_ref().ok()?, one))).collect();
        let cases: Vec<Case<'_>> = driven.iter().map(|(law, _)| law.case(&World::NOMINAL)).collect();
        let watch = Ceilings {
            judging: self,
            batch: driven.iter().map(|(_, one)| *one).collect(),
            least: driven.iter().map(|_| Mutex::new(f64::INFINITY)).collect(),
        };
        let motions = match self.drive.task().model.pace_limit {
            Some(_) => simulation.run_watched(stop, &cases, &watch)?,
            None => simulation.run_cases(stop, &cases)?,
        };
        let mut motions = motions.into_iter().zip(watch.least);
        let mut value = |(law, (parameters, _)): (&Result<_, EvalError>, &(Parameters, f64))| {
            if let Err(error) = law {
                return Evaluated::of(Err(Missing::Expression(error.clone())));
            }
            let (motion, least) =
                motions.next().unwrap_or((Err(Invalid::NotFinite), Mutex::new(f64::INFINITY)));
            let ceiling = least.into_inner().unwrap_or(f64::INFINITY);
            let motion = match motion {
                Ok(motion) => motion,
                Err(why) => return Evaluated { ceiling, ..Evaluated::of(Err(Missing::Motion(why))) },
            };
            let (value, each) = valued(self.recording(&motion, parameters), self.aim);
            let observed =
                self.is_observed(&value).then(|| score::observe(self.recording(&motion, parameters)));
            Evaluated { value, ceiling, observed, each }
        };
        Some(laws.iter().zip(batch).map(&mut value).collect())
    }

    /// The same, shared among simulations on as many threads as there are.
    fn on_threads(
        &self,
        stop: Stop<'_>,
        crew: &Crew,
        simulations: &mut [Box<dyn Simulation>],
        batch: &[(Parameters, f64)],
    ) -> Option<Vec<Evaluated>> {
        let share = closely::share(crew, simulations, batch.len());
        if let ([one, ..], true) = (&mut *simulations, batch.len() <= share) {
            return self.values(stop, one.as_mut(), batch);
        }
        let parts: Option<Vec<_>> = crew.run(|| {
            let shares = simulations.par_iter_mut().zip(batch.par_chunks(share));
            shares.map(|(one, part)| self.values(stop, one.as_mut(), part)).collect()
        });
        Some(parts?.into_iter().flatten().collect())
    }

    /// What the value of a motion under way can come to at most, where more is better.
    fn ceiling(&self, motion: &Motion, parameters: &[f64], now: f64) -> Option<f64> {
        // What is after several objectives is not bounded by the first.
        if self.aim.is_some() {
            return None;
        }
        let task = self.drive.task();
        let recording = self.recording(motion, parameters);
        let underway = Underway { recording, now, pace: task.model.pace_limit? };
        let (low, high) = ceiling::limits(underway).ok()?;
        let direction = task.objective.direction;
        Some(direction.fitness(direction.better(low, high)))
    }

    fn recording<'a>(&'a self, motion: &'a Motion, parameters: &'a [f64]) -> Recording<'a> {
        Recording::nominal(self.drive, parameters, motion)
    }
}

/// The value of a motion; and where a front is searched for, that of each objective.
fn valued(recording: Recording<'_>, aim: Option<&Aim>) -> (Valued, Vec<f64>) {
    let Some(aim) = aim else {
        return (score::objective(recording).map_err(Missing::Expression), Vec::new());
    };
    match score::objectives(recording) {
        Ok(each) => (Ok(aim.value(&each)), each),
        Err(error) => (Err(Missing::Expression(error)), Vec::new()),
    }
}

/// Keeps what the values of motions under way can come to, and gives up those that stay below what is needed.
struct Ceilings<'a> {
    judging: &'a Judging<'a>,
    batch: Vec<&'a (Parameters, f64)>,
    least: Vec<Mutex<f64>>,
}

impl Watch for Ceilings<'_> {
    fn gives_up(&self, case: usize, motion: &Motion, now: f64) -> bool {
        // Earlier, hardly anything is out of reach.
        if 2.0 * now < motion.duration {
            return false;
        }
        let (Some((parameters, needed)), Some(least)) = (self.batch.get(case), self.least.get(case)) else {
            return false;
        };
        let Some(ceiling) = self.judging.ceiling(motion, parameters, now) else { return false };
        let mut least = least.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        *least = least.min(ceiling);
        *least < *needed
    }
}
