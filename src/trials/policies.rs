//! Policies with actions at random: what they know hardly changes or is cut off, and rewards fall where the objective rises.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::{Direction, Expr, ExprKind, Function, RuleSet, Ty};
use grammar_lang::source::FileId;

use super::{Trial, Trials, odd};
use crate::derive::random::Stream;
use crate::drive::{Conditions, Exploration, Explorer, INPUT_LIMIT};
use crate::score::{Recording, quantities};
use crate::search::{settings, solver};
use crate::simulate::{Stop, World};

/// How many motions are made with actions at random.
const MOTIONS: u64 = 16;
/// So many of them must have a value and a sum of rewards.
const ENOUGH: usize = 12;
/// A rank correlation below this is no accident: of twelve motions, it happens in one of two hundred rewards that have nothing to do with the objective.
const AGAINST: f64 = -0.7;

/// An input that changes by less in all motions says nothing.
const STEADY: f64 = 1e-3;

/// Decides at random, adds up what it gains, and remembers what it knew.
#[derive(Debug)]
struct AtRandom {
    outputs: usize,
    random: Stream,
    gained: f64,
    inputs: Vec<Seen>,
}

/// What was seen of an input.
#[derive(Clone, Copy, Debug)]
struct Seen {
    least: f64,
    most: f64,
    /// How often there was a value, and how often it was cut off.
    times: usize,
    cut_off: usize,
}

impl Seen {
    const NOTHING: Self = Self { least: f64::INFINITY, most: f64::NEG_INFINITY, times: 0, cut_off: 0 };

    fn see(&mut self, value: f64) {
        self.least = self.least.min(value);
        self.most = self.most.max(value);
        self.times += 1;
        self.cut_off += usize::from(value.abs() >= INPUT_LIMIT);
    }

    fn with(&mut self, other: &Self) {
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
        self.times += other.times;
        self.cut_off += other.cut_off;
    }
}

impl Explorer for AtRandom {
    fn gain(&mut self, reward: f64) {
        self.gained += reward;
    }

    fn decide(&mut self, side: usize, known: &[f64]) -> Vec<f64> {
        if side == 0 {
            self.inputs.resize(known.len(), Seen::NOTHING);
            self.inputs.iter_mut().zip(known).for_each(|(seen, value)| seen.see(*value));
        }
        // Where the greatest of several outputs is taken, each is as likely.
        (0..self.outputs).map(|_| 4.0 * self.random.unit() - 2.0).collect()
    }
}

/// What came of motions with random actions.
struct Explored {
    /// The sum of rewards of each, and its value.
    pairs: Vec<(f64, f64)>,
    inputs: Vec<Seen>,
}

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    let trial = trials.trials.first()?;
    trial.drive.decision()?;
    let explored = Explored::of(trial)?;
    input(trial, trials.text.entry, &explored.inputs).or_else(|| reward(trial, &explored.pairs))
}

/// An input of a policy that is nearly the same, or cut off, at all decisions.
fn input(trial: &Trial<'_>, entry: FileId, inputs: &[Seen]) -> Option<Diagnostic> {
    let known = trial.drive.decision()?.known;
    let reads = |e: &Expr| e.any(&mut |e| matches!(e.kind, ExprKind::Sensor(..)));
    // Whether a foot touches the ground may be the same for a while.
    let sensed = known
        .iter()
        .zip(inputs)
        .filter(|(input, seen)| input.ty != Ty::Bool && reads(input) && seen.times >= ENOUGH);
    for (input, seen) in sensed {
        let short = format!("in {MOTIONS} short motions with actions at random");
        if 2 * seen.cut_off > seen.times {
            let message = format!("this input of the policy is mostly cut off at {INPUT_LIMIT}");
            return Some(odd(input.span, message).label(format!("so {short}")).help(
                "divide it by a usual value, so that the number lies near -1 .. 1: `bent(a) / 60 deg`, `speed / (10 cm/s)`",
            ));
        }
        // A policy from another file may suit other bodies.
        if seen.most - seen.least < STEADY && input.span.file == entry {
            let message = "this input of the policy hardly changes".to_owned();
            return Some(odd(input.span, message).label(format!("from {:.4} to {:.4} {short}", seen.least, seen.most)).help(
                "does the sensor read the right axis and part? Divide by a usual value, so that the number lies near -1 .. 1",
            ));
        }
    }
    None
}

