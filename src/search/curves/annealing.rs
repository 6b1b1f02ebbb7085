//! Annealing of curves, by one chain or several that may change places.

use grammar_lang::ir::Schedule;

use super::super::gains::least_gain;
use super::super::schedule::{Course, Iteration, Plan, Stand, Standing, deviation, exchange, neighbours};
use super::super::state::{Chain, Chains, Tuning};
use super::super::{Failure, accepts};
use super::futures::{Annealed, Neighbour};
use super::judging::{Counted, When};
use super::{Progress, Tuner, best};
use crate::derive::Candidate;
use crate::drive::Parameters;

/// Chains that begin with curves whose fitness is known.
pub(super) fn chains(starts: Vec<Parameters>, fitness: Vec<Option<f64>>, course: Course) -> Chains {
    let chain = |(current, fitness)| Chain { current, fitness, standing: Standing::default(), number: 0 };
    let chains = starts.into_iter().zip(fitness).map(chain).collect();
    Chains { course, iteration: None, chains, turn: 0, walk: (Vec::new(), 0) }
}

impl Tuner<'_> {
    /// Goes on with the annealing by a batch of evaluations.
    pub(super) fn anneal(
        &mut self,
        how: Annealed<'_>,
        tuning: &mut Tuning,
        chains: &mut Chains,
        spent: &mut u64,
    ) -> Result<Progress, Failure> {
        if let Some(end) = self.bounds.exhausted(*spent) {
            return Ok(Progress::Cut(end));
        }
        if let Some(walk) = how.annealing.walk
            && chains.course.deviation.is_none()
        {
            return self.walk(walk, tuning, chains, spent);
        }
        self.spent = self.bounds.share(*spent);
        let Some(iteration) = (match chains.iteration {
            Some(iteration) => Some(iteration),
            None => self.begin_iteration(how, chains)?,
        }) else {
            let is_judged = self.judge_offered(tuning, spent, When::AtTheEnd)?;
            return if is_judged { Ok(Progress::Done) } else { self.stopped() };
        };
        chains.iteration = Some(iteration);
        if iteration.made < iteration.moves && !self.moves(how, tuning, chains, spent)? {
            return self.stopped();
        }
        if chains.iteration.is_some_and(|iteration| iteration.made >= iteration.moves) {
            if !self.judge_offered(tuning, spent, When::Underway)? {
                return self.stopped();
            }
            self.spent = self.bounds.share(*spent);
            // If judging is stopped, the iteration ends once more from here.
            let mut after = chains.clone();
            let progress = self.end_iteration(how, tuning, &mut after)?;
            if progress == Progress::Done && !self.judge_offered(tuning, spent, When::AtTheEnd)? {
                return self.stopped();
            }
            *chains = after;
            return Ok(progress);
        }
        Ok(Progress::More)
    }

    fn begin_iteration(&self, how: Annealed<'_>, chains: &mut Chains) -> Result<Option<Iteration>, Failure> {
        let Chains { course, chains, .. } = chains;
        let mut iteration = None;
        for (number, chain) in chains.iter_mut().enumerate() {
            let plan = self.plan(how.schedule, course, Stand::Chain(number, &chain.standing));
            if number == 0 {
                iteration = plan.begin()?;
            }
            let temperature = plan.temperature(how.annealing)?;
            chain.standing.temperature = temperature;
        }
        Ok(iteration)
    }

    fn end_iteration(
        &self,
        how: Annealed<'_>,
        tuning: &Tuning,
        chains: &mut Chains,
    ) -> Result<Progress, Failure> {
        chains.iteration = None;
        chains.course.complete(best(tuning));
        let Chains { course, chains, .. } = chains;
        chains.iter_mut().for_each(|chain| chain.standing.complete());
        let mut is_over = true;
        for (number, chain) in chains.iter().enumerate() {
            is_over &= self.plan(how.schedule, course, Stand::Chain(number, &chain.standing)).stops()?;
        }
        if is_over {
            return Ok(Progress::Done);
        }
        if chains.len() > 1
            && self
                .plan(how.schedule, course, Stand::Chain(0, &chains[0].standing))
                .exchanges(how.annealing)?
        {
            let mut random = self.stream(&format!("exchange {}", course.iteration));
            for first in neighbours(chains.len(), course.iteration) {
                let (before, after) = chains.split_at_mut(first + 1);
                let (one, other) = (&mut before[first], &mut after[0]);
                let place = |c: &Chain| (c.standing.temperature, c.fitness.unwrap_or(f64::NEG_INFINITY));
                if exchange(place(one), place(other), random.unit()) {
                    std::mem::swap(&mut one.current, &mut other.current);
                    std::mem::swap(&mut one.fitness, &mut other.fitness);
                }
            }
        }
        Ok(Progress::More)
    }

    pub(super) fn plan<'p>(
        &'p self,
        schedule: &'p Schedule,
        course: &'p Course,
        stand: Stand<'p>,
    ) -> Plan<'p> {
        let Candidate { rules, derivation, .. } = self.candidate();
        Plan { rules, derivation, schedule, course, stand, around: self.around() }
    }

    /// Goes on with the random walk: points drawn evenly, as the steps of a walk depend on the
    /// temperature that is to be found. A deviation of zero anneals without heat.
    fn walk(
        &mut self,
        walk: usize,
        tuning: &mut Tuning,
        chains: &mut Chains,
        spent: &mut u64,
    ) -> Result<Progress, Failure> {
        let (threads, lanes) = self.evaluator.room();
        let from = chains.walk.1;
        let to = walk.min(from + threads * lanes);
        let points: Vec<Parameters> = (from..to)
            .map(|number| self.evaluator.drive.draw(&mut self.stream(&format!("walk {number}"))))
            .collect();
        let Some(values) = self.evaluator.evaluate(self.bounds.stop, &points) else { return self.stopped() };
        for (point, evaluated) in points.iter().zip(values) {
            if let Some(end) = self.bounds.exhausted(*spent) {
                return Ok(Progress::Cut(end));
            }
            match self.count(tuning, point, evaluated, spent)? {
                Counted::Stopped => return self.stopped(),
                counted => chains.walk.0.extend(counted.fitness()),
            }
            chains.walk.1 += 1;
        }
        if chains.walk.1 >= walk {
            chains.course.deviation = Some(deviation(&chains.walk.0));
            chains.walk.0.clear();
        }
        Ok(Progress::More)
    }

    /// Makes moves as far as a batch of evaluations reaches, the chains in turn; whether it was not stopped.
    fn moves(
        &mut self,
        how: Annealed<'_>,
        tuning: &mut Tuning,
        state: &mut Chains,
        spent: &mut u64,
    ) -> Result<bool, Failure> {
        let (mut guesses, mut candidates) = (Vec::new(), Vec::new());
        for number in 0..state.chains.len() {
            let (some, their) = self.futures(how, tuning, state, number)?;
            guesses.push(some);
            candidates.push(their);
        }
        self.forecast.cut(&mut guesses);
        let Chains { iteration: Some(iteration), chains, turn, .. } = state else { return Ok(true) };
        let mut all = Vec::new();
        for ((chain, guesses), candidates) in chains.iter().zip(&guesses).zip(&mut candidates) {
            candidates.truncate(guesses.len());
            for (candidate, guess) in candidates.iter().zip(guesses) {
                // What comes after an accepted move is measured by what that will be worth, and what comes
                // after this iteration by another temperature.
                let is_known = guess.from.is_none()
                    && self.bounds.gives_up
                    && self.bounds_the_rest()
                    && guess.depth < iteration.left();
                let needed = if is_known { needed(chain, candidate.drawn) } else { f64::NEG_INFINITY };
                all.push((candidate.parameters.clone(), needed));
            }
        }
        let Some(values) = self.evaluator.evaluate_above(self.bounds.stop, &all) else { return Ok(false) };
        let mut values = values.into_iter();
        let values: Vec<Vec<_>> =
            guesses.iter().map(|guesses| values.by_ref().take(guesses.len()).collect()).collect();
        let mut next = vec![Some(0); chains.len()];
        while iteration.made < iteration.moves {
            let Some(now) = next[*turn] else { break };
            if self.bounds.exhausted(*spent).is_some() {
                break;
            }
            let (chain, Neighbour { parameters, drawn, .. }) = (&mut chains[*turn], &candidates[*turn][now]);
            let evaluated = values[*turn][now].clone();
            let each = evaluated.each.clone();
            let counted = if self.bounds_the_rest() && evaluated.ceiling < needed(chain, *drawn) {
                // It could not come to enough, whether it was simulated to its end or not, and whatever
                // would have become of it then.
                *spent += 1;
                tuning.tally.hopeless += 1;
                Counted::Unsound
            } else if self.excludes(&evaluated, needed(chain, *drawn)) {
                *spent += 1;
                Counted::Unsound
            } else {
                self.count(tuning, parameters, evaluated, spent)?
            };
            if counted == Counted::Stopped {
                return Ok(false);
            }
            let new = counted.fitness();
            chain.number += 1;
            let fitness = chain.fitness.unwrap_or(f64::NEG_INFINITY);
            let accepted = new.is_some_and(|new| accepts(fitness, new, chain.standing.temperature, *drawn));
            self.forecast.gains.learn(*turn, new.map_or(f64::NEG_INFINITY, |new| new - fitness));
            chain.standing.note(accepted);
            if let Some(new) = new.filter(|_| accepted) {
                (chain.current, chain.fitness) = (parameters.clone(), Some(new));
                self.offer(tuning, parameters, new, &each);
            }
            let guess = &guesses[*turn][now];
            next[*turn] = if accepted { guess.accepted } else { guess.refused };
            *turn += 1;
            if *turn == chains.len() {
                *turn = 0;
                iteration.made += 1;
            }
        }
        Ok(true)
    }
}

/// The fitness that a candidate needs to be accepted, a little less for rounding. It is never more than that
/// of the chain, so that no best is lost that is below it.
fn needed(chain: &Chain, drawn: f64) -> f64 {
    let Some(fitness) = chain.fitness else { return f64::NEG_INFINITY };
    fitness + least_gain(chain.standing.temperature, drawn) - 1e-9 * (1.0 + fitness.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_below_the_need_is_never_accepted() {
        for (fitness, temperature, drawn) in
            [(3.0, 2.0, 0.3), (-5.0, 9.0, 0.999), (10.0, 0.0, 0.5), (0.0, 0.1, 1e-300), (80.0, 9.0, 0.0)]
        {
            let standing = Standing { temperature, ..Standing::default() };
            let chain = Chain { current: Vec::new(), fitness: Some(fitness), standing, number: 0 };
            let needed = needed(&chain, drawn);
            assert!(needed <= fitness);
            if needed.is_finite() {
                assert!(!accepts(fitness, needed - 1e-9, temperature, drawn));
                assert!(accepts(fitness, needed + 1e-6, temperature, drawn));
            }
        }
    }
}
