//! Annealing of curves, by one chain or several that may change places.

use grammar_lang::ir::Schedule;

use super::super::schedule::{Course, Iteration, Plan, Stand, Standing, deviation, exchange, neighbours};
use super::super::state::{Chain, Chains, Tuning};
use super::super::{Failure, accepts};
use super::forecast::{Guess, Outlook};
use super::{Pace, Tuner, best};
use crate::drive::Parameters;

/// Chains that begin with curves whose fitness is known.
pub(super) fn chains(starts: Vec<Parameters>, fitness: Vec<Option<f64>>, course: Course) -> Chains {
    let chain = |(current, fitness)| Chain { current, fitness, standing: Standing::default(), number: 0 };
    let chains = starts.into_iter().zip(fitness).map(chain).collect();
    Chains { course, iteration: None, chains, turn: 0, walk: (Vec::new(), 0) }
}

/// A move that may come to pass.
struct Candidate {
    parameters: Parameters,
    /// The random number that decides on it.
    drawn: f64,
    /// Its fitness where that is known already; none inside where it has no value.
    fitness: Option<Option<f64>>,
}

/// Iterations that are to come, as far as can be foreseen: their numbers and temperatures, and how many moves
/// there are from now on until each of them ends.
struct Horizon(Vec<(usize, f64, usize)>);