/// A reward that falls where the objective rises.
fn reward(trial: &Trial<'_>, pairs: &[(f64, f64)]) -> Option<Diagnostic> {
    let reward = trial.drive.decision()?.policy.reward.as_ref()?;
    let objective = &trial.drive.task().objective;
    // A distance has no sign: who goes back far is as good.
    if reads_distance(trial.drive.candidate().rules, &objective.value) {
        return None;
    }
    let sign = match objective.direction {
        Direction::Maximize => 1.0,
        Direction::Minimize => -1.0,
    };
    let (gained, values): (Vec<f64>, Vec<f64>) =
        pairs.iter().map(|(gain, value)| (*gain, sign * value)).unzip();
    (pairs.len() >= ENOUGH && rank_correlation(&gained, &values)? < AGAINST).then(|| {
        odd(reward.span, "this reward falls where the objective rises".to_owned())
            .label(format!("so in {} short motions with actions at random", pairs.len()))
            .also(objective.value.span, "of this objective")
            .help("a learner makes the reward large: is it subtracted the wrong way round? The way forward is the later position minus the earlier one")
    })
}

/// Whether it, or a term that it reads, is made of distances.
fn reads_distance(rules: &RuleSet, value: &Expr) -> bool {
    value.any(&mut |e| match &e.kind {
        ExprKind::Call(Function::Length | Function::Horizontal | Function::Abs, _) => true,
        ExprKind::Term(name) => rules.terms.get(name).is_some_and(|term| reads_distance(rules, &term.value)),
        _ => false,
    })
}

impl Explored {
    /// Motions with random actions.
    fn of(trial: &Trial<'_>) -> Option<Self> {
        let (drive, task) = (&trial.drive, trial.drive.task());
        let candidate = drive.candidate();
        let parameters = &trial.motions.first()?.parameters;
        let outputs = drive.decision()?.spaces.iter().map(|space| space.outputs()).sum();
        let mut simulation =
            solver(candidate.rules).model().prepare(&candidate.body.assembly, &settings(&task.model)).ok()?;
        let mut explored = Self { pairs: Vec::new(), inputs: Vec::new() };
        for number in 0..MOTIONS {
            let random = Stream::named(number, "trials of a reward");
            let mut explorer = AtRandom { outputs, random, gained: 0.0, inputs: Vec::new() };
            let conditions = Conditions { world: format!("motion {number}"), ..Conditions::NOMINAL };
            let exploration = Exploration::new(drive, parameters, &conditions, &mut explorer).ok()?;
            let motion = simulation.run_cases(Stop::NEVER, &[exploration.case(&World::NOMINAL)])?.pop()?;
            let (None, Ok(motion)) = (exploration.failed(), motion) else { continue };
            explored.inputs.resize(explorer.inputs.len(), Seen::NOTHING);
            explored.inputs.iter_mut().zip(&explorer.inputs).for_each(|(all, own)| all.with(own));
            let value = quantities(Recording::nominal(drive, parameters, &motion), &[&task.objective.value]);
            let value = value.ok().and_then(|mut values| values.pop());
            explored.pairs.extend(value.map(|value| (explorer.gained, value)));
        }
        Some(explored)
    }
}

/// Spearman's rank correlation; none where values are equal.
fn rank_correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let ranks = |of: &[f64]| -> Option<Vec<f64>> {
        let ties = of.iter().enumerate().any(|(place, x)| of[..place].contains(x));
        let rank = |x: &f64| of.iter().filter(|other| *other < x).count() as f64;
        (!ties).then(|| of.iter().map(rank).collect())
    };
    let count = a.len() as f64;
    let squares: f64 = ranks(a)?.iter().zip(ranks(b)?).map(|(x, y)| (x - y) * (x - y)).sum();
    Some(1.0 - 6.0 * squares / (count * (count * count - 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_two_lists_are_compared() {
        assert_eq!(rank_correlation(&[1.0, 2.0, 5.0], &[-3.0, 0.0, 9.0]), Some(1.0));
        assert_eq!(rank_correlation(&[1.0, 2.0, 5.0], &[9.0, 0.0, -3.0]), Some(-1.0));
        assert_eq!(rank_correlation(&[1.0, 1.0, 5.0], &[9.0, 0.0, -3.0]), None);
    }
}
