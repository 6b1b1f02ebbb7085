//! Which bodies are likely to come, whatever becomes of the one at hand.

use std::sync::Arc;

use grammar_lang::ir::Selection;

use super::super::gains::least_gain;
use super::super::state::{State, Trial, Tuned};
use super::super::tally::Tally;
use super::super::{Failure, Unkept, accepts};
use super::ahead::{Found, Order};
use super::{Best, Bodies, Observer, Row};
use crate::derive::Derivation;

/// Bodies to have in store for each helper: it goes on by itself while the search is at a batch of evaluations.
const STORE: usize = 3;
/// So many bodies are looked at for each that is wanted.
const LOOKS: usize = 8;
/// What comes less often than this is not worth a thought.
const LEAST: f64 = 0.02;
/// How likely a body is no new elite of an archive, and not kept in a population or on a front.
const NOT_KEPT: f64 = 0.7;
/// So many moves that can do nothing are followed.
const IDLE: usize = 50;

/// Sees nothing: what is supposed is told to nobody.
struct Nobody;

impl Observer for Nobody {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {}
    fn moved(&mut self, _: &Row) -> Result<(), Unkept> {
        Ok(())
    }
    fn improved(&mut self, _: &Best) -> Result<(), Unkept> {
        Ok(())
    }
}

impl<'a> Bodies<'a> {
    /// Lets the helpers know what is worth tuning, if anything has changed; `since` says what was known before, and
    /// whether it was sure that the body at hand will be accepted.
    pub(super) fn look_ahead(&self, since: &mut Option<(u64, bool)>) {
        let Some(ahead) = self.ahead.filter(|ahead| ahead.helpers() > 0) else { return };
        let sure = self.state.trial.as_ref().is_some_and(|trial| self.is_sure(&self.state, trial));
        let now = Some((ahead.changes(), sure));
        if *since == now {
            return;
        }
        *since = now;
        ahead.want(self.state.moves, self.prospects(STORE * ahead.helpers()));
    }

    /// The likeliest bodies to come, at most so many.
    fn prospects(&self, most: usize) -> Vec<Order> {
        let mut orders: Vec<Order> = Vec::new();
        let side_by_side = self.rules.search.selection().map_or(1, Selection::side_by_side);
        // How likely a state is, the state, and the moves whose outcome it supposes.
        let mut open = vec![(1.0, self.state.clone(), Vec::new())];
        for _ in 0..LOOKS * most {
            type Open = (f64, State, Vec<usize>);
            let likelier =
                |(a, x): &(usize, &Open), (b, y): &(usize, &Open)| x.0.total_cmp(&y.0).then(b.cmp(a));
            let Some((place, _)) = open.iter().enumerate().max_by(likelier) else { break };
            let (chance, state, mut supposed) = open.remove(place);
            let Some(trial) = &state.trial else { continue };
            let Ok(known) = self.known() else { break };
            let order = Order::of(state.moves, trial, known);
            let is_at_hand = state.moves == self.state.moves;
            let found = self.ahead.and_then(|ahead| ahead.found(&order.key)).filter(|_| !is_at_hand);
            let is_done = found.is_some();
            let outcomes = match found {
                Some(found) => vec![(1.0, found)],
                None if self.is_unheated() && state.moves > 0 => {
                    supposed.push(state.moves);
                    // The next move begins with what this one, or one before it, left.
                    let is_known = !supposed.contains(&(state.moves + 1).saturating_sub(side_by_side));
                    vec![(if is_known { 1.0 } else { NOT_KEPT }, None)]
                }
                None => self.outcomes(&state, trial, is_at_hand),
            };
            let is_new = orders.iter().all(|other| other.key != order.key);
            if !is_at_hand && !is_done && is_new {
                orders.push(order);
                if orders.len() == most {
                    break;
                }
            }
            for (share, found) in outcomes {
                if chance * share >= LEAST
                    && let Some(next) = self.supposed(state.clone(), found)
                    && self.is_affordable(&next)
                {
                    open.push((chance * share, next, supposed.clone()));
                }
            }
        }
        orders
    }

    /// Whether bodies are kept by their values, and no temperature decides.
    fn is_unheated(&self) -> bool {
        self.rules.search.annealing().is_none()
    }

    /// Whether the evaluations are likely to last until the body that a state tries.
    fn is_affordable(&self, state: &State) -> bool {
        let Some(most) = self.bounds.max_evaluations else { return true };
        let before = state.moves.saturating_sub(self.state.moves) as u64;
        self.costs.begun + before * self.costs.typical() < most
    }