impl Tuner<'_> {
    /// Goes on with the annealing by a batch of evaluations.
    pub(super) fn anneal(
        &mut self,
        schedule: &Schedule,
        tuning: &mut Tuning,
        chains: &mut Chains,
        spent: &mut u64,
    ) -> Result<Pace, Failure> {
        if let Some(end) = self.bounds.exhausted(*spent) {
            return Ok(Pace::Cut(end));
        }
        if let Some(walk) = schedule.walk
            && chains.course.deviation.is_none()
        {
            return self.walk(walk, tuning, chains, spent);
        }
        let Some(iteration) = (match chains.iteration {
            Some(iteration) => Some(iteration),
            None => self.begin_iteration(schedule, chains)?,
        }) else {
            return Ok(Pace::Done);
        };
        chains.iteration = Some(iteration);
        if iteration.made < iteration.moves && !self.moves(schedule, tuning, chains, spent)? {
            return self.stopped();
        }
        if chains.iteration.is_some_and(|iteration| iteration.made >= iteration.moves) {
            return self.end_iteration(schedule, tuning, chains);
        }
        Ok(Pace::More)
    }

    fn begin_iteration(
        &self,
        schedule: &Schedule,
        chains: &mut Chains,
    ) -> Result<Option<Iteration>, Failure> {
        let Chains { course, chains, .. } = chains;
        let mut iteration = None;
        for (number, chain) in chains.iter_mut().enumerate() {
            let plan = self.plan(schedule, course, Stand::Chain(number, &chain.standing));
            if number == 0 {
                iteration = plan.begin()?;
            }
            let temperature = plan.temperature()?;
            chain.standing.temperature = temperature;
        }
        Ok(iteration)
    }

    fn end_iteration(
        &self,
        schedule: &Schedule,
        tuning: &Tuning,
        chains: &mut Chains,
    ) -> Result<Pace, Failure> {
        chains.iteration = None;
        chains.course.complete(best(tuning));
        let Chains { course, chains, .. } = chains;
        chains.iter_mut().for_each(|chain| chain.standing.complete());
        let mut is_over = true;
        for (number, chain) in chains.iter().enumerate() {
            is_over &= self.plan(schedule, course, Stand::Chain(number, &chain.standing)).stops()?;
        }
        if is_over {
            return Ok(Pace::Done);
        }
        if chains.len() > 1
            && self.plan(schedule, course, Stand::Chain(0, &chains[0].standing)).exchanges()?
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
        Ok(Pace::More)
    }

    fn plan<'p>(&'p self, schedule: &'p Schedule, course: &'p Course, stand: Stand<'p>) -> Plan<'p> {
        Plan { rules: self.rules, derivation: &self.derivation, schedule, course, stand }
    }

    /// Goes on with the random walk: points drawn evenly, as the steps of a walk depend on the
    /// temperature that is to be found. A deviation of zero anneals without heat.
    fn walk(
        &mut self,
        walk: usize,
        tuning: &mut Tuning,
        chains: &mut Chains,
        spent: &mut u64,
    ) -> Result<Pace, Failure> {
        let (threads, lanes) = self.evaluator.room();
        let from = chains.walk.1;
        let to = walk.min(from + threads * lanes);
        let points: Vec<Parameters> = (from..to)
            .map(|number| self.evaluator.drive.draw(&mut self.stream(&format!("walk {number}"))))
            .collect();
        let Some(values) = self.evaluator.evaluate(self.bounds.stop, &points) else { return self.stopped() };
        for (point, evaluated) in points.iter().zip(values) {
            if let Some(end) = self.bounds.exhausted(*spent) {
                return Ok(Pace::Cut(end));
            }
            let known = evaluated.value.as_ref().ok().copied();
            let Some(sound) = self.count(tuning, point, evaluated, spent)? else { return self.stopped() };
            chains.walk.0.extend(known.filter(|_| sound));
            chains.walk.1 += 1;
        }
        if chains.walk.1 >= walk {
            chains.course.deviation = Some(deviation(&chains.walk.0));
            chains.walk.0.clear();
        }
        Ok(Pace::More)
    }

    /// The futures of a chain that are worth trying, and their candidates.
    fn futures(
        &self,
        schedule: &Schedule,
        tuning: &Tuning,
        state: &Chains,
        number: usize,
    ) -> Result<(Vec<Guess>, Vec<Candidate>), Failure> {
        let chain = &state.chains[number];
        let horizon = self.horizon(schedule, tuning, state, number);
        let mut candidates: Vec<Candidate> = Vec::new();
        let guesses = self.forecast.likeliest(state.chains.len(), |depth, from| {
            let Some((iteration, temperature)) = horizon.at(depth) else { return Ok(None) };
            let made = chain.number + depth as u64;
            let stream = if number == 0 { format!("{made}") } else { format!("{number}:{made}") };
            let mut random = self.stream(&stream);
            let drawn = random.unit();
            let (start, fitness) = match from {
                Some(from) => (&candidates[from].parameters, candidates[from].fitness),
                None => (&chain.current, Some(chain.fitness)),
            };
            let parameters = match self.evaluator.drive.mutate(start, temperature, iteration, &mut random) {
                Ok(parameters) => parameters,
                // Of a later move it is not known that it comes to pass.
                Err(_) if !candidates.is_empty() => return Ok(None),
                Err(error) => return Err(Failure::from(error)),
            };
            let is_same = parameters == *start;
            let known = self.evaluator.known(&parameters);
            let known = known.map(|value| value.ok().map(|value| self.fitness(value)));
            let known = if is_same { fitness } else { known };
            let least = if temperature > 0.0 { temperature * libm::log(drawn) } else { 0.0 };
            let acceptance = match (fitness, known) {
                (_, Some(None)) => 0.0,
                (Some(before), Some(Some(new))) => {
                    let before = before.unwrap_or(f64::NEG_INFINITY);
                    f64::from(u8::from(accepts(before, new, temperature, drawn)))
                }
                _ if is_same => 1.0,
                _ => self.forecast.chance(number, least),
            };
            let is_free = known.is_some() || candidates.iter().any(|other| other.parameters == parameters);
            candidates.push(Candidate { parameters, drawn, fitness: known });
            Ok(Some(Outlook { acceptance, is_free }))
        })?;
        Ok((guesses, candidates))
    }

    /// How the schedule of a chain is expected to go on: as if nothing better were found. What
    /// is simulated for iterations to come is remembered, if they come so.
    fn horizon(&self, schedule: &Schedule, tuning: &Tuning, state: &Chains, number: usize) -> Horizon {
        let Chains { course, iteration: Some(now), chains, turn, .. } = state else {
            return Horizon(Vec::new());
        };
        let mut standing = chains[number].standing.clone();
        // Those before the chain whose turn it is have made their move.
        let mut moves = now.left() - usize::from(number < *turn);
        let mut horizon = vec![(course.iteration, standing.temperature, moves)];
        // Who changes places stands elsewhere afterwards.
        let is_alone = chains.len() == 1 || schedule.exchange.is_none();
        let mut course = course.clone();
        while is_alone && moves < 2 * self.forecast.room(chains.len()) {
            standing.complete();
            course.complete(best(tuning));
            let plan = self.plan(schedule, &course, Stand::Chain(number, &standing));
            if plan.stops().unwrap_or(true) {
                break;
            }
            let (Ok(Some(next)), Ok(temperature)) = (plan.begin(), plan.temperature()) else { break };
            if next.moves == 0 {
                break;
            }
            standing.temperature = temperature;
            moves += next.moves;
            horizon.push((course.iteration, temperature, moves));
        }
        Horizon(horizon)
    }

    /// Makes moves as far as a batch of evaluations reaches, the chains in turn; whether it was not stopped.
    fn moves(
        &mut self,
        schedule: &Schedule,
        tuning: &mut Tuning,
        state: &mut Chains,
        spent: &mut u64,
    ) -> Result<bool, Failure> {
        let (mut guesses, mut candidates) = (Vec::new(), Vec::new());
        for number in 0..state.chains.len() {
            let (some, their) = self.futures(schedule, tuning, state, number)?;
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
                let is_known = guess.from.is_none() && self.bounds.gives_up && guess.depth < iteration.left();
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
            let (chain, Candidate { parameters, drawn, .. }) = (&mut chains[*turn], &candidates[*turn][now]);
            let evaluated = values[*turn][now].clone();
            let new = evaluated.value.as_ref().map_or(f64::NEG_INFINITY, |v| self.fitness(*v));
            let sound = if evaluated.ceiling < needed(chain, *drawn) {
                // It could not come to enough, whether it was simulated to its end or not, and whatever
                // would have become of it then.
                *spent += 1;
                tuning.tally.hopeless += 1;
                false
            } else {
                let Some(sound) = self.count(tuning, parameters, evaluated, spent)? else { return Ok(false) };
                sound
            };
            chain.number += 1;
            let fitness = chain.fitness.unwrap_or(f64::NEG_INFINITY);
            let accepted = sound && accepts(fitness, new, chain.standing.temperature, *drawn);
            self.forecast.learn(*turn, if sound { new - fitness } else { f64::NEG_INFINITY });
            chain.standing.note(accepted);
            if accepted {
                (chain.current, chain.fitness) = (parameters.clone(), Some(new));
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

impl Horizon {
    /// The number and the temperature of the iteration in which a move is made that has so many before it.
    fn at(&self, depth: usize) -> Option<(usize, f64)> {
        let found = self.0.iter().find(|(_, _, end)| depth < *end);
        found.map(|(iteration, temperature, _)| (*iteration, *temperature))
    }
}

/// The fitness that a candidate needs to be accepted, a little less for rounding. It is never more than that
/// of the chain, so that no best is lost that is below it.
fn needed(chain: &Chain, drawn: f64) -> f64 {
    let Some(fitness) = chain.fitness else { return f64::NEG_INFINITY };
    let less =
        if chain.standing.temperature > 0.0 { chain.standing.temperature * libm::log(drawn) } else { 0.0 };
    fitness + less - 1e-9 * (1.0 + fitness.abs())
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
