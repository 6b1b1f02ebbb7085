//! One body, tuned for each task in turn. What was found counts only if every task has a value.

use grammar_lang::ir::{RuleSet, Task};

use super::aim::Aim;
use super::curves::{Progress, Streams, Tuner, Warm};
use super::evaluator::{Engine, Evaluator};
use super::state::{Body, Tune, Tuned, Tuning, Worth};
use super::tally::{Missing, Tally};
use super::{Bounds, Failure};
use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation};
use crate::drive::{Drive, Parameters};

/// What a run knows when it comes to a body, where more is better.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// A body that is not tuned and comes to no more is of no use, and not checked.
    pub(super) of_use: f64,
    /// A body that comes to no more does not come into the population, and is not checked.
    pub(super) kept: f64,
    /// What comes to more is the best of the run.
    pub(super) best: f64,
    /// What the designs on the front come to, by objectives: what one of them is as good as in every objective does not come onto it, and is not
    /// checked.
    pub(super) front: Vec<Vec<f64>>,
    /// How often the curves of the body were tuned before.
    pub(super) tuned: usize,
    /// The value of the design that the body was made of.
    pub(super) parent: Option<f64>,
    /// The worlds that were the hardest for other bodies.
    pub(super) hardest: Vec<usize>,
}

impl Known {
    /// Nothing.
    pub(super) const NOTHING: Self = Self {
        of_use: f64::NEG_INFINITY,
        kept: f64::NEG_INFINITY,
        best: f64::NEG_INFINITY,
        front: Vec::new(),
        tuned: 0,
        parent: None,
        hardest: Vec::new(),
    };
}

/// The loops over the curves of one body. What they know is in a [`Body`].
pub(super) struct Tasks<'a> {
    pub(super) candidate: Candidate<'a>,
    pub(super) engine: Engine<'a>,
    pub(super) streams: Streams,
    /// Curves to begin with, by task; none where they are drawn at random.
    pub(super) warm: Vec<Parameters>,
    /// Whether the user gave these: the search must not lose them.
    pub(super) is_given: bool,
    /// What is known of its curves, where they are tuned further.
    pub(super) further: Option<Tuned>,
    /// What the move is after, where a front is searched for.
    pub(super) aim: Option<Aim>,
    /// What the design that the body was made of comes to, by task; empty where there is none.
    pub(super) parent: Vec<Worth>,
    pub(super) bounds: Bounds<'a>,
    /// What the run knows already.
    pub(super) known: Known,
    /// The loop of the task at hand, once it is needed.
    pub(super) tuner: Option<Tuner<'a>>,
}

impl<'a> Tasks<'a> {
    /// Goes on by a batch of evaluations.
    pub(super) fn advance(&mut self, body: &mut Body, spent: &mut u64) -> Result<Progress, Failure> {
        let tasks = &self.candidate.rules.tasks;
        let Some((_, task)) = tasks.get_index(body.done) else { return Ok(Progress::Done) };
        let progress = match self.advance_task(task, body, spent) {
            // What the actuation cannot say of this body it may say of others. It counts as an
            // evaluation, or a search among such bodies would not end.
            Err(Failure::Expression(error)) if *spent > 1 => {
                *spent += 1;
                body.tuning = Tuning::default();
                body.tuning.tally.count(Missing::Expression(error));
                Progress::Done
            }
            // So is what the solver cannot simulate: springs of a body may be too stiff for the step of the model.
            Err(Failure::Unfit(unfit)) if *spent > 0 => {
                *spent += 1;
                body.tuning = Tuning::default();
                body.tuning.tally.count(Missing::Unfit(unfit.reason));
                Progress::Done
            }
            progress => progress?,
        };
        if progress != Progress::Done {
            return Ok(progress);
        }
        self.tuner = None;
        body.close();
        Ok(if body.done < tasks.len() { Progress::More } else { Progress::Done })
    }

    fn advance_task(
        &mut self,
        task: &'a Task,
        body: &mut Body,
        spent: &mut u64,
    ) -> Result<Progress, Failure> {
        let tuner = match &mut self.tuner {
            Some(tuner) => tuner,
            none => {
                // Each of several tasks has one objective, whatever the front is over.
                let aim = self.aim.clone().filter(|_| !task.beside.is_empty());
                let evaluator = Evaluator::new(&self.candidate, task, self.engine, aim)?;
                let (streams, warm) = (self.streams.of_task(task), self.warm.get(body.done));
                let worth =
                    |Worth { value, each }: &Worth| match self.aim.as_ref().filter(|_| !each.is_empty()) {
                        Some(aim) => aim.value(each),
                        None => *value,
                    };
                let parent = self.parent.get(body.done).map(worth);
                let known = Known {
                    parent,
                    tuned: self.further.as_ref().map_or(0, |further| further.times),
                    ..self.known.clone()
                };
                let begin = warm.map(|curves| Warm { curves: curves.clone(), is_given: self.is_given });
                none.insert(Tuner::new(evaluator, streams, begin, self.bounds, known))
            }
        };
        if body.tuning.loops.is_none()
            && let Some(further) = self.further.as_ref().and_then(|further| further.tunings.get(body.done))
        {
            let aim = self.aim.as_ref().filter(|_| !task.beside.is_empty());
            body.tuning = further.again(aim);
        }
        tuner.advance(&mut body.tuning, spent)
    }
}

/// Curves for a body that was made of another: those of the other for the actuators that are still there, and
/// random ones for the rest. For each task; empty where the other has none.
pub(super) fn inherited(
    parent: &Candidate<'_>,
    tunes: &[Tune],
    own: &Candidate<'_>,
    random: &mut Stream,
) -> Vec<Parameters> {
    let inherit = |(task, tune): (&Task, &Tune)| {
        let drive = Drive::new(own, task).ok()?;
        let from = Drive::new(parent, task).ok()?;
        let fresh = drive.begin(random);
        Some(drive.inherit(&from, &tune.parameters, fresh))
    };
    let all: Option<Vec<_>> = own.rules.tasks.values().zip(tunes).map(inherit).collect();
    all.unwrap_or_default()
}

impl Body {
    /// Ends the task at hand with what was found for it.
    pub(super) fn close(&mut self) {
        let tuning = std::mem::take(&mut self.tuning);
        self.done += 1;
        self.tally.add(&tuning.tally);
        // From here on its value is what the task states.
        self.tunes.extend(tuning.found.clone().map(|tune| {
            let value = tune.each.first().copied().unwrap_or(tune.value);
            Tune { value, ..tune }
        }));
        self.tunings.push(tuning);
    }

    /// The temperature of the curves, and the best value of the task at hand.
    pub(super) fn progress(&self) -> (f64, Option<f64>) {
        let own = |found: &Tune| found.each.first().copied().unwrap_or(found.value);
        let value = self.tuning.found.as_ref().map(own);
        (self.tuning.temperature(), value)
    }

    /// What was found, and the value of all tasks together; and the evaluations that failed.
    pub(super) fn found(self, rules: &RuleSet, derivation: &Derivation) -> (Option<(Vec<Tune>, f64)>, Tally) {
        let mut tally = self.tally;
        if self.tunes.len() != rules.tasks.len() {
            return (None, tally);
        }
        let values: Vec<(&str, f64)> =
            rules.tasks.keys().map(String::as_str).zip(self.tunes.iter().map(|t| t.value)).collect();
        match crate::score::outcome(rules, derivation, &values) {
            Ok(value) => (Some((self.tunes, value)), tally),
            Err(error) => {
                tally.count(Missing::Expression(error));
                (None, tally)
            }
        }
    }
}
