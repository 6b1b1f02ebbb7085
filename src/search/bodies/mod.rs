//! The loop over bodies: the search for bodies by rule applications.

mod ahead;
mod annealing;
mod archive;
pub(crate) mod front;
mod population;
mod prospect;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use grammar_lang::ir::{BodyLoop, BodyMethod, RuleSet, Schedule};

use super::aim::Aim;
use super::body::{Known, Tasks, inherited};
use super::cache::Cache;
use super::crew::Crew;
use super::curves::{Progress, Streams};
use super::evaluator::Engine;
use super::gains::Gains;
use super::observer::{Observer, Outcome, Row};
use super::schedule::{Around, Course, Iteration, Plan, Stand};
use super::state::{
    Best, Body, Designs, Incumbent, Members, Origin, State, Trial, Tune, Tuned, Tuning, Worth,
};
use super::tally::Tally;
use super::{Bounds, End, Failure, Limits, MOST_IDLE_MOVES};
use crate::deep;
use crate::derive::random::Stream;
use crate::derive::{Blocked, Candidate, Derivation};
use crate::score::Observed;
use crate::simulate::Model;
use ahead::{Ahead, Found, Home, Order};
use population::Parent;

/// What a loop does next.
enum Begun {
    /// A move of a chain, at a temperature.
    Move { chain: usize, temperature: f64 },
    /// Something else: there is more to do.
    Iteration,
    /// Nothing more.
    End(End),
}

/// What kind of design a body is.
enum Described {
    /// Its cell of the archive.
    Cell(Vec<usize>),
    /// It has none, or there is no archive.
    Nothing,
    /// That was stopped.
    Stopped(End),
}

/// What became of a move of a body.
#[derive(Default)]
struct Judged {
    value: Option<f64>,
    nominal: Option<f64>,
    at_most_in: Option<u64>,
    observed: Vec<Option<Observed>>,
    accepted: bool,
    tally: Tally,
    beside: Vec<f64>,
    /// How often the curves were tuned before.
    tuned: usize,
}

struct Bodies<'a> {
    rules: &'a RuleSet,
    engine: Engine<'a>,
    /// Those who tune what may come; none where it is only supposed.
    ahead: Option<&'a Ahead<'a>>,
    seed: u64,
    bounds: Bounds<'a>,
    observer: &'a mut dyn Observer,
    state: State,
    /// What bodies gained on those before them.
    gains: Gains,
    costs: Costs,
    /// A new best whose curves are not tuned to the end, once the search has been stopped.
    unfinished: Option<Best>,
}

/// What bodies cost in evaluations.
#[derive(Clone, Copy, Debug, Default)]
struct Costs {
    /// How many were spent when the body at hand was begun.
    begun: u64,
    /// Those of all bodies since the search began or went on, but for those that took one only.
    all: u64,
    bodies: u64,
}

impl Costs {
    /// What a body costs in the mean; zero as long as that is not known.
    fn typical(self) -> u64 {
        self.all.checked_div(self.bodies).unwrap_or(0)
    }

    /// Ends a body, when so many are spent.
    fn end(&mut self, spent: u64) {
        let cost = spent - self.begun;
        if cost > 1 {
            (self.all, self.bodies) = (self.all + cost, self.bodies + 1);
        }
    }
}

/// The streams of random numbers for the curves of a body.
fn curves(seed: u64, number: usize) -> Streams {
    Streams { seed, name: format!("curves {number}") }
}

