//! The gait of a saved design as what a board plays.

use grammar_lang::ir::RuleSet;

use super::describe::part_name;
use super::judge::{self, body_of};
use super::saved::SavedDesign;
use crate::hardware::backend::{self, POINTS, backend};
use crate::hardware::{Limits, Problem, Schedule};

/// The schedule of a design's gait in a task (the first, if none is named) on a target: the one that is named, or the
/// one that the task is simulated on, or the only one.
///
/// # Errors
///
/// Sentences that say what does not fit.
pub fn schedule(
    rules: &RuleSet,
    design: &SavedDesign,
    task: Option<&str>,
    target: Option<&str>,
) -> Result<Schedule, Vec<String>> {
    let one = |text: String| vec![text];
    let saved = design.task(task).map_err(one)?;
    let (derivation, body) = body_of(rules, design).map_err(one)?;
    let (task, drive, parameters) = judge::drive_of(rules, saved, (&derivation, &body)).map_err(one)?;
    let names = || rules.targets.keys().map(String::as_str).collect::<Vec<_>>();
    let name = match (target, &task.on, names().as_slice()) {
        (Some(name), ..) => name,
        (None, Some(on), _) => on,
        (None, None, [only]) => only,
        (None, None, []) => {
            return Err(one(format!(
                "the grammar `{}` has no target: declare one with `target NAME on pneumatic for ...`",
                rules.name
            )));
        }
        (None, None, several) => {
            return Err(one(format!("which target? say --target with one of: {}", several.join(", "))));
        }
    };
    let Some(target) = rules.targets.get(name) else {
        let known = if rules.targets.is_empty() { "none".to_owned() } else { names().join(", ") };
        return Err(one(format!("the grammar `{}` has no target `{name}`; it has: {known}", rules.name)));
    };
    let cycle = drive.cycle(&target.kind, &parameters, POINTS).map_err(|e| one(e.reason))?;
    let cycle = cycle.ok_or_else(|| {
        one("what the actuators are asked for does not repeat: a board plays one period over and over; give the \
             actuation a `period`, and let it read the time as `t / period` only"
            .to_owned())
    })?;
    if cycle.actuators.is_empty() {
        return Err(one(format!("the design has no `{}` for the target `{name}` to drive", target.kind)));
    }
    let strict = task.on.as_deref() != Some(name);
    let names: Vec<String> =
        cycle.actuators.iter().map(|(id, _)| part_name(&derivation.design, *id)).collect();
    let texts = |problems: Vec<Problem>| problems.iter().map(ToString::to_string).collect::<Vec<String>>();
    let schedule = backend::schedule(&*backend(target, strict), &cycle, &names).map_err(texts)?;
    // Better told before a board is asked.
    let problems = schedule.check(&Limits::default());
    if problems.is_empty() { Ok(schedule) } else { Err(texts(problems)) }
}
