//! The loop over curves: the search for the curves of one body.

mod annealing;
mod evolution;
mod forecast;
mod futures;
mod judging;
mod learning;

use grammar_lang::ir::{CurveLoop, CurveMethod, RuleSet, Task};

use super::body::Known;
use super::evaluator::Evaluator;
use super::schedule::{Around, Course};
use super::state::{Curves, Learning, Tuning};
use super::tally::Missing;
use super::{Bounds, End, Failure};
use crate::derive::Candidate;
use crate::derive::random::Stream;
use crate::drive::Parameters;
use forecast::Forecast;
use futures::Annealed;
use judging::{Counted, When};
use learning::Method;

/// The value of a parent that is none, where more is better: anything is better than that.
const NO_PARENT: f64 = -1e100;

/// How a loop stands after a batch of evaluations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// There is more to do.
    More,
    /// It is complete.
    Done,
    /// It is cut short.
    Cut(End),
}

/// The streams of random numbers of a body's curves.
#[derive(Clone, Debug)]
pub(super) struct Streams {
    pub(super) seed: u64,
    /// What they are named after.
    pub(super) name: String,
}

impl Streams {
    /// Those of a task.
    pub(super) fn of_task(&self, task: &Task) -> Self {
        let name = match task.name.as_str() {
            RuleSet::ONLY_TASK => self.name.clone(),
            task => format!("{} {task}", self.name),
        };
        Self { seed: self.seed, name }
    }

    fn stream(&self, what: &str) -> Stream {
        Stream::named(self.seed, &format!("{}/{what}", self.name))
    }
}

/// Curves that a loop begins with.
pub(super) struct Warm {
    pub(super) curves: Parameters,
    /// Whether the user gave them. These are judged in all worlds before anything is varied: what is found later is kept only if it is
    /// better.
    pub(super) is_given: bool,
}

/// The loop over the curves of one body for one task. What it knows is in a [`Tuning`]; here is only
/// what can be made again.
pub(super) struct Tuner<'a> {
    evaluator: Evaluator<'a>,
    forecast: Forecast,
    streams: Streams,
    /// Curves to begin with, if not with random ones.
    warm: Option<Warm>,
    bounds: Bounds<'a>,
    /// What the run knows already.
    known: Known,
    /// The share of its evaluations that the run had spent when it was asked last.
    spent: f64,
}

impl<'a> Tuner<'a> {
    /// A loop that begins with some curves, if they fit the body.
    pub(super) fn new(
        evaluator: Evaluator<'a>,
        streams: Streams,
        warm: Option<Warm>,
        bounds: Bounds<'a>,
        known: Known,
    ) -> Self {
        let forecast = Forecast::new(&evaluator, bounds.lanes);
        let warm = warm.filter(|warm| evaluator.drive.fits(&warm.curves));
        Self { evaluator, forecast, streams, warm, bounds, known, spent: 0.0 }
    }

    fn stream(&self, what: &str) -> Stream {
        self.streams.stream(what)
    }