/// Runs the search that a rule set asks for, from a first design. `stop` may be set from
/// outside to end it soon.
///
/// # Errors
///
/// A [`Failure`]; what the observer was told before stays true.
pub fn run(
    rules: &RuleSet,
    first: Derivation,
    model: &dyn Model,
    limits: &Limits,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, Failure> {
    go_on(rules, State::begin(first), model, limits, stop, observer)
}

/// Goes on with a search from its state. The result is the same, bit for bit, as without the stop.
///
/// # Errors
///
/// A [`Failure`]; what the observer was told before stays true.
pub fn go_on(
    rules: &RuleSet,
    state: State,
    model: &dyn Model,
    limits: &Limits,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, Failure> {
    let crew = Crew::new(&limits.jobs)?;
    let bounds = Bounds::new(limits, stop);
    let seed = limits.seed;
    let cache = Cache::default();
    let engine = Engine { model, cache: &cache, crew: &crew };
    let ahead = Ahead::new(&limits.jobs, &crew);
    let mut search = Bodies {
        rules,
        engine,
        ahead: Some(&ahead),
        seed,
        bounds,
        observer,
        state,
        gains: Gains::NONE,
        costs: Costs::default(),
        unfinished: None,
    };
    let end = std::thread::scope(|scope| {
        let _home = Home(&ahead);
        for number in 1..=ahead.helpers() {
            let (ahead, of) = (&ahead, ahead::Search { rules, engine, seed, bounds });
            // With fewer helpers the search is slower, and the same.
            let _ = deep::spawn(scope, move || ahead.help(number, of));
        }
        search.go()
    })?;
    let archive = search.state.archive().to_vec();
    let front = search.state.front().cloned().collect();
    let State { spent, moves, bodies, tally, best, trial, learned, .. } = search.state;
    // The one that was being tuned, if the search was stopped.
    let bodies = bodies + usize::from(trial.is_some_and(|trial| trial.further.is_none()));
    let best = search.unfinished.or(best);
    Ok(Outcome { best, archive, front, learned, evaluations: spent, moves, bodies, tally, end })
}

/// Tunes the curves of one body, as the search does for each body.
///
/// # Errors
///
/// A [`Failure`].
pub fn tune_body(
    rules: &RuleSet,
    model: &dyn Model,
    derivation: &Arc<Derivation>,
    limits: &Limits,
    stop: &AtomicBool,
) -> Result<Outcome, Failure> {
    let crew = Crew::new(&limits.jobs)?;
    let cache = Cache::default();
    let mut tasks = Tasks {
        candidate: Candidate::new(rules, Arc::clone(derivation)),
        engine: Engine { model, cache: &cache, crew: &crew },
        streams: Streams { seed: limits.seed, name: "body".to_owned() },
        warm: Vec::new(),
        is_given: false,
        further: None,
        aim: None,
        parent: Vec::new(),
        bounds: Bounds::new(limits, stop),
        known: Known::NOTHING,
        tuner: None,
    };
    let (mut body, mut spent) = (Body::default(), 0);
    let end = loop {
        match tasks.advance(&mut body, &mut spent)? {
            Progress::More => {}
            Progress::Done => break End::Stopped,
            Progress::Cut(end) => {
                body.close();
                break end;
            }
        }
    };
    let (found, tally) = body.found(rules, derivation);
    let best = found.map(|(tasks, value)| Best {
        derivation: Arc::clone(derivation),
        tasks,
        value,
        beside: Vec::new(),
        found_at: 0,
    });
    Ok(Outcome {
        best,
        archive: Vec::new(),
        front: Vec::new(),
        learned: Vec::new(),
        evaluations: spent,
        moves: 0,
        bodies: 1,
        tally,
        end,
    })
}

impl Bodies<'_> {
    /// The value on a scale where more is better; worst where there is none.
    fn fitness(&self, value: Option<f64>) -> f64 {
        value.map_or(f64::NEG_INFINITY, |value| self.rules.objective.direction.fitness(value))
    }

    fn go(&mut self) -> Result<End, Failure> {
        loop {
            let end = match self.bounds.stopped() {
                Some(end) => Some(end),
                None if self.state.trial.is_some() => self.try_body()?,
                None => self.next_move()?,
            };
            let last = end.is_some_and(End::is_early);
            if last {
                self.keep_unfinished()?;
            }
            if last || end.is_none() {
                self.observer.checkpoint(&self.state, last)?;
            }
            if let Some(end) = end {
                return Ok(end);
            }
        }
    }

    /// Begins the loop with the first design.
    fn begin_designs(&mut self, first: Incumbent<Arc<Derivation>>) {
        self.state.course = Course::new(self.rules.objective.direction, first.value);
        self.state.first = first;
        match self.rules.search.bodies.as_ref().map(|bodies| &bodies.method) {
            Some(BodyMethod::Annealing(annealing)) => self.begin_chains(annealing),
            Some(BodyMethod::Archive(_)) => self.state.designs = Some(Designs::Archive(Vec::new())),
            Some(BodyMethod::Population(_)) => {
                let none = Members::none(self.rules.objective.direction);
                self.state.designs = Some(Designs::Population(none));
            }
            Some(BodyMethod::Front(_)) => self.state.designs = Some(Designs::Front(Vec::new())),
            None => {}
        }
    }

    /// Draws the next body, or ends an iteration.
    fn next_move(&mut self) -> Result<Option<End>, Failure> {
        let Some(BodyLoop { schedule, method }) = &self.rules.search.bodies else {
            return Ok(Some(End::Schedule));
        };
        let begun = match method {
            BodyMethod::Archive(_) | BodyMethod::Population(_) | BodyMethod::Front(_) => {
                self.begin_plain_move(schedule)?
            }
            BodyMethod::Annealing(annealing) => self.begin_chain_move(schedule, annealing)?,
        };
        match begun {
            Begun::Move { chain, temperature } => self.draw(chain, temperature),
            Begun::Iteration => Ok(None),
            Begun::End(end) => Ok(Some(end)),
        }
    }

    /// The move that is next, or the end of an iteration, where moves have no chains.
    fn begin_plain_move(&mut self, schedule: &Schedule) -> Result<Begun, Failure> {
        if self.state.iteration.is_none() {
            let Some(iteration) = self.plain_plan(schedule).begin()? else {
                return Ok(Begun::End(End::Schedule));
            };
            self.state.iteration = Some(iteration);
        }
        if self.state.iteration.is_some_and(|iteration| iteration.made >= iteration.moves) {
            self.state.iteration = None;
            self.state.course.complete(self.state.best.as_ref().map(|b| b.value));
            self.complete_members(schedule)?;
            let is_over = self.plain_plan(schedule).stops()?;
            return Ok(if is_over { Begun::End(End::Stopped) } else { Begun::Iteration });
        }
        Ok(Begun::Move { chain: 0, temperature: 0.0 })
    }

    fn plain_plan<'p>(&'p self, schedule: &'p Schedule) -> Plan<'p> {
        self.plan_at(schedule, self.state.spent)
    }

    /// The same as it was when so many evaluations were spent.
    fn plan_at<'p>(&'p self, schedule: &'p Schedule, spent: u64) -> Plan<'p> {
        let (rules, state) = (self.rules, &self.state);
        let derivation = &state.first.derivation;
        let around = Around { spent: self.bounds.share(spent), ..self.around() };
        Plan { rules, derivation, schedule, course: &state.course, stand: Stand::Bodies, around }
    }

    /// What the loop knows of what is around it.
    fn around(&self) -> Around {
        Around { tuned: 0, parent: 0.0, spent: self.bounds.share(self.state.spent) }
    }

    /// Applies a rule to the current design of a chain, or to one of those that are kept, or tunes its curves further.
    fn draw(&mut self, chain: usize, temperature: f64) -> Result<Option<End>, Failure> {
        let rules = self.rules;
        if let Some(end) = self.bounds.exhausted(self.state.spent) {
            return Ok(Some(end));
        }
        let number = self.state.moves + 1;
        let mut random = Stream::named(self.seed, &format!("body {number}"));
        let drawn = random.unit();
        self.note_members();
        let aim = self.aim(number);
        let Parent { place, further } = self.parent(chain, aim.as_ref(), &mut random)?;
        let Incumbent { number: parent, derivation, tunes, .. } = place;
        if further.is_some() {
            self.made_move(number);
            // It is of use if it finds something.
            self.state.idle_moves += 1;
            let is_stuck = self.state.idle_moves >= MOST_IDLE_MOVES;
            let origin = Origin { parent: Some(parent), chain, rule: None, blocked: Vec::new() };
            let (warm, body) = (Vec::new(), Body::default());
            let parent = Worth::of(&tunes);
            let begun = self.state.spent;
            self.state.trial =
                Some(Trial { derivation, origin, begun, drawn, warm, further, aim, parent, body });
            return Ok(is_stuck.then_some(End::Stuck));
        }
        let step = derivation.advance(rules, &mut random, temperature);
        let is_warm = rules.search.is_warm();
        let warm = match &step.result {
            Some(next) if is_warm => {
                let mut random = Stream::named(self.seed, &format!("warm {number}"));
                let parent = Candidate::new(rules, Arc::clone(&derivation));
                let own = Candidate::new(rules, Arc::new(next.clone()));
                inherited(&parent, &tunes, &own, &mut random)
            }
            _ => Vec::new(),
        };
        let state = &mut self.state;
        for (_, why) in &step.blocked {
            if let Blocked::NoValue(error) = why {
                *state.tally.refused.entry(error.clone()).or_default() += 1;
            }
        }
        let called = |rule: usize| rules.rules.get(rule).map_or(String::new(), |rule| rule.name.clone());
        let mut blocked: Vec<(String, String)> =
            step.blocked.iter().map(|(rule, why)| (called(*rule), why.text(rules))).collect();
        self.made_move(number);
        let next = step.result.filter(|next| {
            let is_known = self.is_member(next);
            if let (true, Some(rule)) = (is_known, step.rule) {
                blocked.push((called(rule), "the body is kept already".to_owned()));
            }
            !is_known
        });
        let state = &mut self.state;
        let Some(next) = next else {
            // A move that can do nothing is counted and told.
            state.idle_moves += 1;
            let stuck = state.idle_moves >= MOST_IDLE_MOVES;
            if let Some(chain) = state.chain(chain) {
                chain.standing.note(false);
            }
            let origin = Origin { parent: Some(parent), chain, rule: None, blocked };
            self.tell(&derivation, origin, Judged::default())?;
            return Ok(stuck.then_some(End::Stuck));
        };
        state.idle_moves = 0;
        let rule = step.rule.and_then(|i| rules.rules.get(i)).map(|r| r.name.clone());
        let origin = Origin { parent: Some(parent), chain, rule, blocked };
        let (derivation, body) = (Arc::new(next), Body::default());
        let parent = Worth::of(&tunes);
        let begun = state.spent;
        state.trial =
            Some(Trial { derivation, origin, begun, drawn, warm, further: None, aim, parent, body });
        Ok(None)
    }

    /// Counts a move.
    fn made_move(&mut self, number: usize) {
        let state = &mut self.state;
        state.moves = number;
        if state.designs.as_mut().is_none_or(Designs::next_turn)
            && let Some(Iteration { made, .. }) = &mut state.iteration
        {
            *made += 1;
        }
    }

    /// The design that a move starts from, and its curves: the chain's own, or one of the archive or the population.
    fn parent(&self, chain: usize, aim: Option<&Aim>, random: &mut Stream) -> Result<Parent, Failure> {
        let state = &self.state;
        if let Some(tournament) = self.tournament(aim)?
            && let Some(winner) = self.winner(&tournament, random)
        {
            return Ok(winner);
        }
        let place = match self.elite(random).cloned() {
            Some(Best { derivation, tasks, value, found_at, .. }) => {
                Incumbent { number: found_at, derivation, value: Some(value), tunes: tasks }
            }
            None => state.chains().get(chain).map_or(&state.first, |chain| &chain.at).clone(),
        };
        Ok(Parent { place, further: None })
    }

    /// Tunes the body that is being tried, and judges it.
    fn try_body(&mut self) -> Result<Option<End>, Failure> {
        // The first body is tried before anything is drawn.
        let aim = self.aim(self.state.moves);
        let Some(trial) = &mut self.state.trial else { return Ok(None) };
        trial.aim = trial.aim.take().or(aim);
        let Some(trial) = &self.state.trial else { return Ok(None) };
        let known = self.known()?;
        let (mut is_done, mut planned) = (false, None);
        if let Some(ahead) = self.ahead {
            let key = Order::of(self.state.moves, trial, known.clone()).key;
            let Self { rules, engine, seed, bounds, .. } = *self;
            ahead.take_over(&key, ahead::Search { rules, engine, seed, bounds }, || {
                self.look_ahead(&mut planned);
            });
            is_done = ahead.found(&key).is_some();
        }
        let Some(trial) = &self.state.trial else { return Ok(None) };
        self.costs.begun = self.state.spent;
        let mut tasks = Tasks {
            known,
            candidate: Candidate::new(self.rules, Arc::clone(&trial.derivation)),
            engine: self.engine,
            streams: curves(self.seed, self.state.moves),
            warm: trial.warm.clone(),
            is_given: self.state.moves == 0,
            further: trial.further.clone(),
            aim: trial.aim.clone(),
            parent: trial.parent.clone(),
            bounds: self.bounds,
            tuner: None,
        };
        let cut = loop {
            // What is done takes no time, and whoever began the next body now would be in the way.
            if !is_done {
                self.look_ahead(&mut planned);
            }
            let State { trial: Some(trial), spent, .. } = &mut self.state else { return Ok(None) };
            match tasks.advance(&mut trial.body, spent)? {
                Progress::Done => break None,
                Progress::Cut(end) if end.is_early() => return Ok(Some(end)),
                Progress::Cut(end) => {
                    trial.body.close();
                    break Some(end);
                }
                Progress::More => {}
            }
            let (temperature, best) = trial.body.progress();
            self.observer.evaluated(self.state.spent, best, temperature);
            self.observer.checkpoint(&self.state, false)?;
        };
        let cell = match self.describe()? {
            Described::Stopped(end) => return Ok(Some(end)),
            Described::Cell(cell) => Some(cell),
            Described::Nothing => None,
        };
        let Some(trial) = self.state.trial.take() else { return Ok(cut) };
        self.costs.end(self.state.spent);
        self.judge(trial, cell, cut.is_some())?;
        Ok(cut)
    }

    /// What a body must exceed. An archive has a best for each kind of design, so that one of its bodies may be of use without
    /// being the best, and a chain may go through worse ones to better ones; a population has a worst. Of several tasks none
    /// knows what the rest are worth.
    fn known(&self) -> Result<Known, Failure> {
        let search = &self.rules.search;
        // What is good enough for a front no single number says.
        if search.front().is_some() {
            let front = self.state.front().map(Best::each).collect();
            return Ok(Known { front, hardest: self.state.hardest.clone(), ..Known::NOTHING });
        }
        let is_alone = self.rules.tasks.len() == 1;
        let best = self.state.best.as_ref().map(|best| best.value).filter(|_| is_alone);
        let of_use = best.filter(|_| search.archive().is_none() && search.population().is_none());
        let is_kept = is_alone && search.population().is_some();
        let begun = self.state.trial.as_ref().map_or(self.state.spent, |trial| trial.begun);
        let least = if is_kept { self.least_kept(self.size(begun)?) } else { f64::NEG_INFINITY };
        Ok(Known {
            of_use: self.fitness(of_use),
            kept: least,
            best: self.fitness(best),
            front: Vec::new(),
            tuned: 0,
            parent: None,
            hardest: self.state.hardest.clone(),
        })
    }

    /// Accepts a body or not, and keeps the best.
    fn judge(
        &mut self,
        mut trial: Trial<Arc<Derivation>>,
        cell: Option<Vec<usize>>,
        is_cut: bool,
    ) -> Result<(), Failure> {
        let tunings = std::mem::take(&mut trial.body.tunings);
        if let [Tuning { hardest, .. }] = tunings.as_slice()
            && !hardest.is_empty()
        {
            self.state.hardest.clone_from(hardest);
        }
        let learned: Vec<_> = tunings
            .iter()
            .enumerate()
            .filter_map(|(task, tuning)| Some((task, tuning.learned()?.to_vec())))
            .collect();
        if !learned.is_empty() {
            self.state.learned = learned;
        }
        let tuned = Tuned { times: 1 + trial.further.as_ref().map_or(0, |further| further.times), tunings };
        let (found, tally) = std::mem::take(&mut trial.body).found(self.rules, &trial.derivation);
        if let Some(chain) = self.state.chains().get(trial.origin.chain) {
            let gain = self.fitness(found.as_ref().map(|(_, value)| *value)) - self.fitness(chain.at.value);
            // From nothing to nothing is no gain.
            self.gains.learn(trial.origin.chain, if gain.is_nan() { f64::NEG_INFINITY } else { gain });
        }
        self.settle(trial, (found, tuned), tally, cell, is_cut)
    }

    /// Does with a body what its value asks for.
    fn settle(
        &mut self,
        trial: Trial<Arc<Derivation>>,
        (found, tuned): (Found, Tuned),
        tally: Tally,
        cell: Option<Vec<usize>>,
        is_cut: bool,
    ) -> Result<(), Failure> {
        let Trial { derivation, origin, drawn, further, .. } = trial;
        let value = found.as_ref().map(|(_, value)| *value);
        let first = self.state.moves == 0;
        self.state.bodies += usize::from(further.is_none());
        self.state.tally.add(&tally);
        let tunes = found.as_ref().map_or_else(Vec::new, |(tunes, _)| tunes.clone());
        let observed = tunes.first().map_or_else(Vec::new, |tune| tune.observed.clone());
        let (nominal, at_most_in) =
            if let [one] = tunes.as_slice() { (one.nominal, one.at_most_in) } else { (None, None) };
        let number = self.state.moves;
        let beside = self.beside(&derivation, &tunes)?;
        let place = Incumbent { number, derivation: Arc::clone(&derivation), value, tunes };
        if let Some(best) = self.better(&derivation, found, &beside) {
            self.observer.improved(&best)?;
            self.state.best = Some(best);
        }
        let accepted = if first {
            self.begin_designs(place.clone());
            true
        } else {
            !is_cut && self.accept(origin.chain, &place, drawn)
        };
        let times = further.as_ref().map_or(0, |further| further.times);
        let kept = match cell {
            Some(cell) => self.keep_of_kind(cell, place)?,
            None if self.rules.search.front().is_some() => self.keep_on_front(&place, &beside, &tuned)?,
            None => self.keep_member(place, tuned, further.is_some())?,
        };
        if kept {
            self.state.idle_moves = 0;
        }
        let mistake = tally.no_value.keys().next().filter(|_| first && value.is_none()).cloned();
        self.tell(
            &derivation,
            origin,
            Judged {
                value,
                nominal,
                at_most_in,
                observed,
                accepted: accepted || kept,
                tally,
                beside,
                tuned: times,
            },
        )?;
        // What has no value for the very first design is a mistake in the grammar.
        mistake.map_or(Ok(()), |error| Err(error.into()))
    }

    /// A new best, if what was found for a body is one.
    fn better(
        &self,
        derivation: &Arc<Derivation>,
        found: Option<(Vec<Tune>, f64)>,
        beside: &[f64],
    ) -> Option<Best> {
        let (tasks, value) = found?;
        let is_better = |best: &Best| {
            let (new, old) = (self.fitness(Some(value)), self.fitness(Some(best.value)));
            new > old || new == old && self.is_ahead(beside, &best.beside)
        };
        self.state.best.as_ref().is_none_or(is_better).then(|| Best {
            derivation: Arc::clone(derivation),
            tasks,
            value,
            beside: beside.to_vec(),
            found_at: self.state.moves,
        })
    }

    /// Shows the observer what is known of a body whose tuning was stopped, if it is a new best. The state
    /// does not know: going on from it finds the same or better.
    fn keep_unfinished(&mut self) -> Result<(), Failure> {
        let Some(Trial { derivation, body, .. }) = &self.state.trial else { return Ok(()) };
        let mut body = body.clone();
        body.close();
        let (found, _) = body.found(self.rules, derivation);
        let beside = match &found {
            Some((tunes, _)) => self.beside(derivation, tunes)?,
            None => Vec::new(),
        };
        if let Some(best) = self.better(derivation, found, &beside) {
            self.observer.improved(&best)?;
            self.unfinished = Some(best);
        }
        Ok(())
    }

    /// Tells the observer of a move.
    fn tell(
        &mut self,
        derivation: &Derivation,
        Origin { parent, chain, rule, blocked }: Origin,
        Judged { value, nominal, at_most_in, observed, accepted, tally, beside, tuned }: Judged,
    ) -> Result<(), Failure> {
        let rules = self.rules;
        let state = &self.state;
        let parts = derivation.design.parts.len();
        let actuators = derivation.design.actuators(rules);
        let is_annealed = state.iteration.is_some();
        let row = Row {
            number: state.moves,
            iteration: state.course.iteration,
            chain,
            parent,
            rule,
            tuned,
            blocked,
            size: (parts, actuators),
            value,
            nominal,
            at_most_in,
            accepted,
            best: state.best.as_ref().map(|b| b.value),
            temperature: state
                .chains()
                .get(chain)
                .filter(|_| is_annealed)
                .map_or(0.0, |chain| chain.standing.temperature),
            beside,
            evaluations: state.spent,
            tally,
            observed,
        };
        self.observer.moved(&row).map_err(Failure::Output)
    }
}
