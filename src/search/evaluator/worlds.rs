//! The value of curves over all worlds that the objective of a task runs over.

use rayon::prelude::*;

use super::super::cache::{self, Cache, Subject};
use super::super::evaluated::{Evaluated, Valued};
use super::super::tally::Missing;
use super::Evaluator;
use crate::derive::Candidate;
use crate::drive::Parameters;
use crate::scenarios::{self, Scenario};
use crate::score::{self, Recording};
use crate::simulate::{Case, Invalid, Motion, Stop, Targets, World};
use grammar_lang::ir::Task;

/// The worlds of a task, where its value depends on them.
pub(super) struct Worlds {
    /// All of them, the nominal one first.
    scenarios: Vec<Scenario>,
    /// Names evaluations in them, and those at half the step.
    subjects: (Subject, Subject),
}

impl Worlds {
    /// The worlds that the objective of a task runs over, if it does.
    pub(super) fn of(candidate: &Candidate<'_>, task: &Task) -> Option<Self> {
        let within = task.scenarios.as_ref().filter(|_| task.runs_over_worlds())?;
        let set = candidate.rules.scenarios.get(&within.name)?;
        let subject = |is_fine| {
            let nominal = cache::subject(&candidate.derivation, &task.name, is_fine);
            cache::named(&nominal, b"in all worlds")
        };
        let scenarios = scenarios::worlds(&within.name, set);
        Some(Self { scenarios, subjects: (subject(false), subject(true)) })
    }
}

impl Evaluator<'_> {
    /// How many worlds the value of curves depends on; none if it is that of the nominal one alone.
    pub(in super::super) fn worlds(&self) -> Option<u64> {
        self.worlds.as_ref().map(|worlds| worlds.scenarios.len() as u64)
    }

    /// The value of curves over all worlds, at the step of the model or at half of it. None if it was asked to stop before
    /// all motions were simulated, or the task has no worlds.
    pub(in super::super) fn in_worlds(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        is_fine: bool,
    ) -> Option<Evaluated> {
        let worlds = self.worlds.as_ref()?;
        let subject = if is_fine { &worlds.subjects.1 } else { &worlds.subjects.0 };
        let key = Cache::key(subject, parameters);
        if let Some(known) = self.engine.cache.get(&key, f64::NEG_INFINITY) {
            return Some(known);
        }
        let actuators = self.drive.candidate().body.actuators.len();
        let targets: Result<Vec<(Targets, World)>, _> = worlds
            .scenarios
            .iter()
            .map(|one| {
                let targets = self.drive.targets_under(parameters, &one.conditions(actuators))?;
                Ok((targets, one.world()))
            })
            .collect();
        let evaluated = match targets {
            Err(error) => without(Missing::Expression(error)),
            Ok(driven) => {
                let motions = self.everywhere(stop, &driven, is_fine)?;
                self.valued(parameters, motions)
            }
        };
        self.engine.cache.keep(key, &evaluated);
        Some(evaluated)
    }

    /// The value of curves over all worlds, if they were judged in them before.
    pub(in super::super) fn known_in_worlds(&self, parameters: &Parameters) -> Option<Valued> {
        let key = Cache::key(&self.worlds.as_ref()?.subjects.0, parameters);
        self.engine.cache.get(&key, f64::NEG_INFINITY).map(|known| known.value)
    }

    /// The motions in all worlds, on as many threads as there are.
    fn everywhere(
        &mut self,
        stop: Stop<'_>,
        driven: &[(Targets, World)],
        is_fine: bool,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let cases: Vec<Case<'_>> = driven.iter().map(|(drive, world)| Case { drive, world }).collect();
        if is_fine {
            return self.fine.run_cases(stop, &cases);
        }
        let threads = self.hire(cases.len());
        let share = cases.len().div_ceil(threads);
        let Self { engine, workers, .. } = self;
        if let ([worker, ..], 1) = (workers.as_mut_slice(), threads) {
            return worker.run_cases(stop, &cases);
        }
        let parts: Option<Vec<_>> = engine.crew.run(|| {
            let shares = workers.par_iter_mut().zip(cases.par_chunks(share));
            shares.map(|(worker, part)| worker.run_cases(stop, part)).collect()
        });
        Some(parts?.into_iter().flatten().collect())
    }

    /// The value of motions in all worlds: none if one of them has none.
    fn valued(&self, parameters: &Parameters, motions: Vec<Result<Motion, Invalid>>) -> Evaluated {
        let Some(worlds) = &self.worlds else { return without(Missing::Motion(Invalid::NotFinite)) };
        let mut nominal = None;
        let mut elsewhere = Vec::with_capacity(motions.len());
        for (place, (scenario, motion)) in worlds.scenarios.iter().zip(motions).enumerate() {
            match motion {
                Ok(motion) if place == 0 => nominal = Some(motion),
                Ok(motion) => elsewhere.push((scenario.clone(), motion)),
                Err(why) if place == 0 => return without(Missing::Motion(why)),
                Err(_) => return without(Missing::Elsewhere(scenario.name.clone())),
            }
        }
        let Some(nominal) = &nominal else { return without(Missing::Motion(Invalid::NotFinite)) };
        let recording =
            Recording { elsewhere: &elsewhere, ..Recording::nominal(&self.drive, parameters, nominal) };
        let value = score::objective(recording).map_err(Missing::Expression);
        let observed = (self.observes && value.is_ok()).then(|| score::observe(recording));
        Evaluated { value, ceiling: f64::INFINITY, observed }
    }
}

fn without(why: Missing) -> Evaluated {
    Evaluated { value: Err(why), ceiling: f64::INFINITY, observed: None }
}
