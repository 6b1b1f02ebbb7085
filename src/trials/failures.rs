//! Tasks of which no motion succeeds.

use grammar_lang::diagnostics::Diagnostic;

use super::{Trials, odd};
use crate::simulate::Invalid;

/// So many motions must have failed.
const ENOUGH: usize = 4;

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    let all: Vec<_> = trials.trials.iter().flat_map(|trial| &trial.motions).collect();
    let causes: Vec<_> = all.iter().filter_map(|moved| moved.motion.as_ref().err()).collect();
    if all.len() < ENOUGH || causes.len() < all.len() {
        return None;
    }
    let often = |cause: &&&Invalid| causes.iter().filter(|other| other == cause).count();
    let cause = causes.iter().max_by_key(often)?;
    let task = trials.trials.first()?.drive.task();
    Some(
        odd(task.objective.value.span, format!("all of {} short motions fail", all.len()))
            .label(format!("the most frequent reason: {}", cause.describe()))
            .help(match cause {
                Invalid::NoCommand => "a drive, a state or an input comes to a number that is not finite: look for a division by zero, and for states that grow without bound",
                Invalid::TooFast => "is the `speed_limit` of the model below what its actuators can reach? Compare speeds, torques and masses with those of a grammar that works",
                _ => "compare the step, the speeds, torques and masses with those of a grammar that works; `sgc run` with `--max-evals 50` counts the reasons",
            }),
    )
}
