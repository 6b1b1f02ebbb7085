//! What a best design is checked with before anybody believes its value: other steps, another solver, another world.

use grammar_lang::ir::{RuleSet, Task};
use rayon::prelude::*;

use super::DesignError;
use super::describe;
use super::elsewhere::{values, values_and_whole};
use super::replay::{Driven, How, Precision, ReplayedTask, candidate, drive_of, replay_as, replay_task};
use super::saved::{Check, CheckOfAll, InWorld, Measured, OfAll, SavedDesign, SavedTask};
use super::saving::all_at_rest;
use super::verdict::{HALF_STEP, HELD, RODS, STAYS, Verdict, verdict, works_alike};
use crate::derive::Candidate;
use crate::scenarios::{self, Scenario};
use crate::score::{self, Recording};
use crate::search::{self, NOTHING, keeps};
use crate::simulate::{Invalid, Motion, SolverName, Stop, rod};

/// What keeps its value at half the step may still live on an error that is slow to show.
const EIGHTH: &str = "an eighth of the step, finer contacts";
/// A value over worlds is checked in all of them.
const IN_WORLDS: &str = "an eighth of the step, in all worlds";
/// Nothing carries a body away on a floor without friction, but errors of the solver do.
const ICE: &str = "a floor of ice";
/// A body that turns by less on ice, rad, faces where it faced: what trembles between two frames adds up to a hundredth of it.
const FACES: f64 = 0.05;
/// Frames a second that tell what angular momentum does: parts of soft bodies tremble a hundred times a second.
const OFTEN: f64 = 240.0;
/// Joints that tremble hardly move the body, so its value holds, but they work.
const WORK: &str = "half the step (energy)";
/// Some errors of the work halve with the step: what is nearly the same at half of it may be far off.
const WORK_OF_EIGHTH: &str = "an eighth of the step (energy)";
/// Less work in a motion, J, is as good as none.
const NO_WORK: f64 = 1e-3;
/// Ratios of less work than this, J, say nothing: so much lifts ten grams by a tenth of a millimetre.
const NO_RATIO: f64 = 1e-5;
const RAPIER: &str = SolverName::Rapier.text();

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
        saved.checks.push(work);
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
    design.of_all = of_all(&candidate, &design, stop)?;
    Ok(design)
}

