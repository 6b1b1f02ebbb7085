//! The value of curves over all worlds that the objective of a task runs over.

use super::super::aim::Aim;
use super::super::cache::{self, Cache, Subject};
use super::super::evaluated::{Evaluated, Valued};
use super::super::fidelity::{Each, Fidelity};
use super::super::tally::Missing;
use super::closely::on_threads;
use super::{Evaluator, valued};
use crate::derive::Candidate;
use crate::drive::{ControlLaw, Parameters};
use crate::scenarios::{self, Scenario};
use crate::score::{self, Recording};
use crate::simulate::{Case, Invalid, Motion, Stop, World};
use grammar_lang::ir::Task;

/// The worlds of a task, where its value depends on them.
pub(super) struct Worlds {
    /// All of them, the nominal one first.
    scenarios: Vec<Scenario>,
    /// Names evaluations in them.
    subjects: Each<Subject>,
}

/// So many worlds are simulated before a worst case is looked at again, and then all that are left: side by side a
/// few take hardly longer than one.
const FIRST: [usize; 2] = [3, 4];

/// What a worst case came to.
pub(in super::super) enum WorstCase {
    /// A world is no better than what is needed: which, and how good the worst of those is that were simulated, where more is
    /// better. The worst of all is no better.
    AtMost { value: f64, by: usize },
    /// The value over all worlds, and the worlds but for the nominal one, the hardest first.
    Known { evaluated: Evaluated, hardest: Vec<usize> },
}

impl Worlds {
    /// The worlds that the objective of a task runs over, if it does.
    pub(super) fn of(candidate: &Candidate<'_>, task: &Task, aim: Option<&Aim>) -> Option<Self> {
        let within = task.scenarios.as_ref().filter(|_| task.runs_over_worlds())?;
        let set = candidate.rules.scenarios.get(&within.name)?;
        let subjects = Each::of(|fidelity| {
            let nominal = cache::subject(&candidate.derivation, &task.name, fidelity);
            super::of_aim(cache::named(&nominal, b"in all worlds"), aim)
        });
        let scenarios = scenarios::worlds(&within.name, set);
        Some(Self { scenarios, subjects })
    }

    /// All of them, the nominal one first.
    pub(super) fn scenarios(&self) -> &[Scenario] {
        &self.scenarios
    }
}

