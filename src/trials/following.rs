//! Actuators that hardly follow what drives them.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::source::Span;

use super::{Trials, odd};

/// An actuator follows if it goes so much of the way that it is asked for in one motion, at least.
const FOLLOWS: f64 = 0.15;
/// So many ways are looked at, at least.
const ENOUGH: usize = 4;
/// What is asked for less than this is no way, rad, m or rad/s.
const LEAST: f64 = 1e-3;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let mut kinds: BTreeMap<(String, Span), (usize, f64)> = BTreeMap::new();
    for (trial, moved, motion) in trials.motions() {
        let actuators = &trial.drive.candidate().body.actuators;
        for (place, _, _) in trial.drive.driven_ahead() {
            let targets = &moved.law.targets;
            let asked = swing((0..targets.samples()).map(|n| targets.at(place, n as f64 * targets.interval)));
            let got = swing(motion.bends.iter().skip(place).step_by(actuators.len()).copied());
            let Some((kind, span)) = actuators.get(place).and_then(|id| trial.kind(*id)) else { continue };
            if asked > LEAST {
                let seen = kinds.entry((kind.to_owned(), span)).or_default();
                *seen = (seen.0 + 1, seen.1.max(got / asked));
            }
        }
    }
    let told = |((kind, span), (ways, most)): (&(String, Span), &(usize, f64))| {
        (*ways >= ENOUGH && *most < FOLLOWS).then(|| {
            odd(*span, format!("`{kind}` hardly follows what drives it"))
                .label(format!("it goes at most {:.0} % of the way that it is asked for", 100.0 * most))
                .help("is the torque too small for the weight, or the speed for the period?")
        })
    };
    kinds.iter().filter_map(told).collect()
}

/// From the least to the greatest of some numbers.
fn swing(all: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = all.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    (high - low).max(0.0)
}
