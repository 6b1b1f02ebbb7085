//! What a best design is checked with before anybody believes its value: other steps, another solver, another world.

use grammar_lang::ir::{RuleSet, Task};
use rayon::prelude::*;

use super::DesignError;
use super::describe;
use super::elsewhere::{values, values_and_whole};
use super::replay::{Driven, How, Precision, candidate, replay_task};
use super::saved::{Check, InWorld, Measured, SavedDesign, SavedTask};
use crate::derive::Candidate;
use crate::scenarios::{self, Scenario};
use crate::score::{self, Recording};
use crate::search::{NOTHING, keeps};
use crate::simulate::{Invalid, SolverName, Stop, rod};

/// The names of the checks that every final best goes through.
pub(super) const HALF_STEP: &str = "half the step, finer contacts";
/// What keeps its value at half the step may still live on an error that is slow to show.
const EIGHTH: &str = "an eighth of the step, finer contacts";
/// A value over worlds is checked in all of them.
const IN_WORLDS: &str = "an eighth of the step, in all worlds";
/// What a robot does without its actuators is no work of theirs: it topples, rolls on, or trembles by an error of the solver.
const HELD: &str = "its actuators held still";
/// Nothing carries a body away on a floor without friction, but errors of the solver do.
const ICE: &str = "a floor of ice";
/// A centre of mass that stays this near on ice, m, has stayed: rounding is a hundredth of it.
const STAYS: f64 = 2e-4;
/// A body that turns by less on ice, rad, faces where it faced: what trembles between two frames adds up to a hundredth of it.
const FACES: f64 = 0.05;
/// Frames a second that tell what angular momentum does: parts of soft bodies tremble a hundred times a second.
const OFTEN: f64 = 240.0;
/// Joints that tremble hardly move the body, so its value holds, but they work.
const WORK: &str = "half the step (energy)";
/// The work in steps of the model is at most so many times as much as at half the step, or as little.
const WORKS_ALIKE: f64 = 1.5;
/// Less work in a motion, J, is as good as none.
const NO_WORK: f64 = 1e-3;
const RAPIER: &str = SolverName::Rapier.text();
/// Hinges are rigid sideways and do not twist; what actuators are made of gives way in every direction.
const RODS: &str = "soft rods in place of hinges";

/// Adds what a final best is checked with: half the step, where the search had no need to, an eighth of it, the opinion of
/// the reference solver, rods in place of hinges, the worlds that the search names for that; and how it does in worlds that the search never saw,
/// where its task names scenarios.
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
    let solver = design.solver.clone();
    let model = How { solver: &solver, precision: Precision::Model, stop };
    for saved in &mut design.tasks {
        let task = &*saved;
        // One by one they keep one thread busy for seconds; side by side they are the same.
        let ((opinions, ((ice, held), work)), (worlds, tests)) = rayon::join(
            || {
                let ice = || on_ice(&candidate, task, model);
                let work = || work(&candidate, task, model);
                let ice = || (ice(), held(&candidate, task, model));
                rayon::join(|| opinions(&candidate, task, model), || rayon::join(ice, work))
            },
            || {
                let elsewhere = || (in_worlds(&candidate, task, model), elsewhere(&candidate, task, model));
                rayon::join(elsewhere, || tests(&candidate, task, model))
            },
        );
        given_up(stop)?;
        let (whole, worlds) = worlds;
        saved.checks.extend(opinions);
        saved.checks.extend(whole);
        saved.checks.push(Check::new(WORK, Measured::Work, work));
        saved.checks.push(ice);
        saved.checks.extend(held);
        let is_new = |checks: &[Check], one: &Check| checks.iter().all(|check| check.name != one.name);
        for one in worlds? {
            if is_new(&saved.checks, &one) {
                saved.checks.push(one);
            }
        }
        (saved.tests, saved.tested) = tests?;
    }
    Ok(design)
}