    fn candidate(&self) -> &Candidate<'a> {
        self.evaluator.drive.candidate()
    }

    fn task(&self) -> &'a Task {
        self.evaluator.drive.task()
    }

    /// The value on a scale where more is better.
    fn fitness(&self, value: f64) -> f64 {
        self.task().objective.direction.fitness(value)
    }

    /// The loop, where there is something to tune.
    fn looped(&self) -> Option<&'a CurveLoop> {
        self.candidate().rules.search.curves.as_ref().filter(|_| !self.evaluator.drive.is_fixed())
    }

    /// What the loop knows of what is around it.
    fn around(&self) -> Around {
        let lowest = self.task().objective.direction.fitness(NO_PARENT);
        Around { tuned: self.known.tuned, parent: self.known.parent.unwrap_or(lowest), spent: self.spent }
    }

    /// Curves that a chain begins with. Only the first begins where the grammar says: the others are to begin elsewhere.
    fn start(&self, chain: usize) -> Parameters {
        match (&self.warm, chain) {
            (Some(warm), 0) => warm.curves.clone(),
            (_, 0) => self.evaluator.drive.begin(&mut self.stream("start")),
            _ => self.evaluator.drive.draw(&mut self.stream(&format!("start {chain}"))),
        }
    }

    /// Goes on by a batch of evaluations. Moves are made whole or not at all, so that the state is
    /// sound whenever this returns.
    pub(super) fn advance(&mut self, tuning: &mut Tuning, spent: &mut u64) -> Result<Progress, Failure> {
        self.forecast.threads = self.evaluator.room().0;
        // What is no better than the best so far will not become it.
        self.evaluator.observed_above = match self.evaluator.worlds() {
            None => best(tuning).map_or(f64::NEG_INFINITY, |value| self.fitness(value)),
            // Curves that are judged in all worlds are observed there.
            Some(_) => f64::INFINITY,
        };
        let Some(mut curves) = tuning.loops.take() else { return self.begin(tuning, spent) };
        let Some(CurveLoop { schedule, method, .. }) = self.looped() else {
            tuning.loops = Some(curves);
            return Ok(Progress::Done);
        };
        let progress = match (&mut curves, method) {
            (Curves::Chains(chains), CurveMethod::Annealing(annealing)) => {
                self.anneal(Annealed { schedule, annealing }, tuning, chains, spent)
            }
            (Curves::Distribution(distribution), CurveMethod::CmaEs(cma_es)) => {
                self.evolve(schedule, cma_es, tuning, distribution, spent)
            }
            (Curves::Learning(learning), method) => match Method::of(method) {
                Some(method) => self.learn(schedule, method, tuning, learning, spent),
                None => Ok(Progress::Done),
            },
            // A state is begun with the method that it goes on with.
            (Curves::Chains(_) | Curves::Distribution(_), _) => Ok(Progress::Done),
        };
        tuning.loops = Some(curves);
        // A schedule that has no value any more ends the loop, not the run: what was found so far is judged and kept.
        if let Err(Failure::Expression(error)) = &progress
            && *spent > 1
        {
            *spent += 1;
            tuning.tally.count(Missing::Expression(error.clone()));
            let is_judged = self.judge_offered(tuning, spent, When::AtTheEnd)?;
            return if is_judged { Ok(Progress::Done) } else { self.stopped() };
        }
        // Where the evaluations end before any curves were judged in all worlds, the best of them are.
        if let Ok(Progress::Cut(end)) = &progress
            && !end.is_early()
            && tuning.found.is_none()
            && !self.judge_offered(tuning, spent, When::AtTheEnd)?
        {
            return self.stopped();
        }
        progress
    }

    /// Evaluates the curves that the search starts from.
    fn begin(&mut self, tuning: &mut Tuning, spent: &mut u64) -> Result<Progress, Failure> {
        let method = self.looped().map(|looped| &looped.method);
        let chains = match method {
            Some(CurveMethod::Annealing(annealing)) => annealing.chains.unwrap_or(1),
            Some(CurveMethod::CmaEs(_) | CurveMethod::ActorCritic(_) | CurveMethod::QLearning(_)) | None => 1,
        };
        let learner = method.and_then(Method::of).and_then(|method| self.learner(method));
        let starts: Vec<Parameters> = match &learner {
            Some((_, policy)) => vec![policy.clone()],
            None => (0..chains).map(|chain| self.start(chain)).collect(),
        };
        let Some(values) = self.evaluator.evaluate(self.bounds.stop, &starts) else { return self.stopped() };
        // Counted as if nothing had been, if it is stopped between them.
        let (mut now, mut counted) = (tuning.clone(), *spent);
        let mut fitness = Vec::with_capacity(chains);
        for (start, evaluated) in starts.iter().zip(values) {
            let each = evaluated.each.clone();
            let is_given = self.warm.as_ref().is_some_and(|warm| warm.is_given && warm.curves == *start);
            let start_counted = if is_given {
                self.count_given(&mut now, start, evaluated, &mut counted)?
            } else {
                self.count(&mut now, start, evaluated, &mut counted)?
            };
            match start_counted {
                Counted::Stopped => return self.stopped(),
                counted => {
                    counted.fitness().into_iter().for_each(|new| self.offer(&mut now, start, new, &each));
                    fitness.push(counted.fitness());
                }
            }
        }
        let course = Course::new(self.task().objective.direction, best(&now));
        now.loops = Some(match (learner, method) {
            (Some((agent, _)), _) => Curves::Learning(Box::new(Learning::begin(agent, course))),
            (None, Some(CurveMethod::CmaEs(cma_es))) => {
                Curves::Distribution(self.distribution(&starts[0], cma_es.spread, course))
            }
            (None, _) => Curves::Chains(annealing::chains(starts, fitness, course)),
        });
        (*tuning, *spent) = (now, counted);
        Ok(if method.is_some() { Progress::More } else { Progress::Done })
    }

    fn stopped(&self) -> Result<Progress, Failure> {
        Ok(Progress::Cut(self.bounds.stopped().unwrap_or(End::Interrupted)))
    }
}

fn best(tuning: &Tuning) -> Option<f64> {
    tuning.found.as_ref().map(|f| f.value)
}
