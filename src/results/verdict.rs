//! What cross-checks say of a saved design.

use grammar_lang::ir::{Direction, Objective, RuleSet, Task};
use grammar_lang::units::{self, Dimension};

use super::describe;
use super::saved::{Check, CheckOfAll, Measured, OfAll, SavedDesign, SavedTask};
use crate::search::{NOTHING, keeps};

/// How far a robot at rest goes by rounding and by the residue of its contacts, m, and how far it turns, rad.
const SHIFTS: f64 = 1e-6;
const TURNS: f64 = 1e-4 * std::f64::consts::PI / 180.0;
/// Where the unit does not tell a length, a speed or an angle, values that differ by less are the same, whatever the robot does.
const LEAST: f64 = 1e-9;
/// What a robot does with its actuators held still is noise; the values of a robot at rest differ by so many times as much at most.
const TIMES_HELD: f64 = 10.0;
/// A robot whose value exceeds that with its actuators held still by less than this share of the noise does not move: robots that
/// move exceed it by more.
const STILL: f64 = 0.01;

/// The name of the check that the search itself makes.
pub(super) const HALF_STEP: &str = "half the step, finer contacts";
/// What a robot does without its actuators is no work of theirs: it topples, rolls on, or trembles by an error of the solver.
pub(super) const HELD: &str = "its actuators held still";
/// Hinges are rigid sideways and do not twist; what actuators are made of gives way in every direction.
pub(super) const RODS: &str = "soft rods in place of hinges";
/// A centre of mass that stays this near on ice, m, has stayed: rounding is a hundredth of it.
pub(super) const STAYS: f64 = 2e-4;
/// The work in steps of the model is at most so many times as much as at half the step, or as little.
const WORKS_ALIKE: f64 = 1.5;

/// What a cross-check says of the value of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It holds there.
    Confirmed,
    /// It is not as good there as a best should be.
    Worse,
    /// It is so much better there that the value itself is no measure of it.
    Better,
    /// The value holds, but the work of the actuators does not.
    OtherWork,
    /// The robot does much of it by itself, with its actuators held.
    ByItself,
    /// There is nothing to compare, or the robot goes where nothing can go.
    Refuted,
    /// It says nothing, for or against.
    Silent,
}

impl Verdict {
    /// Whether the value holds; none where the check says nothing.
    #[must_use]
    pub fn agrees(self) -> Option<bool> {
        (self != Self::Silent).then_some(self == Self::Confirmed)
    }

    /// What is said beside the value; nothing where it holds.
    #[must_use]
    pub fn remark(self) -> &'static str {
        match self {
            Self::Confirmed | Self::Silent => "",
            Self::Better => "   (so much better that it is in doubt: see docs/physics.md)",
            Self::OtherWork => "   (energy and work are in doubt: see docs/physics.md)",
            Self::ByItself => "   (much of the value comes without the actuators: see docs/physics.md)",
            Self::Worse | Self::Refuted => "   (worse than a best should be: see docs/physics.md)",
        }
    }
}

/// Whether work that is so many times as much is about the same.
pub(super) fn works_alike(times: f64) -> bool {
    times.max(1.0 / times) <= WORKS_ALIKE
}

/// What a cross-check says of the value of a task. Both must be as good as the share of the other that the search asks for.
#[must_use]
pub fn verdict(rules: &RuleSet, saved: &SavedTask, check: &Check) -> Verdict {
    if matches!(check.measured, Measured::Unable | Measured::Sunk | Measured::Interlocked) {
        return Verdict::Silent;
    }
    let Some((task, other)) = rules.tasks.get(&saved.name).zip(check.value) else { return Verdict::Refuted };
    let share = share(rules, &check.name);
    let objective = &task.objective;
    let direction = objective.direction;
    let worlds = matches!(check.measured, Measured::InWorlds | Measured::Held);
    let value = if worlds { saved.value } else { saved.in_nominal() };
    let at_rest = saved.at_rest.unwrap_or_else(|| objective.offset(rules));
    match check.measured {
        // What comes of itself, beyond what there is where nothing moves.
        Measured::Held => {
            let gained = |value: f64| direction.fitness(value) - direction.fitness(at_rest);
            let much = (1.0 - rules.search.keep) * gained(value).abs();
            if gained(other) > much.max(noise(task, objective, saved)) {
                Verdict::ByItself
            } else {
                Verdict::Confirmed
            }
        }
        Measured::Drift if other <= STAYS => Verdict::Confirmed,
        Measured::Drift | Measured::Spin => Verdict::Refuted,
        Measured::Work if works_alike(other) => Verdict::Confirmed,
        Measured::Work => Verdict::OtherWork,
        Measured::Value | Measured::InWorlds => {
            compared(direction, at_rest, share, (value, other), noise(task, objective, saved))
        }
        Measured::Unable | Measured::Sunk | Measured::Interlocked => Verdict::Silent,
    }
}