impl Evaluator<'_> {
    /// How many worlds the value of curves depends on; none if it is that of the nominal one alone.
    pub(in super::super) fn worlds(&self) -> Option<u64> {
        self.worlds.as_ref().map(|worlds| worlds.scenarios.len() as u64)
    }

    /// The value of curves over all worlds, as closely as is asked for. None if it was asked to stop before
    /// all motions were simulated, or the task has no worlds.
    pub(in super::super) fn in_worlds(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        fidelity: Fidelity,
    ) -> Option<Evaluated> {
        let worlds = self.worlds.as_ref()?;
        let subject = worlds.subjects.get(fidelity);
        let key = Cache::key(subject, parameters);
        if let Some(known) = self.engine.cache.get(&key, f64::NEG_INFINITY) {
            return Some(known);
        }
        let actuators = self.drive.candidate().body.actuators.len();
        let laws: Result<Vec<(ControlLaw<'_>, World)>, _> = worlds
            .scenarios
            .iter()
            .map(|one| {
                let law = self.drive.control_law_under(parameters, &one.conditions(actuators))?;
                Ok((law, one.world()))
            })
            .collect();
        let evaluated = match laws {
            Err(error) => without(Missing::Expression(error)),
            Ok(driven) => {
                let motions = self.everywhere(stop, &driven, fidelity)?;
                self.valued(parameters, motions)
            }
        };
        self.engine.cache.keep(key, &evaluated);
        Some(evaluated)
    }

    /// The worst case of curves whose value in the nominal world is known, as far as it is needed to say whether it is more
    /// than so much, where more is better; and how many worlds were simulated for it. `order` says which come first; worlds
    /// that it does not name come last. None if it was asked to stop before that was known, or the task has no worlds.
    pub(in super::super) fn worst_case(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        (nominal, needed): (f64, f64),
        order: &[usize],
    ) -> Option<(WorstCase, u64)> {
        let worlds = self.worlds.as_ref()?;
        let direction = self.drive.task().objective.direction;
        let count = worlds.scenarios.len();
        let rest = (1..count).filter(|world| !order.contains(world));
        let order: Vec<usize> =
            order.iter().copied().filter(|world| (1..count).contains(world)).chain(rest).collect();
        let mut values: Vec<(f64, usize)> = Vec::with_capacity(order.len());
        let mut sizes = FIRST.into_iter();
        while values.len() < order.len() {
            let left = &order[values.len()..];
            let group = &left[..sizes.next().unwrap_or(left.len()).min(left.len())];
            let found = self.each(stop, parameters, group)?;
            for (world, value) in group.iter().zip(found) {
                let value = match value {
                    Ok(value) => direction.fitness(value),
                    Err(why) => {
                        let known = WorstCase::Known { evaluated: without(why), hardest: order.clone() };
                        return Some((known, (values.len() + group.len()) as u64));
                    }
                };
                values.push((value, *world));
            }
            let worst = values.iter().min_by(|(a, _), (b, _)| a.total_cmp(b));
            if let Some((value, by)) = worst.copied().filter(|(value, _)| *value <= needed) {
                let value = value.min(direction.fitness(nominal));
                return Some((WorstCase::AtMost { value, by }, values.len() as u64));
            }
        }
        let spent = values.len() as u64;
        values.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let least = values.first().map_or(f64::INFINITY, |(value, _)| *value).min(direction.fitness(nominal));
        let hardest = values.into_iter().map(|(_, world)| world).collect();
        let observed = if self.observes { self.observe(stop, parameters)? } else { None };
        let value = Ok(direction.fitness(least));
        Some((WorstCase::Known { evaluated: Evaluated { observed, ..Evaluated::of(value) }, hardest }, spent))
    }

    /// The value of curves in each of some worlds by itself. None if it was asked to stop before.
    fn each(&mut self, stop: Stop<'_>, parameters: &Parameters, which: &[usize]) -> Option<Vec<Valued>> {
        let worlds = self.worlds.as_ref()?;
        let subject = *worlds.subjects.get(Fidelity::Model);
        let scenarios: Vec<Scenario> =
            which.iter().filter_map(|world| worlds.scenarios.get(*world)).cloned().collect();
        let keys: Vec<_> = scenarios
            .iter()
            .map(|one| Cache::key(&cache::named(&subject, one.name.as_bytes()), parameters))
            .collect();
        let known = |key| self.engine.cache.get(key, f64::NEG_INFINITY).map(|known| known.value);
        let mut values: Vec<Option<Valued>> = keys.iter().map(known).collect();
        let open: Vec<usize> = (0..values.len()).filter(|place| values[*place].is_none()).collect();
        let actuators = self.drive.candidate().body.actuators.len();
        let driven: Result<Vec<(ControlLaw<'_>, World)>, _> = open
            .iter()
            .map(|place| {
                let one = &scenarios[*place];
                Ok((self.drive.control_law_under(parameters, &one.conditions(actuators))?, one.world()))
            })
            .collect();
        let driven = match driven {
            Ok(driven) => driven,
            Err(error) => return Some(vec![Err(Missing::Expression(error)); which.len()]),
        };
        let motions =
            if driven.is_empty() { Vec::new() } else { self.everywhere(stop, &driven, Fidelity::Model)? };
        for (place, motion) in open.into_iter().zip(motions) {
            let scenario = &scenarios[place];
            let value = match motion {
                Err(why) => Err(Missing::Elsewhere(scenario.name.clone(), why)),
                Ok(motion) => {
                    let recording = Recording::nominal(&self.drive, parameters, &motion);
                    let here = Recording { scenario: Some(scenario), ..recording };
                    score::objective(here).map_err(Missing::Expression)
                }
            };
            let evaluated = Evaluated::of(value.clone());
            self.engine.cache.keep(keys[place], &evaluated);
            values[place] = Some(value);
        }
        values.into_iter().collect()
    }

    /// The value of curves over all worlds, if they were judged in them before.
    pub(in super::super) fn known_in_worlds(&self, parameters: &Parameters) -> Option<Valued> {
        let key = Cache::key(self.worlds.as_ref()?.subjects.get(Fidelity::Model), parameters);
        self.engine.cache.get(&key, f64::NEG_INFINITY).map(|known| known.value)
    }

    /// The motions in all worlds, on as many threads as there are.
    fn everywhere(
        &mut self,
        stop: Stop<'_>,
        driven: &[(ControlLaw<'_>, World)],
        fidelity: Fidelity,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let cases: Vec<Case<'_>> = driven.iter().map(|(law, world)| law.case(world)).collect();
        match fidelity {
            Fidelity::Model => {
                self.hire(cases.len());
            }
            Fidelity::HalfStep => return self.fine.run_cases(stop, &cases),
            Fidelity::Rods => self.hire_rods(cases.len()),
        }
        let crew = self.engine.crew;
        match (fidelity, &mut self.rods) {
            (Fidelity::Rods, Some(rods)) => on_threads(stop, crew, rods, &cases),
            (Fidelity::Rods, _) => Some(vec![Err(Invalid::Unfit); cases.len()]),
            _ => on_threads(stop, crew, &mut self.workers, &cases),
        }
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
                Err(why) => return without(Missing::Elsewhere(scenario.name.clone(), why)),
            }
        }
        let Some(nominal) = &nominal else { return without(Missing::Motion(Invalid::NotFinite)) };
        let recording =
            Recording { elsewhere: &elsewhere, ..Recording::nominal(&self.drive, parameters, nominal) };
        let (value, each) = valued(recording, self.aim.as_ref());
        let observed = (self.observes && value.is_ok()).then(|| score::observe(recording));
        Evaluated { observed, each, ..Evaluated::of(value) }
    }
}

fn without(why: Missing) -> Evaluated {
    Evaluated::of(Err(why))
}
