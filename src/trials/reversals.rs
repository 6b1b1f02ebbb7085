//! Drives that turn round far more often than an actuator can follow.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::source::Span;

use super::{Trials, odd};
use crate::simulate::Targets;

/// More turns in a second than this are too many: ten swings.
const MOST: f64 = 20.0;
/// A turn counts if the way since the last one is so much of the whole way, at least.
const FAR: f64 = 0.2;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let mut actuations: BTreeMap<(String, Span), f64> = BTreeMap::new();
    for trial in &trials.trials {
        for (actuator, name, span) in trial.drive.driven_ahead() {
            for moved in &trial.motions {
                let rate = turns(&moved.law.targets, actuator) / trial.drive.task().model.duration;
                let least = actuations.entry((name.to_owned(), span)).or_insert(f64::MAX);
                *least = least.min(rate);
            }
        }
    }
    let fast = actuations.into_iter().filter(|(_, least)| *least > MOST);
    let told = |((name, span), least): ((String, Span), f64)| {
        odd(span, format!("`{name}` changes its direction at least {least:.0} times a second"))
            .label("no actuator follows that")
            .help("is an angle in radians where degrees are meant, or a period in milliseconds? A full turn is `360 deg`")
    };
    fast.map(told).collect()
}

/// How often the target of an actuator turns round.
fn turns(targets: &Targets, actuator: usize) -> f64 {
    let all: Vec<f64> =
        (0..targets.samples()).map(|sample| targets.at(actuator, sample as f64 * targets.interval)).collect();
    let (low, high) = all.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    let far = FAR * (high - low);
    let Some(&first) = all.first() else { return 0.0 };
    if far <= 1e-6 {
        return 0.0;
    }
    let (mut extreme, mut sign, mut turns) = (first, 0.0, 0.0);
    for &x in &all {
        if sign * (x - extreme) >= 0.0 && sign != 0.0 {
            extreme = x;
        } else if (x - extreme).abs() > far {
            turns += f64::from(u8::from(sign != 0.0));
            sign = (x - extreme).signum();
            extreme = x;
        }
    }
    turns
}