/// By how much values of an objective differ, in its unit, if the robot does nothing: the same robot is judged alike in m/s and in mm/s.
fn noise(task: &Task, objective: &Objective, saved: &SavedTask) -> f64 {
    let unit = units::parse(&objective.unit).ok().filter(|_| !objective.unit.is_empty());
    let speed = Dimension::LENGTH.over(Dimension::TIME);
    match unit {
        Some(unit) if unit.dimension == Dimension::LENGTH => SHIFTS / unit.factor,
        Some(unit) if unit.dimension == Dimension::ANGLE => TURNS / unit.factor,
        Some(unit) if Some(unit.dimension) == speed => SHIFTS / task.model.duration / unit.factor,
        _ => {
            let by_itself = held(saved).zip(saved.at_rest).map(|(held, at_rest)| (held - at_rest).abs());
            by_itself.map_or(NOTHING, |by_itself| (TIMES_HELD * by_itself).clamp(LEAST, NOTHING))
        }
    }
}

/// What a task comes to with the actuators held still, if that is known.
fn held(saved: &SavedTask) -> Option<f64> {
    saved.checks.iter().find(|check| check.measured == Measured::Held)?.value
}

/// What another value says of a value, which is given first.
fn compared(
    direction: Direction,
    at_rest: f64,
    share: f64,
    (value, other): (f64, f64),
    noise: f64,
) -> Verdict {
    // What does not move differs by rounding only.
    if (other - value).abs() < noise {
        Verdict::Confirmed
    } else if !keeps(direction, at_rest, share, value, other) {
        Verdict::Worse
    } else if !keeps(direction, at_rest, share, other, value) {
        Verdict::Better
    } else {
        Verdict::Confirmed
    }
}

/// What a cross-check of all objectives says: each of them must hold.
#[must_use]
pub fn verdict_of_all(rules: &RuleSet, design: &SavedDesign, of_all: &OfAll, check: &CheckOfAll) -> Verdict {
    let share = share(rules, &check.name);
    let Some((task, first)) = rules.tasks.values().next().zip(design.tasks.first()) else {
        return Verdict::Refuted;
    };
    let objectives = std::iter::once(&rules.objective).chain(rules.beside());
    let saved = std::iter::once(design.value).chain(design.beside.iter().map(|beside| beside.value));
    if check.values.len() != 1 + design.beside.len() {
        return Verdict::Refuted;
    }
    let at_rest = of_all.at_rest.iter().copied().chain(std::iter::repeat(0.0));
    let all = objectives.zip(at_rest).zip(saved.zip(&check.values));
    let verdicts = all.map(|((objective, at_rest), (value, other))| {
        let noise = noise(task, objective, first);
        compared(objective.direction, at_rest, share, (value, *other), noise)
    });
    let broken = |verdict: &Verdict| *verdict != Verdict::Confirmed;
    // What is lost says more than what is gained.
    let found: Vec<Verdict> = verdicts.filter(broken).collect();
    let worse = found.iter().find(|verdict| **verdict == Verdict::Worse);
    worse.or(found.first()).copied().unwrap_or(Verdict::Confirmed)
}

/// The share of a value that must hold in a check of a name.
fn share(rules: &RuleSet, name: &str) -> f64 {
    match rules.search.keep_with_rods {
        Some(share) if name == RODS => share,
        _ => rules.search.keep,
    }
}

