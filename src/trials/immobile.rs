//! Actuators that bend, and bodies that stay where they are.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::{Direction, Expr, ExprKind};
use grammar_lang::units::Dimension;

use super::{Trials, odd};

/// So many motions are looked at, at least.
const ENOUGH: usize = 4;
/// A core that is nowhere further than this from where it began stays there, m.
const LITTLE: f64 = 1e-4;
/// So far an actuator goes, at least: rad, or m.
const BENT: f64 = 0.3;
/// At so many moments it is looked where the core is.
const MOMENTS: u32 = 20;

pub(super) fn check(trials: &Trials<'_>) -> Option<Diagnostic> {
    let objective = &trials.trials.first()?.drive.task().objective;
    let mut still = 0;
    for (_, _, motion) in trials.motions() {
        let bent = motion.bends.iter().fold(0.0_f64, |most, bend| most.max(bend.abs()));
        let at = |moment: u32| {
            let time = motion.duration * f64::from(moment) / f64::from(MOMENTS);
            Some(motion.pose(0, time)?.translation.vector)
        };
        let start = at(0)?;
        if bent < BENT || (1..=MOMENTS).filter_map(at).any(|now| (now - start).norm() > LITTLE) {
            return None;
        }
        still += 1;
    }
    // What holds still on purpose is judged by something else: by what the tip of an arm does.
    let values = trials.values(&objective.value);
    let greatest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let is_little =
        objective.direction == Direction::Maximize && greatest * unit_of_length(&objective.value)? <= LITTLE;
    (still >= ENOUGH && values.len() == still && is_little).then(|| {
        odd(objective.value.span, "no short motion moves the core".to_owned())
            .label(format!("by more than 0.1 mm in any of {still} motions, although actuators bend"))
            .help("do the legs reach the ground when they bend? `turned` and the sign of the bend choose the side; `sgc view` shows the motion")
    })
}

/// The unit of an objective that is a length, m.
fn unit_of_length(value: &Expr) -> Option<f64> {
    match &value.kind {
        ExprKind::Convert(x, unit) if x.ty.dimension() == Some(Dimension::LENGTH) => Some(*unit),
        _ => None,
    }
}
