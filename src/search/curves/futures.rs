//! What the next moves of an annealing chain would be, in each way that it may go.

use super::super::gains::least_gain;
use super::super::schedule::Stand;
use super::super::state::{Chains, Tuning};
use super::super::{Failure, accepts};
use super::forecast::{Guess, Outlook};
use super::{Tuner, best};
use crate::drive::Parameters;
use grammar_lang::ir::{Annealing, Schedule};

/// An annealing, and how long it goes on.
#[derive(Clone, Copy)]
pub(super) struct Annealed<'a> {
    pub(super) schedule: &'a Schedule,
    pub(super) annealing: &'a Annealing,
}

/// A move that may come to pass.
pub(super) struct Neighbour {
    pub(super) parameters: Parameters,
    /// The random number that decides on it.
    pub(super) drawn: f64,
    /// Its fitness where that is known already; none inside where it has no value.
    fitness: Option<Option<f64>>,
}

/// Iterations that are to come, as far as can be foreseen: their numbers and temperatures, and how many moves
/// there are from now on until each of them ends.
struct Horizon(Vec<(usize, f64, usize)>);

impl Tuner<'_> {
    /// The futures of a chain that are worth trying, and their candidates.
    pub(super) fn futures(
        &self,
        how: Annealed<'_>,
        tuning: &Tuning,
        state: &Chains,
        number: usize,
    ) -> Result<(Vec<Guess>, Vec<Neighbour>), Failure> {
        let chain = &state.chains[number];
        let horizon = self.horizon(how, tuning, state, number);
        let mut candidates: Vec<Neighbour> = Vec::new();
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
            let known = self.foreseen(tuning, &parameters);
            let known = if is_same { fitness } else { known };
            let acceptance = match (fitness, known) {
                (_, Some(None)) => 0.0,
                (Some(before), Some(Some(new))) => {
                    let before = before.unwrap_or(f64::NEG_INFINITY);
                    f64::from(u8::from(accepts(before, new, temperature, drawn)))
                }
                _ if is_same => 1.0,
                _ => self.forecast.gains.chance(number, least_gain(temperature, drawn)),
            };
            let is_free = known.is_some() || candidates.iter().any(|other| other.parameters == parameters);
            candidates.push(Neighbour { parameters, drawn, fitness: known });
            Ok(Some(Outlook { acceptance, is_free }))
        })?;
        Ok((guesses, candidates))
    }

    /// How the schedule of a chain is expected to go on: as if nothing better were found. What
    /// is simulated for iterations to come is remembered, if they come so.
    fn horizon(&self, how: Annealed<'_>, tuning: &Tuning, state: &Chains, number: usize) -> Horizon {
        let Chains { course, iteration: Some(now), chains, turn, .. } = state else {
            return Horizon(Vec::new());
        };
        let mut standing = chains[number].standing.clone();
        // Those before the chain whose turn it is have made their move; with no other left, nothing is sure.
        let mut moves = now.left() - usize::from(number < *turn);
        let mut horizon = vec![(course.iteration, standing.temperature, moves)];
        // Who changes places stands elsewhere afterwards.
        let is_alone = chains.len() == 1 || how.annealing.exchange.is_none();
        let mut course = course.clone();
        while is_alone && moves > 0 && moves < 2 * self.forecast.room(chains.len()) {
            standing.complete();
            course.complete(best(tuning));
            let plan = self.plan(how.schedule, &course, Stand::Chain(number, &standing));
            if plan.stops().unwrap_or(true) {
                break;
            }
            let (Ok(Some(next)), Ok(temperature)) = (plan.begin(), plan.temperature(how.annealing)) else {
                break;
            };
            if next.moves == 0 {
                break;
            }
            standing.temperature = temperature;
            moves += next.moves;
            horizon.push((course.iteration, temperature, moves));
        }
        Horizon(horizon)
    }
}

impl Horizon {
    /// The number and the temperature of the iteration in which a move is made that has so many before it.
    fn at(&self, depth: usize) -> Option<(usize, f64)> {
        let found = self.0.iter().find(|(_, _, end)| depth < *end);
        found.map(|(iteration, temperature, _)| (*iteration, *temperature))
    }
}
