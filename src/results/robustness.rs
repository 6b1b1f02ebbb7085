//! What a best design is checked with before anybody believes its value: other steps, another solver, another world.

use grammar_lang::ir::RuleSet;

use super::DesignError;
use super::describe;
use super::replay::{Precision, Trial, candidate, replay_task};
use super::saved::{Check, Measured, SavedDesign, SavedTask};
use super::shift::Shift;
use crate::search::keeps;
use crate::simulate::{SolverName, Stop};

/// The names of the checks that every final best goes through.
pub(super) const HALF_STEP: &str = "half the step, finer contacts";
/// What keeps its value at half the step may still live on an error that is slow to show.
const EIGHTH: &str = "an eighth of the step, finer contacts";
/// Nothing carries a body away on a floor without friction, but errors of the solver do.
const ICE: &str = "a floor of ice";
/// A centre of mass that stays this near on ice, m, has stayed: rounding is a hundredth of it.
const STAYS: f64 = 2e-4;
const RAPIER: &str = SolverName::Rapier.text();
/// By how much friction, masses and motors are moved, one after the other.
const SHIFTS: [(&str, Shift); 6] = [
    ("friction 10 % lower", Shift::Friction(0.9)),
    ("friction 10 % higher", Shift::Friction(1.1)),
    ("masses 10 % lower", Shift::Mass(0.9)),
    ("masses 10 % higher", Shift::Mass(1.1)),
    ("motors 10 % weaker", Shift::Motors(0.9)),
    ("motors 10 % stronger", Shift::Motors(1.1)),
];

/// Adds what a final best is checked with: half the step, where the search had
/// no need to, an eighth of it, the opinion of the reference solver, and other friction, masses and motors.
///
/// # Errors
///
/// A sentence that says what does not fit, or that it was stopped.
pub fn final_check(
    rules: &RuleSet,
    design: &SavedDesign,
    stop: Stop<'_>,
) -> Result<SavedDesign, DesignError> {
    let mut design = design.clone();
    let candidate = candidate(rules, &design)?;
    let solver = design.solver.as_str();
    let plain = Trial { solver, precision: Precision::Model, shift: None, stop };
    let mut trials = vec![
        (HALF_STEP, Trial { precision: Precision::Finer, ..plain }),
        (EIGHTH, Trial { precision: Precision::Finest, ..plain }),
        (ICE, Trial { shift: Some(Shift::Ice), ..plain }),
    ];
    if solver != RAPIER {
        trials.push((RAPIER, Trial { solver: RAPIER, ..plain }));
        trials.extend(SHIFTS.map(|(name, shift)| (name, Trial { shift: Some(shift), ..plain })));
    }
    for saved in &mut design.tasks {
        for &(name, trial) in &trials {
            if saved.checks.iter().all(|check| check.name != name) {
                // A check without a value does not confirm: the best stands, and says so.
                let replayed = replay_task(&candidate, saved, trial);
                // One that was given up says nothing.
                if replayed.is_err() && stop.is_asked() {
                    return Err(DesignError::Stopped("all cross-checks were made"));
                }
                let measured =
                    if trial.shift == Some(Shift::Ice) { Measured::Drift } else { Measured::Value };
                let value = replayed.ok().and_then(|replayed| match measured {
                    Measured::Value => Some(replayed.score?.value),
                    Measured::Drift => Some(replayed.motion.ok()?.drift(&candidate.body.assembly)),
                });
                saved.checks.push(Check { name: name.to_owned(), value, measured });
            }
        }
    }
    Ok(design)
}

/// What a cross-check says of the value of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It holds there.
    Confirmed,
    /// It is not worth as much there as a best should be.
    Worse,
    /// It is worth so much more there that the value itself is no measure of it.
    Better,
    /// There is nothing to compare, or the robot goes where nothing can go.
    Refuted,
}

impl Verdict {
    /// What is said beside the value; nothing where it holds.
    #[must_use]
    pub fn remark(self) -> &'static str {
        match self {
            Self::Confirmed => "",
            Self::Better => "   (so much more that it is in doubt: see docs/physics.md)",
            Self::Worse | Self::Refuted => "   (less than a best should keep: see docs/physics.md)",
        }
    }
}

/// What a cross-check says of the value of a task. Both must be as good as the share of the other that the search asks for.
#[must_use]
pub fn verdict(rules: &RuleSet, saved: &SavedTask, check: &Check) -> Verdict {
    let Some((task, other)) = rules.tasks.get(&saved.name).zip(check.value) else { return Verdict::Refuted };
    match check.measured {
        Measured::Drift if other <= STAYS => Verdict::Confirmed,
        Measured::Drift => Verdict::Refuted,
        Measured::Value if !keeps(rules, task, saved.value, other) => Verdict::Worse,
        Measured::Value if !keeps(rules, task, other, saved.value) => Verdict::Better,
        Measured::Value => Verdict::Confirmed,
    }
}

/// Whether a cross-check confirms the value of a task.
#[must_use]
pub fn confirmed(rules: &RuleSet, saved: &SavedTask, check: &Check) -> bool {
    verdict(rules, saved, check) == Verdict::Confirmed
}

/// What a cross-check came to, in words.
#[must_use]
pub fn outcome(saved: &SavedTask, check: &Check) -> String {
    match (check.value, check.measured) {
        (None, _) => "not a valid motion".to_owned(),
        (Some(value), Measured::Value) => describe::quantity(value, &saved.unit),
        (Some(drift), Measured::Drift) if drift <= STAYS => "it gets nowhere, as it should".to_owned(),
        (Some(drift), Measured::Drift) => {
            format!("its centre of mass goes {} astray", describe::quantity(100.0 * drift, "cm"))
        }
    }
}
