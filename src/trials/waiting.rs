//! Drives that wait in the time that a short motion shows: then it says nothing about what the robot does.

use super::{Moved, Trial, Trials};
use crate::simulate::Targets;

/// A drive waits if in the first half of a short motion it asks for less than this share of what it asks for in the whole time.
const LITTLE: f64 = 0.1;

/// Whether the actuators of some motion wait: they are asked for little at first, and for more later.
pub(super) fn check(trials: &Trials<'_>) -> bool {
    trials.trials.iter().any(|trial| {
        trials.whole_drive(trial).is_some_and(|drive| {
            trial.motions.iter().any(|moved| {
                !moved.law.is_closed_loop()
                    && drive.targets(&moved.parameters).is_ok_and(|whole| waits(trial, moved, &whole))
            })
        })
    })
}

fn waits(trial: &Trial<'_>, moved: &Moved<'_>, whole: &Targets) -> bool {
    let half = moved.law.targets.samples() / 2;
    let all = (0..trial.drive.candidate().body.actuators.len())
        .map(|actuator| (swing(&moved.law.targets, actuator, half), swing(whole, actuator, whole.samples())));
    let (first, later) = all.fold((0.0_f64, 0.0_f64), |most, own| (most.0.max(own.0), most.1.max(own.1)));
    first < LITTLE * later
}

/// The difference between the greatest and the least target of an actuator in the first samples; a motor that begins with its speed has gone
/// that far, too.
fn swing(targets: &Targets, actuator: usize, samples: usize) -> f64 {
    let asked = targets.angles.iter().skip(actuator).step_by(targets.actuators.max(1)).take(samples);
    let (low, high) = asked.fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    high - low
}
