//! What a search will cost, said before it starts: how long a body takes to simulate here, and how much memory.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use grammar_lang::ir::RuleSet;

use super::progress::span;
use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation};
use crate::drive::Drive;
use crate::search::settings;
use crate::simulate::{Model, Stop, World};

/// So many random moves make a body that is tried out.
const MOVES: usize = 30;
/// So much of a motion is simulated, s.
const SHARE: f64 = 2.0;
/// Neither the moves nor the motion take longer than this.
const LONGEST: Duration = Duration::from_secs(2);
/// Less memory than this is nothing to speak of.
const MUCH: f64 = 100e6;

/// A line on what one evaluation and all of them cost; nothing, if that cannot be told. The body is one that the
/// rules make by chance: later ones may be larger. Whatever it says, the search does not depend on it.
pub(super) fn told(
    rules: &RuleSet,
    first: &Derivation,
    model: &dyn Model,
    evaluations: Option<u64>,
    flag: &AtomicBool,
) -> Option<String> {
    let mut random = Stream::named(0, "price");
    let mut derivation = first.clone();
    let begun = Instant::now();
    for _ in (0..MOVES).take_while(|_| begun.elapsed() < LONGEST) {
        if let Some(next) = derivation.advance(rules, &mut random, 0.0).result {
            derivation = next;
        }
    }
    let candidate = Candidate::new(rules, Arc::new(derivation));
    let task = rules.first_task()?;
    let drive = Drive::new(&candidate, task).ok()?;
    let mut settings = settings(&task.model);
    let whole = settings.duration;
    settings.duration = whole.min(SHARE);
    settings.pace_limit = None;
    let mut simulation = model.prepare(&candidate.body.assembly, &settings).ok()?;
    // As many gaits as the search has side by side at best: two of them never cost twice as much as one.
    let lanes = simulation.lanes();
    let laws: Result<Vec<_>, _> = (0..lanes).map(|_| drive.control_law(&drive.draw(&mut random))).collect();
    let laws = laws.ok()?;
    let cases: Vec<_> = laws.iter().map(|law| law.case(&World::NOMINAL)).collect();
    let begun = Instant::now();
    let done = simulation.run_cases(Stop::new(flag, Some(begun + LONGEST)), &cases).is_some();
    let tasks = rules.tasks.len() as f64;
    let one = begun.elapsed().mul_f64(tasks * whole / settings.duration / lanes as f64);
    let elements = candidate.body.assembly.elements.len();
    let more = if done { "about" } else { "more than" };
    let all = evaluations.map_or(String::new(), |all| {
        let seconds = one.as_secs_f64() * all as f64;
        format!(
            "; {all} of them take {} on one thread, and longer if fewer run side by side",
            if seconds > 1e9 {
                "more than 30 years".to_owned()
            } else {
                span(Duration::from_secs_f64(seconds))
            }
        )
    });
    // Each frame of each body is seven numbers, and all that go on side by side are there at once.
    let bytes = whole / settings.record * elements as f64 * 56.0 * lanes as f64;
    let memory = if bytes > MUCH {
        format!("; its motions need {:.1} GB of memory", bytes / 1e9)
    } else {
        String::new()
    };
    let memory = memory + &remembered(rules, &drive, evaluations, whole).unwrap_or_default();
    let learning = rules.search.curves.as_ref().is_some_and(|curves| curves.method.learner().is_some());
    let learning =
        if learning { "; what the networks learn between motions takes time of its own" } else { "" };
    let beside = if lanes > 1 { format!(", {lanes} side by side") } else { String::new() };
    Some(format!(
        "measured on a body of {elements} elements: an evaluation takes {more} {}{beside}{all}{learning}{memory}",
        short(one)
    ))
}

/// How much a learner remembers, where that is much.
fn remembered(rules: &RuleSet, drive: &Drive<'_>, evaluations: Option<u64>, duration: f64) -> Option<String> {
    let learner = rules.search.curves.as_ref()?.method.learner()?;
    let decision = drive.decision()?;
    let in_a_motion = duration / (drive.task().model.control * decision.pace as f64);
    let made =
        evaluations.map_or(f64::INFINITY, |motions| motions as f64 * in_a_motion * decision.sides as f64);
    // All that was known, done and gained, in 32 bits.
    let numbers = decision.known.len() + decision.spaces.len() + 1;
    let bytes = made.min(learner.replay as f64) * 4.0 * numbers as f64;
    let gigabytes = bytes / 1e9;
    (bytes > MUCH).then(|| format!("; the replay buffer of the learner takes up to {gigabytes:.1} GB, in memory and in each checkpoint (`replay` limits it)"))
}

/// A time with its unit: milliseconds, or as [`span`] has it.
fn short(time: Duration) -> String {
    let ms = time.as_secs_f64() * 1e3;
    if ms < 10.0 {
        format!("{:.1} ms", ms.max(0.1))
    } else if ms < 1000.0 {
        format!("{ms:.0} ms")
    } else {
        span(time)
    }
}