    /// What may become of the body that a state tries, and how likely that is, where a temperature decides.
    fn outcomes(&self, state: &State, trial: &Trial<Arc<Derivation>>, is_at_hand: bool) -> Vec<(f64, Found)> {
        if state.moves == 0 {
            return vec![(1.0, None)];
        }
        if self.is_walk(state) {
            return vec![(1.0, Some((Vec::new(), 0.0)))];
        }
        let (least, current, now) = self.standing(state, trial);
        let sure = is_at_hand && self.is_sure(state, trial);
        let chance = if sure { 1.0 } else { self.gains.chance(trial.origin.chain, least - current) };
        // As if it came to a little more than it needs, or to what it has come to so far.
        let enough = (least + 1e-6 * (1.0 + least.abs())).max(f64::MIN);
        let fitness = if is_at_hand { now.max(enough) } else { enough };
        let value = self.rules.objective.direction.fitness(fitness);
        let is_warm = self.rules.search.is_warm();
        let accepted = (chance, Some((Vec::new(), value)));
        let refused = (1.0 - chance, None);
        // What inherits curves is not known before they are.
        let outcomes = if is_warm { vec![refused] } else { vec![accepted, refused] };
        outcomes.into_iter().filter(|(chance, _)| *chance >= LEAST).collect()
    }

    /// What the body that a state tries needs to be accepted, what its chain has, and what it has come to so far.
    fn standing(&self, state: &State, trial: &Trial<Arc<Derivation>>) -> (f64, f64, f64) {
        let Some(chain) = state.chains().get(trial.origin.chain) else {
            return (f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        };
        let current = self.fitness(chain.at.value);
        let (_, now) = trial.body.progress();
        (current + least_gain(chain.standing.temperature, trial.drawn), current, self.fitness(now))
    }

    /// Whether the body at hand will be accepted whatever comes: its best is good enough already.
    fn is_sure(&self, state: &State, trial: &Trial<Arc<Derivation>>) -> bool {
        let Some(chain) = state.chains().get(trial.origin.chain).filter(|_| self.rules.tasks.len() == 1)
        else {
            return false;
        };
        let (_, current, now) = self.standing(state, trial);
        now.is_finite() && accepts(current, now, chain.standing.temperature, trial.drawn)
    }

    /// The state at the next body, if this is what is found for the one at hand.
    fn supposed(&self, state: State, found: Found) -> Option<State> {
        let mut nobody = Nobody;
        let mut search = Bodies {
            rules: self.rules,
            engine: self.engine,
            ahead: None,
            seed: self.seed,
            bounds: self.bounds,
            observer: &mut nobody,
            state,
            gains: self.gains.clone(),
            costs: self.costs,
            unfinished: None,
        };
        let trial = search.state.trial.take()?;
        let judged: Result<(), Failure> =
            search.settle(trial, (found, Tuned::default()), Tally::default(), None, false);
        judged.ok()?;
        for _ in 0..IDLE {
            match search.next_move() {
                Ok(None) if search.state.trial.is_some() => return Some(search.state),
                Ok(None) => {}
                Ok(Some(_)) | Err(_) => return None,
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use grammar_lang::source::SourceMap;

    use super::super::{Costs, Crew, Engine, Gains};
    use super::*;
    use crate::loader::Files;
    use crate::search::{Bounds, Jobs, Limits, cache::Cache};
    use crate::simulate;

    #[test]
    fn the_next_body_is_among_the_likeliest() {
        let text = "variant quick of \"grammars/codesign.sgr\" {
            replace search nested_annealing
            set nested_annealing.curves.iterations = 2
            set nested_annealing.bodies.stop = false
            replace simulate hinge_model for 1 s
            replace maximize travel - fall in cm
        }";
        let mut sources = SourceMap::default();
        let entry = sources.add(
            concat!(env!("CARGO_MANIFEST_DIR"), "/quick.sgr"),
            format!("use std.models {{ hinge_model }}\nuse std.objectives {{ travel, fall }}\nuse std.search {{ nested_annealing }}\n{text}"),
        );
        let rules = grammar_lang::compile(&Files, &mut sources, entry, &[], None).ruleset.unwrap();
        let limits = Limits {
            seed: 5,
            jobs: Jobs::new(2),
            max_evaluations: Some(600),
            lanes: None,
            gives_up: true,
            deadline: None,
        };
        let (crew, cache, flag) = (Crew::alone(), Cache::default(), AtomicBool::new(false));
        let (mut expected, mut hits, mut bodies): (Vec<Order>, usize, usize) = (Vec::new(), 0, 0);
        let mut nobody = Nobody;
        let mut search = Bodies {
            rules: &rules,
            engine: Engine { model: simulate::model("articulated").unwrap(), crew: &crew, cache: &cache },
            // Nobody helps: what is wanted is looked at only.
            ahead: None,
            seed: limits.seed,
            bounds: Bounds::new(&limits, &flag),
            observer: &mut nobody,
            state: State::begin(Derivation::begin(&rules)),
            gains: Gains::NONE,
            costs: Costs::default(),
            unfinished: None,
        };
        loop {
            let end = if let Some(trial) = &search.state.trial {
                let own = Order::of(search.state.moves, trial, search.known().unwrap());
                bodies += 1;
                hits += usize::from(expected.iter().any(|order| order.key == own.key));
                expected = search.prospects(2);
                search.try_body().unwrap()
            } else {
                search.next_move().unwrap()
            };
            if end.is_some() {
                break;
            }
        }
        assert!(bodies > 15, "{bodies} bodies");
        // All but the first, some that come after a surprise, and those for which the evaluations do not last.
        assert!(4 * hits > 3 * bodies, "{hits} of {bodies} bodies were expected");
        assert!(hits < bodies, "the first cannot be");
    }
}