/// Whether a design does no better, in any task, than with its actuators held still, or all tasks together are no better than where
/// nothing moves.
#[must_use]
pub fn stands_still(rules: &RuleSet, design: &SavedDesign) -> bool {
    let is_no_better = |saved: &SavedTask| {
        let (task, held) = rules.tasks.get(&saved.name).zip(held(saved))?;
        let direction = task.objective.direction;
        let gained = direction.fitness(saved.value) - direction.fitness(held);
        Some(gained < STILL * noise(task, &task.objective, saved))
    };
    let together = || {
        let at_rest = *design.of_all.as_ref()?.at_rest.first()?;
        let direction = rules.objective.direction;
        Some(rules.tasks.len() > 1 && direction.fitness(design.value) <= direction.fitness(at_rest))
    };
    design.tasks.iter().all(|saved| is_no_better(saved) == Some(true)) || together() == Some(true)
}

/// Of how many cross-checks that say anything of a design its value was kept in how many.
#[must_use]
pub fn kept(rules: &RuleSet, design: &SavedDesign) -> (usize, usize) {
    let all =
        design.tasks.iter().flat_map(|task| task.checks.iter().map(move |check| verdict(rules, task, check)));
    let together = design.of_all.iter().flat_map(|of_all| {
        of_all.checks.iter().map(move |check| verdict_of_all(rules, design, of_all, check))
    });
    let (mut kept, mut told) = (0, 0);
    for verdict in all.chain(together) {
        kept += usize::from(verdict == Verdict::Confirmed);
        told += usize::from(verdict != Verdict::Silent);
    }
    (kept, told)
}

/// The cross-checks that say nothing of a design, by name.
pub fn silent<'d>(rules: &'d RuleSet, design: &'d SavedDesign) -> impl Iterator<Item = &'d str> {
    let is_silent = |task: &SavedTask, check: &Check| verdict(rules, task, check) == Verdict::Silent;
    design.tasks.iter().flat_map(move |task| {
        task.checks.iter().filter(move |check| is_silent(task, check)).map(|check| check.name.as_str())
    })
}

/// What a cross-check came to, in words: a value as the design's own is, less what its broken preferences take away.
#[must_use]
pub fn outcome(rules: &RuleSet, design: &SavedDesign, saved: &SavedTask, check: &Check) -> String {
    let direction = rules.tasks.get(&saved.name).map_or(rules.objective.direction, |t| t.objective.direction);
    match (check.value, check.measured) {
        (_, Measured::Unable) if check.name == RODS => {
            let why = check.why.as_deref().unwrap_or("they cannot hold the joints of this body");
            format!("no second opinion: {why}")
        }
        (_, Measured::Unable) if check.name == HELD => check.why.clone().unwrap_or_default(),
        (_, Measured::Unable) => "no second opinion: it cannot hold the joints of this body".to_owned(),
        (depth, Measured::Sunk) => {
            let depth = describe::quantity(1000.0 * depth.unwrap_or(0.0), "mm");
            format!(
                "no second opinion: its floor is soft, and an element sinks in to {depth} below its centre"
            )
        }
        (depth, Measured::Interlocked) => {
            let depth = describe::quantity(1000.0 * depth.unwrap_or(0.0), "mm");
            format!(
                "no second opinion: its contacts are soft, and the centre of an element gets {depth} into another one"
            )
        }
        (None, _) => check.why.clone().unwrap_or_else(|| "the motion is not valid".to_owned()),
        (Some(value), Measured::Value | Measured::InWorlds | Measured::Held) => {
            describe::quantity(design.less_penalties(direction, value), &saved.unit)
        }
        (Some(spin), Measured::Spin) => {
            format!("it turns by {} without a cause", describe::quantity(spin.to_degrees(), "deg"))
        }
        (Some(share), Measured::Work) => format!("{share:.2} times as much"),
        (Some(drift), Measured::Drift) if drift <= STAYS => "it stays in place, as it should".to_owned(),
        (Some(drift), Measured::Drift) => {
            format!("its centre of mass drifts by {}", describe::quantity(100.0 * drift, "cm"))
        }
    }
}

/// What a cross-check of all objectives came to, in words.
#[must_use]
pub fn outcome_of_all(design: &SavedDesign, check: &CheckOfAll) -> String {
    let Some((first, others)) = check.values.split_first() else {
        return check.why.clone().unwrap_or_else(|| "the motion is not valid".to_owned());
    };
    let mut out = describe::quantity(*first, &design.unit);
    for (beside, value) in design.beside.iter().zip(others) {
        out.push_str(&format!(", {} {}", beside.objective, describe::quantity(*value, &beside.unit)));
    }
    out
}