/// The value at other steps and with the reference solver, where that is not known yet.
fn opinions(candidate: &Candidate<'_>, saved: &SavedTask, model: How<'_>) -> Vec<Check> {
    let others = [
        // The longest first.
        (RAPIER, How { solver: RAPIER, ..model }),
        (RODS, How { solver: SolverName::Rod.text(), ..model }),
        (EIGHTH, How { precision: Precision::Finest, ..model }),
        (HALF_STEP, How { precision: Precision::Finer, ..model }),
    ];
    // Of itself a solver has no other opinion; where nothing bends, rods are nothing else than joints.
    let is_another = |name: &str, how: &How<'_>| match name {
        RAPIER => how.solver != model.solver,
        RODS => how.solver != model.solver && rod::bends(&candidate.body.assembly),
        _ => true,
    };
    let is_known = |name: &str| saved.checks.iter().any(|check| check.name == name);
    let others: Vec<_> =
        others.into_iter().filter(|(name, how)| is_another(name, how) && !is_known(name)).collect();
    let mut checks: Vec<Check> = others
        .into_par_iter()
        .map(|(name, how)| {
            let opinion = opinion(candidate, saved, how);
            let measured = match &opinion {
                Err(DesignError::Unfit(_)) | Ok(Err(Invalid::BeyondLimits | Invalid::Unfit)) => {
                    Measured::Unable
                }
                // Its contacts are soft: what stands on little feet may sink, and is stuck there.
                Ok(Ok((value, depth))) if name == RAPIER && *depth > 0.0 => {
                    let own = Check::new(name, Measured::Value, Ok(*value));
                    let agrees = verdict(candidate.rules, saved, &own) == Verdict::Confirmed;
                    return if agrees { own } else { Check::new(name, Measured::Sunk, Ok(*depth)) };
                }
                _ => Measured::Value,
            };
            // A check without a value does not confirm: the best stands, and says so.
            let value = opinion.and_then(|opinion| Ok(opinion.map(|(value, _)| value)?));
            Check::new(name, measured, value)
        })
        .collect();
    checks.sort_by_key(|check| [HALF_STEP, EIGHTH, RAPIER, RODS].iter().position(|name| *name == check.name));
    checks
}

/// The value in the nominal world, and how far the centre of an element gets below the floor, m; zero if none does.
fn opinion(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    how: How<'_>,
) -> Result<Result<(f64, f64), Invalid>, DesignError> {
    let driven = Driven::new(candidate, saved, how.precision)?;
    let nominal = Scenario::nominal();
    let motion = match driven.motion_in(&nominal, how.solver, how.stop)? {
        Ok(motion) => motion,
        Err(why) => return Ok(Err(why)),
    };
    let value = score::objective(driven.recording(&motion, Some(&nominal)))?;
    Ok(Ok((value, motion.depth())))
}

/// What was given up says nothing.
fn given_up(stop: Stop<'_>) -> Result<(), DesignError> {
    if stop.is_asked() { Err(DesignError::Stopped("all cross-checks were made")) } else { Ok(()) }
}

/// How far the centre of mass gets on ice, m; or by how much the body turns there, rad, if it stays in place but turns too far.
fn on_ice(candidate: &Candidate<'_>, saved: &SavedTask, how: How<'_>) -> Check {
    let found = || -> Result<(f64, f64), DesignError> {
        let driven = Driven::new(candidate, saved, how.precision)?;
        let often = Driven::new(candidate, saved, how.precision)?.recorded_often(OFTEN);
        let motion =
            often.as_ref().unwrap_or(&driven).motion_in(&Scenario::ice(), how.solver, how.stop)??;
        let spin = if often.is_some() { motion.spin(&candidate.body.assembly) } else { 0.0 };
        Ok((motion.drift(&candidate.body.assembly), spin))
    };
    match found() {
        Ok((drift, spin)) if drift <= STAYS && spin > FACES => Check::new(ICE, Measured::Spin, Ok(spin)),
        found => Check::new(ICE, Measured::Drift, found.map(|(drift, _)| drift)),
    }
}