/// What several tasks come to together, and each objective of a front, where the lines of one task do not tell that: over all worlds
/// that they depend on.
fn of_all(
    candidate: &Candidate<'_>,
    design: &SavedDesign,
    stop: Stop<'_>,
) -> Result<Option<OfAll>, DesignError> {
    let rules = candidate.rules;
    if design.tasks.len() < 2 && design.beside.is_empty() {
        return Ok(None);
    }
    let solver = design.solver.as_str();
    let model = How { solver, precision: Precision::Model, stop };
    let mut others = vec![
        (EIGHTH, How { precision: Precision::Finest, ..model }),
        (HALF_STEP, How { precision: Precision::Finer, ..model }),
    ];
    if solver != SolverName::Rod.text() && rod::bends(&candidate.body.assembly) {
        others.push((RODS, How { solver: SolverName::Rod.text(), ..model }));
    }
    // It knows the nominal world only.
    if solver != RAPIER && !rules.tasks.values().any(Task::runs_over_worlds) {
        others.push((RAPIER, How { solver: RAPIER, ..model }));
    }
    let one = |(name, how): (&str, How<'_>)| -> Option<CheckOfAll> {
        let replayed = match replay_as(rules, design, how) {
            Ok(replayed) => replayed,
            // Of such a body this solver has no opinion: the lines of the tasks say so.
            Err(DesignError::Unfit(_)) => return None,
            Err(why) => {
                return Some(CheckOfAll {
                    name: name.to_owned(),
                    values: Vec::new(),
                    why: Some(why.to_string()),
                });
            }
        };
        let is_unable = |task: &ReplayedTask| {
            matches!(task.motion, Err(Invalid::BeyondLimits | Invalid::Unfit))
                || name == RAPIER && task.motion.as_ref().is_ok_and(|motion| Soft::of(motion).is_some())
        };
        if replayed.tasks.iter().any(is_unable) {
            return None;
        }
        let why = replayed.value.is_none().then(|| replayed.why_invalid());
        let values = replayed.value.into_iter().chain(replayed.beside).collect();
        Some(CheckOfAll { name: name.to_owned(), values, why })
    };
    let mut checks: Vec<CheckOfAll> = others.into_par_iter().filter_map(one).collect();
    given_up(stop)?;
    checks.sort_by_key(|check| [HALF_STEP, EIGHTH, RAPIER, RODS].iter().position(|name| *name == check.name));
    Ok(Some(OfAll { at_rest: all_at_rest(candidate, design)?, checks }))
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
                Ok(Ok((value, Some(Soft { measured, depth })))) => {
                    let own = Check::new(name, Measured::Value, Ok(*value));
                    let agrees = verdict(candidate.rules, saved, &own) == Verdict::Confirmed;
                    return if agrees { own } else { Check::new(name, *measured, Ok(*depth)) };
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

/// What soft contacts let happen.
struct Soft {
    measured: Measured,
    /// m.
    depth: f64,
}

impl Soft {
    /// How far the centre of an element gets below the floor, or into another one.
    fn of(motion: &Motion) -> Option<Self> {
        let both = [(Measured::Sunk, motion.depth()), (Measured::Interlocked, motion.interlocked())];
        let found = both.into_iter().find(|(_, depth)| *depth > 0.0);
        found.map(|(measured, depth)| Self { measured, depth })
    }
}

/// The value in the nominal world, and what the soft contacts of rapier let happen.
fn opinion(
    candidate: &Candidate<'_>,
    saved: &SavedTask,
    how: How<'_>,
) -> Result<Result<(f64, Option<Soft>), Invalid>, DesignError> {
    let driven = Driven::new(candidate, saved, how.precision)?;
    let nominal = Scenario::nominal();
    let motion = match driven.motion_in(&nominal, how.solver, how.stop)? {
        Ok(motion) => motion,
        Err(why) => return Ok(Err(why)),
    };
    let value = score::objective(driven.recording(&motion, Some(&nominal)))?;
    let soft = if how.solver == RAPIER { Soft::of(&motion) } else { None };
    Ok(Ok((value, soft)))
}

/// The value of curves in the nominal world, in words.
pub struct LostWithRods {
    /// With hinges.
    pub hinges: String,
    /// With rods in place of them.
    pub rods: String,
}

/// What curves that a search begins with lose with rods in the nominal world, if that is so much that the search refuses them.
#[must_use]
pub fn refused_with_rods(
    candidate: &Candidate<'_>,
    design: &SavedDesign,
    solver: Option<&str>,
) -> Option<LostWithRods> {
    let rules = candidate.rules;
    let share = rules.search.keep_with_rods?;
    let solver = solver.unwrap_or_else(|| search::solver(rules).text());
    let rod = SolverName::Rod.text();
    if solver == rod || !rod::bends(&candidate.body.assembly) {
        return None;
    }
    design.tasks.iter().find_map(|saved| {
        let how = |solver| How { solver, precision: Precision::Model, stop: Stop::NEVER };
        let value = |solver| Some(opinion(candidate, saved, how(solver)).ok()?.ok()?.0);
        let (hinges, rods) = (value(solver)?, value(rod)?);
        let (drive, parameters) = drive_of(candidate, saved).ok()?;
        let at_rest = score::at_rest(&drive, &parameters)?.first().copied()?;
        let objective = &rules.tasks.get(&saved.name)?.objective;
        let said = |value: f64| describe::quantity(value, &objective.unit);
        (!keeps(objective.direction, at_rest, share, hinges, rods))
            .then(|| LostWithRods { hinges: said(hinges), rods: said(rods) })
    })
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
    let objective = candidate.rules.tasks.get(&saved.name).map(|task| &task.objective)?;
    let direction = objective.direction;
    let is_ratio =
        || Driven::new(candidate, saved, how.precision).is_ok_and(|driven| !driven.has_value_at_rest());
    if let Ok((value, work)) = &found
        && *work < NO_WORK
        && !candidate.body.actuators.is_empty()
        && direction.fitness(*value) > direction.fitness(saved.value) + NOTHING
        && is_ratio()
    {
        let value = describe::quantity(*value, &objective.unit);
        let why = format!("no second opinion: it comes to {value}, with next to no work");
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

/// The work of all actuators at half the step, as a share of what it is in steps of the model; at an eighth of it if only that is in doubt.
fn work(candidate: &Candidate<'_>, saved: &SavedTask, how: How<'_>) -> Check {
    let at = |precision| -> Result<f64, DesignError> {
        let motion = Driven::new(candidate, saved, precision)?.motion(how.solver, how.stop)??;
        Ok(motion.work.iter().sum::<f64>().max(NO_RATIO))
    };
    let compared = || -> Result<(f64, f64), DesignError> {
        let own = at(Precision::Model)?;
        Ok((at(Precision::Finer)? / own, at(Precision::Finest)? / own))
    };
    match compared() {
        Ok((half, eighth)) if works_alike(half) && !works_alike(eighth) => {
            Check::new(WORK_OF_EIGHTH, Measured::Work, Ok(eighth))
        }
        half => Check::new(WORK, Measured::Work, half.map(|(half, _)| half)),
    }
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
