//! What becomes of an evaluation: whether its value counts, and whether it is a new best.
//!
//! Where the objective of a task runs over worlds, its value takes a motion in each. Most curves are simulated in the
//! nominal world only, and the search says which are judged in all ([`Judge`]). The best is always the best in all.

use grammar_lang::ir::{Direction, Judge, Objective};
use grammar_lang::units::quantity;

use super::super::body::Known;
use super::super::evaluated::Evaluated;
use super::super::evaluator::WorstCase;
use super::super::fidelity::Fidelity;
use super::super::state::{Offered, Tune, Tuning};
use super::super::tally::Missing;
use super::super::{Failure, NOTHING, keeps};
use super::{Tuner, best};
use crate::derive::Candidate;
use crate::drive::Parameters;
use crate::score;

/// For each world so many curves are tried before some are judged in all worlds: a quarter of the evaluations goes there
/// (`docs/experiments.md`).
const EACH: u64 = 3;
/// The same where a worst case is simulated only as far as it is needed: that costs less (how much has not been measured).
const EACH_IN_A_RACE: u64 = 1;

/// When the best of late is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum When {
    /// After an iteration.
    Underway,
    /// When the loop ends.
    AtTheEnd,
}

/// What curves come to: the value that the loop goes by, and each objective where a front is searched for.
#[derive(Clone, Copy)]
struct Nominal<'e> {
    value: f64,
    each: &'e [f64],
}

impl Nominal<'_> {
    /// The value as the task states its objective.
    fn own(self) -> f64 {
        self.each.first().copied().unwrap_or(self.value)
    }
}

/// What an evaluation came to for the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Counted {
    /// It was asked to stop before that was known: nothing is counted.
    Stopped,
    /// It has no value, or one that it loses in a finer simulation.
    Unsound,
    /// The value that the loop goes on with, where more is better.
    Sound(f64),
}

impl Counted {
    /// The value, if there is one.
    pub(super) fn fitness(self) -> Option<f64> {
        match self {
            Self::Sound(fitness) => Some(fitness),
            Self::Stopped | Self::Unsound => None,
        }
    }
}