/// What the task is worth with all actuators held where they begin, over all worlds that its value depends on.
fn held(candidate: &Candidate<'_>, saved: &SavedTask, how: How<'_>) -> Option<Check> {
    let value = || -> Result<(f64, f64), DesignError> {
        let driven = Driven::new(candidate, saved, how.precision)?;
        let (motion, elsewhere) = driven.held(how.solver, how.stop)?;
        let everywhere = Recording { elsewhere: &elsewhere, ..driven.recording(&motion, None) };
        Ok((score::objective(everywhere)?, motion.work.iter().sum()))
    };
    let found = value();
    // What hardly moves and hardly works has no ratio of the two.
    let direction = candidate.rules.tasks.get(&saved.name).map(|task| task.objective.direction)?;
    if let Ok((value, work)) = &found
        && *work < NO_WORK
        && !candidate.body.actuators.is_empty()
        && direction.fitness(*value) > direction.fitness(saved.value) + NOTHING
    {
        let why = format!("no second opinion: it comes to {value:.4}, with next to no work");
        return Some(Check {
            name: HELD.to_owned(),
            value: None,
            measured: Measured::Unable,
            why: Some(why),
        });
    }
    Some(Check::new(HELD, Measured::Held, found.map(|(value, _)| value)))
}

/// The value over all worlds that it depends on, at an eighth of the step; nothing where it is that of the nominal world.
fn in_worlds(candidate: &Candidate<'_>, saved: &SavedTask, how: How<'_>) -> Option<Check> {
    saved.nominal?;
    let value = || -> Result<f64, DesignError> {
        let finest = replay_task(candidate, saved, How { precision: Precision::Finest, ..how })?;
        let lost = || finest.lost.map(|(_, why)| why).or(finest.motion.err()).unwrap_or(Invalid::NotFinite);
        Ok(finest.score.map(|score| score.value).ok_or_else(lost)?)
    };
    Some(Check::new(IN_WORLDS, Measured::InWorlds, value()))
}

/// The work of all actuators at half the step, as a share of what it is in steps of the model.
fn work(candidate: &Candidate<'_>, saved: &SavedTask, how: How<'_>) -> Result<f64, DesignError> {
    let at = |precision| -> Result<f64, DesignError> {
        let motion = Driven::new(candidate, saved, precision)?.motion(how.solver, how.stop)??;
        Ok(motion.work.iter().sum::<f64>().max(NO_WORK))
    };
    Ok(at(Precision::Finer)? / at(Precision::Model)?)
}

/// Tries a task in the worlds that the search names for that, as far as the body can differ so. The reference solver knows
/// the nominal world only.
fn elsewhere(candidate: &Candidate<'_>, saved: &SavedTask, how: How<'_>) -> Result<Vec<Check>, DesignError> {
    let rules = candidate.rules;
    let set = rules.search.checks.as_ref().and_then(|checks| rules.scenarios.get_key_value(&checks.name));
    let (Some((name, set)), Some(task), false) = (set, rules.tasks.get(&saved.name), how.solver == RAPIER)
    else {
        return Ok(Vec::new());
    };
    let applies = |scenario: &Scenario| {
        scenario.differences.keys().all(|difference| rules.can_differ(*difference, [task]).is_ok())
    };
    let worlds: Vec<Scenario> = scenarios::worlds(name, set).into_iter().skip(1).filter(applies).collect();
    let values = values(candidate, saved, &worlds, how)?;
    let one = |(world, value): (&Scenario, Result<f64, Invalid>)| {
        Check::new(&world.described(), Measured::Value, value.map_err(DesignError::from))
    };
    Ok(worlds.iter().zip(values).map(one).collect())
}

/// What a task comes to in worlds of its scenarios that the search never saw, and what over all of them, where they do not tell
/// that one by one; empty where it names none.
fn tests(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    how: How<'_>,
) -> Result<(Vec<InWorld>, Option<f64>), DesignError> {
    let mut worlds = tested(candidate.rules, saved);
    let tells = |task: &Task| task.objective.is_told_by_each_world();
    let (values, whole) = match candidate.rules.tasks.get(&saved.name).is_none_or(tells) || worlds.is_empty()
    {
        true => (values(candidate, saved, &worlds, how)?, None),
        false => {
            worlds.insert(0, Scenario::nominal());
            let (mut values, whole) = values_and_whole(candidate, saved, &worlds, how)?;
            drop((worlds.remove(0), values.remove(0)));
            (values, whole)
        }
    };
    let one = |(world, value): (Scenario, Result<f64, _>)| InWorld {
        differs: world.described(),
        name: world.name,
        value: value.ok(),
    };
    Ok((worlds.into_iter().zip(values).map(one).collect(), whole))
}

