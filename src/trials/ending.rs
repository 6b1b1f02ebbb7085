//! Drives that come to their end long before the motion does.

use grammar_lang::diagnostics::Diagnostic;

use super::{Trials, odd};
use crate::design::assembly::Control;
use crate::simulate::Targets;

/// In a shorter motion, s, a pose that is held is what is looked at.
const SHORT: f64 = 5.0;
/// So much of the motion the actuators must be asked for something new.
const SHARE: f64 = 0.2;
/// What is asked for less is nothing new, rad or m.
const LEAST: f64 = 1e-6;

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    let mut last = 0.0_f64;
    let mut known = None;
    for trial in &trials.trials {
        let drive = trials.whole_drive(trial)?;
        let duration = drive.task().model.duration;
        let body = &trial.drive.candidate().body.assembly;
        let is_spun = body
            .joints
            .iter()
            .flat_map(|joint| joint.kind.dofs())
            .any(|dof| matches!(dof.control, Control::Speed { .. }));
        // A motor that is asked for the same speed goes on.
        if is_spun || duration < SHORT {
            return None;
        }
        for moved in &trial.motions {
            if moved.law.is_closed_loop() {
                return None;
            }
            last = last.max(last_change(&drive.targets(&moved.parameters).ok()?));
        }
        let (_, name, span) = trial.drive.driven_ahead().next()?;
        known.get_or_insert((name.to_owned(), span, duration));
    }
    let (name, span, duration) = known?;
    (last > 0.0 && last < SHARE * duration).then(|| {
        odd(
            span,
            format!("`{name}` asks for nothing new in the last {:.0} s of {duration:.0} s", duration - last),
        )
        .label(format!("after {last:.1} s, always the same"))
        .help("let the drive repeat, as `sin(t / period * 360 deg)` does, or simulate for a shorter time")
    })
}

/// When an actuator is asked for something else than before for the last time, s.
fn last_change(targets: &Targets) -> f64 {
    let rows: Vec<&[f64]> = targets.angles.chunks(targets.actuators.max(1)).collect();
    let changes = |pair: &[&[f64]]| match pair {
        [a, b] => a.iter().zip(*b).any(|(a, b)| (a - b).abs() > LEAST),
        _ => false,
    };
    rows.windows(2).rposition(changes).map_or(0.0, |place| (place + 1) as f64 * targets.interval)
}
