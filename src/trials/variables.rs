//! Variables of actuations that change nothing.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::{Ty, Variable};
use grammar_lang::source::Span;

use super::{Trials, odd};
use crate::drive::Drive;
use crate::simulate::Targets;

/// A variable is changed so often in a motion, and at least so often in all.
const TRIES: usize = 3;
const ENOUGH: usize = 4;
/// Targets that differ by less are the same, to rounding, rad, m or rad/s.
const SAME: f64 = 1e-9;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    // How often each was changed; none once something came of it.
    let mut kinds: BTreeMap<(String, Span), Option<usize>> = BTreeMap::new();
    for trial in &trials.trials {
        let Some(drive) = trials.whole_drive(trial) else { continue };
        for moved in &trial.motions {
            if !moved.law.is_closed_loop() {
                change_each(&drive, &moved.parameters, &mut kinds);
            }
        }
    }
    // An actuation that is imported may have a variable for bodies of another kind.
    let idle = kinds.into_iter().filter(|((_, span), tries)| {
        !trials.text.is_varied && trials.text.entry == span.file && tries.is_some_and(|tries| tries >= ENOUGH)
    });
    let told = |((name, span), _): ((String, Span), _)| {
        odd(span, format!("the variable `{name}` changes nothing"))
            .label("with any of its values the actuators of short motions do the same")
            .help(
                "is it multiplied by zero, or does it shift a cycle by whole turns? Half a cycle is `1 / 2`",
            )
    };
    idle.map(told).collect()
}

/// Changes the values of a drive, one at a time.
fn change_each(drive: &Drive<'_>, parameters: &[f64], kinds: &mut BTreeMap<(String, Span), Option<usize>>) {
    let Ok(before) = drive.targets(parameters) else { return };
    let mut tried: BTreeMap<Span, usize> = BTreeMap::new();
    for ((place, variable), value) in drive.declared().enumerate().zip(parameters) {
        let seen = kinds.entry((variable.name.clone(), variable.span)).or_insert(Some(0));
        let tried = tried.entry(variable.span).or_default();
        let Some(tries) = seen.filter(|_| *tried < TRIES) else { continue };
        *tried += 1;
        let changes = others(variable, *value).into_iter().any(|other| {
            let mut changed = parameters.to_vec();
            changed[place] = other;
            drive.targets(&changed).is_ok_and(|after| differ(&before, &after))
        });
        *seen = if changes { None } else { Some(tries + 1) };
    }
}

/// Values that a variable may have besides this one.
fn others(variable: &Variable, value: f64) -> Vec<f64> {
    let (low, high) = variable.domain;
    match variable.ty {
        Ty::Bool => vec![1.0 - value],
        Ty::Count => vec![low, high],
        // Where a cycle is shifted, both ends may mean the same.
        _ => vec![low, high, low + 0.381_966 * (high - low)],
    }
}

fn differ(before: &Targets, after: &Targets) -> bool {
    before.angles.len() != after.angles.len()
        || before.angles.iter().zip(&after.angles).any(|(a, b)| (a - b).abs() > SAME)
}