impl Tuner<'_> {
    /// Which curves are judged in all worlds; none where the value is that of the nominal one.
    pub(super) fn judge(&self) -> Option<Judge> {
        self.evaluator.worlds()?;
        // Where nothing is tuned, each body has one motion.
        Some(self.looped().map_or(Judge::Promising, grammar_lang::ir::CurveLoop::judge))
    }

    /// Whether a value in the nominal world says that the value in all is no better.
    pub(super) fn bounds_the_rest(&self) -> bool {
        self.judge() != Some(Judge::Every) || self.task().is_worst_case()
    }

    /// Whether curves need not be judged in all worlds, as in the nominal one already they are no use.
    pub(super) fn excludes(&self, evaluated: &Evaluated, needed: f64) -> bool {
        let is_below = evaluated.value.as_ref().is_ok_and(|value| self.fitness(*value) < needed);
        is_below && self.judge() == Some(Judge::Every) && self.task().is_worst_case()
    }

    /// Counts an evaluation and keeps it if it is the best. A best must hold its
    /// value at half the step; what does not is no candidate at all, or the
    /// search would go and live on an error of the simulation. Where nothing is tuned, it must only if it is the best of
    /// the run, too: others are steps on a way.
    pub(super) fn count(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        evaluated: Evaluated,
        spent: &mut u64,
    ) -> Result<Counted, Failure> {
        self.count_as(self.judge(), tuning, candidate, evaluated, spent)
    }

    /// Counts the curves that the user gave, which are the first of their body. They are judged in all worlds at once: what is
    /// varied is kept only if it is better there.
    pub(super) fn count_given(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        evaluated: Evaluated,
        spent: &mut u64,
    ) -> Result<Counted, Failure> {
        let nominal = evaluated.value.as_ref().ok().copied();
        let judge = self.judge().map(|_| Judge::Every);
        let counted = self.count_as(judge, tuning, candidate, evaluated, spent)?;
        if let (Some(Judge::Best), Counted::Sound(_), Some(nominal)) = (self.judge(), counted, nominal) {
            // The loop goes on with values in the nominal world.
            let fitness = self.fitness(nominal);
            tuning.highest = Some(fitness);
            return Ok(Counted::Sound(fitness));
        }
        Ok(counted)
    }

    fn count_as(
        &mut self,
        judge: Option<Judge>,
        tuning: &mut Tuning,
        candidate: &Parameters,
        evaluated: Evaluated,
        spent: &mut u64,
    ) -> Result<Counted, Failure> {
        let value = match &evaluated.value {
            Ok(value) => *value,
            // What fails at the very first is a mistake in the grammar.
            Err(Missing::Expression(error)) if *spent == 0 => return Err(error.clone().into()),
            Err(reason) => {
                *spent += 1;
                tuning.tally.count(reason.clone());
                return Ok(Counted::Unsound);
            }
        };
        let (before, unjudged) = (*spent, tuning.unjudged);
        let is_no_better = |fitness: f64| best(tuning).is_some_and(|best| fitness <= self.fitness(best));
        let counted = match judge {
            None => self.count_nominal(tuning, candidate, evaluated, value, spent)?,
            Some(Judge::Promising) if is_no_better(self.fitness(value)) => {
                Counted::Sound(self.fitness(value))
            }
            Some(Judge::Promising | Judge::Every) => {
                self.judged(tuning, candidate, Nominal { value, each: &evaluated.each }, spent)?
            }
            Some(Judge::Best) => {
                tuning.unjudged += 1;
                self.count_highest(tuning, candidate, Nominal { value, each: &evaluated.each }, spent)?
            }
        };
        if counted == Counted::Stopped {
            *spent = before;
            tuning.unjudged = unjudged;
        } else {
            *spent += 1;
        }
        Ok(counted)
    }

    /// Where the value is that of the nominal world.
    fn count_nominal(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        evaluated: Evaluated,
        value: f64,
        spent: &mut u64,
    ) -> Result<Counted, Failure> {
        let fitness = self.fitness(value);
        if best(tuning).is_some_and(|best| fitness <= self.fitness(best)) {
            return Ok(Counted::Sound(fitness));
        }
        let mut half_step = None;
        let nominal = Nominal { value, each: &evaluated.each };
        if self.can_lose(candidate, nominal) && self.is_of_use(nominal) {
            match self.kept(tuning, candidate, nominal, spent) {
                Ok(half) => half_step = Some(half),
                Err(counted) => return Ok(counted),
            }
        }
        tuning.found = Some(Tune {
            parameters: candidate.clone(),
            value,
            each: evaluated.each,
            nominal: None,
            at_most_in: None,
            half_step,
            observed: evaluated.observed.unwrap_or_default(),
        });
        Ok(Counted::Sound(fitness))
    }

    /// Where only the best of each iteration is judged in all worlds: the highest so far must keep its value, or the
    /// search would go where the simulation is wrong.
    fn count_highest(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        nominal: Nominal<'_>,
        spent: &mut u64,
    ) -> Result<Counted, Failure> {
        let fitness = self.fitness(nominal.value);
        if tuning.highest.is_none_or(|highest| fitness > highest) {
            if self.can_lose(candidate, nominal)
                && !self.races()
                && fitness > self.known.kept
                && !self.is_covered(nominal)
                && let Err(counted) = self.kept(tuning, candidate, nominal, spent)
            {
                return Ok(counted);
            }
            tuning.highest = Some(fitness);
        }
        Ok(Counted::Sound(fitness))
    }

    /// Remembers curves that may be the best since some were judged in all worlds.
    pub(super) fn offer(&self, tuning: &mut Tuning, candidate: &Parameters, fitness: f64, each: &[f64]) {
        let is_better = |known: &Offered| fitness > known.fitness;
        if self.judge() == Some(Judge::Best) && tuning.offered.as_ref().is_none_or(is_better) {
            let (parameters, each) = (candidate.clone(), each.to_vec());
            tuning.offered = Some(Offered { parameters, fitness, each });
        }
    }

    /// Judges the best of late in all worlds, where the search says so: after an iteration, but not before enough curves
    /// were tried since the last time, and at the end. Whether it was not stopped.
    pub(super) fn judge_offered(
        &mut self,
        tuning: &mut Tuning,
        spent: &mut u64,
        when: When,
    ) -> Result<bool, Failure> {
        let each = if self.races() { EACH_IN_A_RACE } else { EACH };
        let enough = each * self.evaluator.worlds().unwrap_or(0);
        if when == When::Underway && tuning.unjudged < enough {
            return Ok(true);
        }
        let Some(offered) = tuning.offered.take() else { return Ok(true) };
        let fitness = offered.fitness;
        // What is no better here is hardly better in all worlds together, and of a worst case it cannot be.
        if best(tuning).is_some_and(|best| fitness <= self.fitness(best)) {
            return Ok(true);
        }
        if self.task().is_worst_case() && fitness <= self.known.kept {
            return Ok(true);
        }
        let unjudged = std::mem::take(&mut tuning.unjudged);
        let value = self.task().objective.direction.fitness(fitness);
        let before = *spent;
        let nominal = Nominal { value, each: &offered.each };
        if self.judged(tuning, &offered.parameters, nominal, spent)? == Counted::Stopped {
            *spent = before;
            (tuning.offered, tuning.unjudged) = (Some(offered), unjudged);
            return Ok(false);
        }
        Ok(true)
    }

    /// What curves come to in all worlds. Where that need not be known, what they come to at most, and in how many worlds that is
    /// known. Otherwise what is counted: it was stopped.
    fn everywhere(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        nominal: f64,
        spent: &mut u64,
    ) -> Result<(Evaluated, Option<u64>), Counted> {
        let stop = self.bounds.stop;
        if !self.races() {
            let evaluated =
                self.evaluator.in_worlds(stop, candidate, Fidelity::Model).ok_or(Counted::Stopped)?;
            *spent += self.evaluator.worlds().unwrap_or(0);
            return Ok((evaluated, None));
        }
        // Only what may be the best of the run has to be known.
        let needed = self.known.best;
        if !self.is_actuated() && self.fitness(nominal) <= needed {
            return Ok((Evaluated::of(Ok(nominal)), Some(1)));
        }
        let order = if tuning.hardest.is_empty() { &self.known.hardest } else { &tuning.hardest };
        let worst = self.evaluator.worst_case(stop, candidate, (nominal, needed), order);
        let (worst, simulated) = worst.ok_or(Counted::Stopped)?;
        *spent += simulated;
        match worst {
            WorstCase::AtMost { value, by } => {
                tuning.hardest = in_front(by, order);
                let value = Ok(self.task().objective.direction.fitness(value));
                let evaluated = Evaluated::of(value);
                // The nominal world is one of those that are known.
                Ok((evaluated, Some(simulated + 1)))
            }
            WorstCase::Known { evaluated, hardest } => {
                tuning.hardest = hardest;
                Ok((evaluated, None))
            }
        }
    }

    /// Judges curves in all worlds, and keeps them if they are the best there.
    fn judged(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        nominal: Nominal<'_>,
        spent: &mut u64,
    ) -> Result<Counted, Failure> {
        let is_first = *spent == 0;
        // What is of no use in the nominal world is hardly of more in all, and never where the objectives are worst cases.
        let (evaluated, at_most_in) = if self.is_covered(nominal) {
            (Evaluated { each: nominal.each.to_vec(), ..Evaluated::of(Ok(nominal.value)) }, Some(1))
        } else {
            match self.everywhere(tuning, candidate, nominal.value, spent) {
                Ok(found) => found,
                Err(counted) => return Ok(counted),
            }
        };
        let value = match evaluated.value {
            Ok(value) => value,
            Err(Missing::Expression(error)) if is_first => return Err(error.into()),
            Err(reason) => {
                tuning.tally.count(reason);
                return Ok(Counted::Unsound);
            }
        };
        let fitness = self.fitness(value);
        if best(tuning).is_some_and(|best| fitness <= self.fitness(best)) {
            return Ok(Counted::Sound(fitness));
        }
        let mut half_step = None;
        if self.can_lose(candidate, nominal) && self.is_of_use(Nominal { value, each: &evaluated.each }) {
            match self.kept(tuning, candidate, nominal, spent) {
                Ok(half) => half_step = Some(half),
                Err(counted) => return Ok(counted),
            }
        }
        // What is to be the best of the run keeps its value in all worlds, too.
        let found = Nominal { value, each: &evaluated.each };
        let is_best = fitness > self.known.best && self.can_lose(candidate, found) && !self.is_covered(found);
        if is_best && let Err(counted) = self.kept_in_worlds(tuning, candidate, found, spent) {
            return Ok(counted);
        }
        tuning.found = Some(Tune {
            parameters: candidate.clone(),
            value,
            each: evaluated.each,
            nominal: Some(nominal.own()),
            at_most_in,
            half_step,
            observed: evaluated.observed.unwrap_or_default(),
        });
        Ok(Counted::Sound(fitness))
    }

    /// What a value of the nominal world is at half the step, if it is kept there as far as the search asks, and with rods
    /// where it asks for that.
    ///
    /// # Errors
    ///
    /// What the curves count as: they lose their value, or it was asked to stop before that was known.
    fn kept(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        nominal: Nominal<'_>,
        spent: &mut u64,
    ) -> Result<f64, Counted> {
        let stop = self.bounds.stop;
        let half = self.evaluator.closely(stop, candidate, Fidelity::HalfStep).ok_or(Counted::Stopped)?;
        *spent += 1;
        let is_kept = self.confirms(candidate, nominal, &half, Fidelity::HalfStep);
        let Some(value) = half.value.as_ref().ok().filter(|_| is_kept) else {
            return Err(self.unstable(tuning, nominal, &half, "in the nominal world"));
        };
        if self.evaluator.has_rods() {
            let rods = self.evaluator.closely(stop, candidate, Fidelity::Rods).ok_or(Counted::Stopped)?;
            *spent += 1;
            self.kept_with_rods(tuning, candidate, nominal, &rods)?;
        }
        Ok(Nominal { value: *value, each: &half.each }.own())
    }

    /// Counts curves that lose their value at half the step, and says of the first what it was.
    fn unstable(&self, tuning: &mut Tuning, found: Nominal<'_>, half: &Evaluated, place: &str) -> Counted {
        tuning.tally.unstable += 1;
        if tuning.tally.first_unstable.is_none() {
            let unit = &self.task().objective.unit;
            let shown = |value: f64| quantity(value, unit);
            let half = match &half.value {
                Ok(value) => shown(Nominal { value: *value, each: &half.each }.own()),
                Err(Missing::Elsewhere(world, _)) => format!("no value, because of the world `{world}`,"),
                Err(_) => "no value".to_owned(),
            };
            // Of several objectives it may be another one that was lost.
            if self.task().objectives().count() > 1 {
                return Counted::Unsound;
            }
            let was = shown(found.own());
            tuning.tally.first_unstable = Some(format!("{was} {place}, and {half} at half the step"));
        }
        Counted::Unsound
    }

    /// Whether a value over all worlds is kept at half the step, and with rods where the search asks for that.
    fn kept_in_worlds(
        &mut self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        found: Nominal<'_>,
        spent: &mut u64,
    ) -> Result<(), Counted> {
        let (stop, worlds) = (self.bounds.stop, self.evaluator.worlds().unwrap_or(0));
        let half = self.evaluator.in_worlds(stop, candidate, Fidelity::HalfStep).ok_or(Counted::Stopped)?;
        *spent += worlds;
        if !self.confirms(candidate, found, &half, Fidelity::HalfStep) {
            return Err(self.unstable(tuning, found, &half, "over all worlds"));
        }
        if self.evaluator.has_rods() {
            let rods = self.evaluator.in_worlds(stop, candidate, Fidelity::Rods).ok_or(Counted::Stopped)?;
            *spent += worlds;
            self.kept_with_rods(tuning, candidate, found, &rods)?;
        }
        Ok(())
    }

    /// Whether rods confirm a value.
    fn kept_with_rods(
        &self,
        tuning: &mut Tuning,
        candidate: &Parameters,
        found: Nominal<'_>,
        rods: &Evaluated,
    ) -> Result<(), Counted> {
        if self.confirms(candidate, found, rods, Fidelity::Rods) {
            return Ok(());
        }
        tuning.tally.count(Missing::WithRods);
        Err(Counted::Unsound)
    }

    /// Whether a closer look confirms a value; where a front is searched for, that of every objective.
    fn confirms(
        &self,
        candidate: &Parameters,
        found: Nominal<'_>,
        closer: &Evaluated,
        fidelity: Fidelity,
    ) -> bool {
        let rules = self.candidate().rules;
        let at_rest = self.at_rest(candidate);
        let share = match (fidelity, rules.search.keep_with_rods) {
            (Fidelity::Rods, Some(share)) => share,
            _ => rules.search.keep,
        };
        match &self.evaluator.aim {
            Some(aim) => aim.keeps(share, &at_rest, found.each, &closer.each),
            None => {
                let direction = self.task().objective.direction;
                let at_rest = at_rest.first().copied().unwrap_or(0.0);
                let keeps = |closer: &f64| keeps(direction, at_rest, share, found.value, *closer);
                closer.value.as_ref().is_ok_and(keeps)
            }
        }
    }

    /// Makes the checks side by side that a batch will ask for, as far as can be foreseen: of all that are better than
    /// those before them.
    pub(super) fn prepare_checks(
        &mut self,
        tuning: &Tuning,
        candidates: &[Parameters],
        values: &[Evaluated],
    ) {
        let mut least = match self.judge() {
            None => best(tuning).map_or(f64::NEG_INFINITY, |value| self.fitness(value)),
            Some(Judge::Best) => tuning.highest.unwrap_or(f64::NEG_INFINITY),
            // These are judged in all worlds before.
            Some(Judge::Promising | Judge::Every) => return,
        };
        least = least.max(self.known.kept);
        let mut likely = Vec::new();
        for (candidate, evaluated) in candidates.iter().zip(values) {
            let Ok(value) = evaluated.value else { continue };
            let (fitness, found) = (self.fitness(value), Nominal { value, each: &evaluated.each });
            if fitness > least && self.can_lose(candidate, found) && !self.is_covered(found) {
                least = fitness;
                likely.push(candidate.clone());
            }
        }
        if likely.len() > 1 {
            self.evaluator.prepare_closely(self.bounds.stop, &likely, Fidelity::HalfStep);
        }
    }

    /// The fitness that curves will be given, where that is known already; none inside where they have no value.
    pub(super) fn foreseen(&self, tuning: &Tuning, candidate: &Parameters) -> Option<Option<f64>> {
        let Ok(value) = self.evaluator.known(candidate)? else { return Some(None) };
        let fitness = self.fitness(value);
        let is_judged = match self.judge() {
            None | Some(Judge::Best) => false,
            Some(Judge::Every) => true,
            Some(Judge::Promising) => best(tuning).is_none_or(|best| fitness > self.fitness(best)),
        };
        if !is_judged {
            return Some(Some(fitness));
        }
        let value = self.evaluator.known_in_worlds(candidate)?;
        Some(value.ok().map(|value| self.fitness(value)))
    }

    /// Whether a worst case is simulated only as far as it is needed: a loop that goes on with values in the nominal world
    /// has no use for that of what is no new best. So far in populations only: searches of before find what they found.
    fn races(&self) -> bool {
        let is_new = self.candidate().rules.search.population().is_some();
        is_new && matches!(self.judge(), Some(Judge::Best | Judge::Promising)) && self.task().is_worst_case()
    }

    /// Whether curves of this value are of any use to the run, if they are the best of their body: what is of none is
    /// not checked.
    fn is_of_use(&self, found: Nominal<'_>) -> bool {
        let Known { of_use, kept, .. } = self.known;
        let fitness = self.fitness(found.value);
        fitness > kept && (self.looped().is_some() || fitness > of_use) && !self.is_covered(found)
    }

    /// Whether a design on the front is as good in every objective.
    fn is_covered(&self, found: Nominal<'_>) -> bool {
        self.evaluator.aim.as_ref().is_some_and(|aim| aim.is_covered(found.each, &self.known.front))
    }

    /// Whether a best could lose something: where more is better, a value that is no better than where nothing moves has nothing to
    /// lose. What nothing drives has something to lose only if it is better than that in any objective.
    fn can_lose(&self, candidate: &Parameters, found: Nominal<'_>) -> bool {
        let at_rest = self.at_rest(candidate);
        let objective = &self.task().objective;
        let gain = |(objective, value, at_rest): (&Objective, f64, f64)| {
            objective.direction.fitness(value) - objective.direction.fitness(at_rest)
        };
        let first = at_rest.first().copied().unwrap_or(0.0);
        if self.is_actuated() {
            return gain((objective, found.value, first)) > 0.0
                || objective.direction == Direction::Minimize
                || self.evaluator.aim.is_some();
        }
        if self.evaluator.aim.is_none() {
            return gain((objective, found.value, first)) > NOTHING;
        }
        let each = self.task().objectives().zip(found.each).zip(&at_rest);
        each.map(|((objective, value), at_rest)| (objective, *value, *at_rest)).any(|one| gain(one) > NOTHING)
    }

    /// What each objective is of this body where nothing moves; where that has no value, what is added to it whatever the motion is.
    fn at_rest(&self, candidate: &Parameters) -> Vec<f64> {
        let rules = self.candidate().rules;
        let offsets = || self.task().objectives().map(|objective| objective.offset(rules)).collect();
        score::at_rest(&self.evaluator.drive, candidate).unwrap_or_else(offsets)
    }

    /// Whether anything in the body moves by itself.
    fn is_actuated(&self) -> bool {
        let Candidate { rules, derivation, .. } = self.candidate();
        derivation.design.parts.values().any(|p| rules.is_driven(&p.kind))
    }
}

/// The same order of worlds, but with one of them in front.
fn in_front(world: usize, order: &[usize]) -> Vec<usize> {
    std::iter::once(world).chain(order.iter().copied().filter(|other| *other != world)).collect()
}