/// The worlds that a task is tested in at the end of a run.
pub(super) fn tested(rules: &RuleSet, saved: &SavedTask) -> Vec<Scenario> {
    let within = rules.tasks.get(&saved.name).and_then(|task| task.scenarios.as_ref());
    let set = within.and_then(|within| rules.scenarios.get_key_value(&within.name));
    set.map_or_else(Vec::new, |(name, set)| scenarios::tests(name, set))
}

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

/// What a cross-check says of the value of a task. Both must be as good as the share of the other that the search asks for.
#[must_use]
pub fn verdict(rules: &RuleSet, saved: &SavedTask, check: &Check) -> Verdict {
    if matches!(check.measured, Measured::Unable | Measured::Sunk) {
        return Verdict::Silent;
    }
    let Some((task, other)) = rules.tasks.get(&saved.name).zip(check.value) else { return Verdict::Refuted };
    let share = match rules.search.keep_with_rods {
        Some(share) if check.name == RODS => share,
        _ => rules.search.keep,
    };
    let direction = task.objective.direction;
    let worlds = matches!(check.measured, Measured::InWorlds | Measured::Held);
    let value = if worlds { saved.value } else { saved.in_nominal() };
    let at_rest = saved.at_rest.unwrap_or_else(|| task.objective.offset(rules));
    match check.measured {
        // What comes of itself, beyond what there is where nothing moves.
        Measured::Held => {
            let gained = |value: f64| direction.fitness(value) - direction.fitness(at_rest);
            let much = (1.0 - rules.search.keep) * gained(value).abs();
            if gained(other) > much.max(NOTHING) { Verdict::ByItself } else { Verdict::Confirmed }
        }
        Measured::Drift if other <= STAYS => Verdict::Confirmed,
        Measured::Drift | Measured::Spin => Verdict::Refuted,
        Measured::Work if other.max(1.0 / other) <= WORKS_ALIKE => Verdict::Confirmed,
        Measured::Work => Verdict::OtherWork,
        // What does not move differs by rounding only.
        Measured::Value | Measured::InWorlds if (other - value).abs() < NOTHING => Verdict::Confirmed,
        Measured::Value | Measured::InWorlds if !keeps(direction, at_rest, share, value, other) => {
            Verdict::Worse
        }
        Measured::Value | Measured::InWorlds if !keeps(direction, at_rest, share, other, value) => {
            Verdict::Better
        }
        Measured::Value | Measured::InWorlds => Verdict::Confirmed,
        Measured::Unable | Measured::Sunk => Verdict::Silent,
    }
}

/// Of how many cross-checks that say anything of a design its value was kept in how many.
#[must_use]
pub fn kept(rules: &RuleSet, design: &SavedDesign) -> (usize, usize) {
    let all =
        design.tasks.iter().flat_map(|task| task.checks.iter().map(move |check| verdict(rules, task, check)));
    let (mut kept, mut told) = (0, 0);
    for verdict in all {
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
        (None, _) => check.why.clone().unwrap_or_else(|| "the motion is not valid".to_owned()),
        (Some(value), Measured::Value | Measured::InWorlds | Measured::Held) => {
            describe::quantity(design.less_penalties(direction, value), &saved.unit)
        }
        (Some(spin), Measured::Spin) => {
            format!("it turns by {} out of nothing", describe::quantity(spin.to_degrees(), "deg"))
        }
        (Some(share), Measured::Work) => format!("{share:.2} times as much"),
        (Some(drift), Measured::Drift) if drift <= STAYS => "it stays in place, as it should".to_owned(),
        (Some(drift), Measured::Drift) => {
            format!("its centre of mass goes {} astray", describe::quantity(100.0 * drift, "cm"))
        }
    }
}
