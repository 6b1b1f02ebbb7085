//! Simulates again, and more closely, what looks like a new best.

use rayon::prelude::*;

use super::super::cache::Cache;
use super::super::crew::Crew;
use super::super::evaluated::Evaluated;
use super::super::fidelity::Fidelity;
use super::{Engine, Evaluator, Judging};
use crate::derive::Candidate;
use crate::drive::Parameters;
use crate::simulate::{Case, Invalid, Motion, Settings, Simulation, SolverName, Stop, rod};

/// Simulations with elastic rods in place of rows that bend: one for each thread that has been needed.
pub(super) type WithRods = Vec<Box<dyn Simulation>>;

/// A simulation with rods, where the search asks for it and the body has rows that bend. Of a body that this solver cannot
/// simulate there is no second opinion: its final check says so.
pub(super) fn with_rods(
    candidate: &Candidate<'_>,
    engine: Engine<'_>,
    settings: &Settings,
) -> Option<WithRods> {
    let assembly = &candidate.body.assembly;
    // Of itself a solver has no other opinion.
    let is_other = engine.model.name() != SolverName::Rod;
    let is_asked = candidate.rules.search.keep_with_rods.is_some() && is_other && rod::bends(assembly);
    let simulation = is_asked.then(|| SolverName::Rod.model().prepare(assembly, settings).ok()).flatten();
    simulation.map(|simulation| vec![simulation])
}

impl Evaluator<'_> {
    /// Whether a best is simulated with rods, too.
    pub(in super::super) fn has_rods(&self) -> bool {
        self.rods.is_some()
    }

    /// What comes of parameters in the nominal world, more closely; none if it was asked to stop before that was known.
    pub(in super::super) fn closely(
        &mut self,
        stop: Stop<'_>,
        parameters: &Parameters,
        fidelity: Fidelity,
    ) -> Option<Evaluated> {
        let key = Cache::key(self.subjects.get(fidelity), parameters);
        if let Some(known) = self.engine.cache.get(&key, f64::NEG_INFINITY) {
            return Some(known);
        }
        let value = self.looked_at(stop, std::slice::from_ref(parameters), fidelity)?.into_iter().next()?;
        self.engine.cache.keep(key, &value);
        Some(value)
    }

    /// Works out the values of several, side by side, so that they are known when they are asked for.
    pub(in super::super) fn prepare_closely(
        &mut self,
        stop: Stop<'_>,
        likely: &[Parameters],
        fidelity: Fidelity,
    ) {
        let key = |one: &Parameters| Cache::key(self.subjects.get(fidelity), one);
        let unknown = |one: &&Parameters| self.engine.cache.get(&key(one), f64::NEG_INFINITY).is_none();
        let batch: Vec<Parameters> = likely.iter().filter(unknown).cloned().collect();
        let values = self.looked_at(stop, &batch, fidelity);
        for (one, value) in batch.iter().zip(values.into_iter().flatten()) {
            self.engine.cache.keep(Cache::key(self.subjects.get(fidelity), one), &value);
        }
    }

    fn looked_at(
        &mut self,
        stop: Stop<'_>,
        batch: &[Parameters],
        fidelity: Fidelity,
    ) -> Option<Vec<Evaluated>> {
        let batch: Vec<_> = batch.iter().map(|one| (one.clone(), f64::NEG_INFINITY)).collect();
        if fidelity == Fidelity::Rods {
            self.hire_rods(batch.len());
        }
        let Self { engine, drive, aim, fine, workers, rods, .. } = self;
        let judging = Judging { drive, aim: aim.as_ref(), observed_above: None };
        match (fidelity, rods) {
            (Fidelity::Rods, Some(rods)) => judging.on_threads(stop, engine.crew, rods, &batch),
            (Fidelity::Model, _) => judging.on_threads(stop, engine.crew, workers, &batch),
            (Fidelity::HalfStep, _) | (Fidelity::Rods, None) => judging.values(stop, fine.as_mut(), &batch),
        }
    }

    /// Sees that each thread has a simulation with rods, as far as there is work for it.
    pub(super) fn hire_rods(&mut self, cases: usize) {
        let threads = self.engine.crew.threads().min(cases);
        let assembly = &self.drive.candidate().body.assembly;
        let Some(rods) = &mut self.rods else { return };
        while rods.len() < threads {
            // What could be prepared once can be prepared again.
            let Ok(more) = SolverName::Rod.model().prepare(assembly, &self.settings) else { break };
            rods.push(more);
        }
    }
}

/// How many of so many each simulation gets.
pub(super) fn share(crew: &Crew, simulations: &[Box<dyn Simulation>], all: usize) -> usize {
    let threads = crew.threads().min(simulations.len()).max(1);
    all.div_ceil(threads).max(1)
}

/// The motions of cases, shared among simulations on as many threads as there are. None if it was asked to stop before.
pub(super) fn on_threads(
    stop: Stop<'_>,
    crew: &Crew,
    simulations: &mut [Box<dyn Simulation>],
    cases: &[Case<'_>],
) -> Option<Vec<Result<Motion, Invalid>>> {
    let share = share(crew, simulations, cases.len());
    if let ([one, ..], true) = (&mut *simulations, cases.len() <= share) {
        return one.run_cases(stop, cases);
    }
    let parts: Option<Vec<_>> = crew.run(|| {
        let shares = simulations.par_iter_mut().zip(cases.par_chunks(share));
        shares.map(|(simulation, part)| simulation.run_cases(stop, part)).collect()
    });
    Some(parts?.into_iter().flatten().collect())
}
