//! Annealing of bodies, by one chain or several that may change places; and the random walk before it.

use std::sync::Arc;

use grammar_lang::ir::{Annealing, Schedule};

use super::super::schedule::{Plan, Stand, deviation, exchange, neighbours};
use super::super::state::{BodyChain, BodyChains, Designs, Incumbent, State};
use super::super::{Failure, accepts};
use super::{Begun, Bodies, End};
use crate::derive::Derivation;
use crate::derive::random::Stream;

impl Bodies<'_> {
    /// Begins all chains at the first design.
    pub(super) fn begin_chains(&mut self, annealing: &Annealing) {
        let chains = BodyChains::at(&self.state.first, annealing.chains.unwrap_or(1));
        self.state.designs = Some(Designs::Chains(chains));
    }

    /// The move that is next, or the end of an iteration.
    pub(super) fn begin_chain_move(
        &mut self,
        schedule: &Schedule,
        annealing: &Annealing,
    ) -> Result<Begun, Failure> {
        if let Some(walk) = annealing.walk
            && self.state.course.deviation.is_none()
        {
            let walked = self.state.annealing().map_or(&[][..], |chains| &chains.walk);
            if walked.len() < walk {
                return Ok(Begun::Move { chain: 0, temperature: 0.0 });
            }
            let deviation = deviation(walked);
            if deviation <= 0.0 {
                return Err(Failure::NoDeviation(walk));
            }
            self.state.course.deviation = Some(deviation);
            self.begin_chains(annealing);
            return Ok(Begun::Iteration);
        }
        if self.state.iteration.is_none() {
            let mut iteration = None;
            for number in 0..self.state.chains().len() {
                let plan = self.plan(schedule, number);
                if number == 0 {
                    iteration = plan.begin()?;
                }
                let temperature = plan.temperature(annealing)?;
                if let Some(chain) = self.state.chain(number) {
                    chain.standing.temperature = temperature;
                }
            }
            let Some(iteration) = iteration else { return Ok(Begun::End(End::Schedule)) };
            self.state.iteration = Some(iteration);
        }
        if self.state.iteration.is_some_and(|iteration| iteration.made >= iteration.moves) {
            return self.end_iteration(schedule, annealing);
        }
        let chain = self.state.annealing().map_or(0, |chains| chains.turn);
        let temperature = self.state.chains().get(chain).map_or(0.0, |chain| chain.standing.temperature);
        Ok(Begun::Move { chain, temperature })
    }

    fn end_iteration(&mut self, schedule: &Schedule, annealing: &Annealing) -> Result<Begun, Failure> {
        self.state.iteration = None;
        self.state.course.complete(self.state.best.as_ref().map(|b| b.value));
        if let Some(BodyChains { chains, .. }) = self.state.annealing() {
            chains.iter_mut().for_each(|chain| chain.standing.complete());
        }
        let mut is_over = true;
        for number in 0..self.state.chains().len() {
            is_over &= self.plan(schedule, number).stops()?;
        }
        if is_over {
            return Ok(Begun::End(End::Stopped));
        }
        if self.state.chains().len() > 1 && self.plan(schedule, 0).exchanges(annealing)? {
            let iteration = self.state.course.iteration;
            let mut random = Stream::named(self.seed, &format!("exchange {iteration}"));
            let direction = self.rules.objective.direction;
            let fitness = |value: Option<f64>| value.map_or(f64::NEG_INFINITY, |v| direction.fitness(v));
            let Some(BodyChains { chains, .. }) = self.state.annealing() else { return Ok(Begun::Iteration) };
            for first in neighbours(chains.len(), iteration) {
                let (before, after) = chains.split_at_mut(first + 1);
                let (one, other) = (&mut before[first], &mut after[0]);
                let place = |c: &BodyChain<_>| (c.standing.temperature, fitness(c.at.value));
                if exchange(place(one), place(other), random.unit()) {
                    std::mem::swap(&mut one.at, &mut other.at);
                }
            }
        }
        Ok(Begun::Iteration)
    }

    /// Metropolis's rule for the chain that tried a design; a random walk accepts whatever has a value.
    pub(super) fn accept(&mut self, chain: usize, tried: &Incumbent<Arc<Derivation>>, drawn: f64) -> bool {
        let is_walk = self.is_walk(&self.state);
        let new = self.fitness(tried.value);
        let Some(current) = self.state.chains().get(chain).map(|chain| self.fitness(chain.at.value)) else {
            return false;
        };
        let Some(BodyChains { chains, walk, .. }) = self.state.annealing() else { return false };
        if is_walk {
            walk.extend(tried.value);
        }
        let Some(chain) = chains.get_mut(chain) else { return false };
        let accepted = if is_walk {
            tried.value.is_some()
        } else {
            accepts(current, new, chain.standing.temperature, drawn)
        };
        chain.standing.note(accepted);
        if accepted {
            chain.at = tried.clone();
        }
        accepted
    }

    /// Whether designs are those of the random walk before the annealing.
    pub(super) fn is_walk(&self, state: &State) -> bool {
        let walk = self.rules.search.annealing().and_then(|annealing| annealing.walk);
        walk.is_some() && state.course.deviation.is_none()
    }

    fn plan<'p>(&'p self, schedule: &'p Schedule, chain: usize) -> Plan<'p> {
        let state = &self.state;
        let (derivation, stand) = match state.chains().get(chain) {
            Some(one) => (&one.at.derivation, Stand::Chain(chain, &one.standing)),
            None => (&state.first.derivation, Stand::Bodies),
        };
        Plan { rules: self.rules, derivation, schedule, course: &state.course, stand, around: self.around() }
    }
}
