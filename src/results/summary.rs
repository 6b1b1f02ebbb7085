//! A saved design in words: its value, tasks, terms and cross-checks.

use grammar_lang::ir::{Direction, RuleSet, Task};

use super::describe;
use super::elsewhere;
use super::saved::{Beside, SavedDesign, SavedTask};
use super::verdict::{outcome, outcome_of_all, verdict, verdict_of_all};
use crate::score::Observed;

/// What a broken preference adds to the value.
#[must_use]
pub fn signed(rules: &RuleSet, weight: f64) -> f64 {
    rules.objective.direction.worse_by(0.0, weight)
}

/// A preference that a design does not fulfil, with what that takes away: a line.
#[must_use]
pub fn not_fulfilled(rules: &RuleSet, name: &str, weight: f64) -> String {
    let lost = describe::quantity(signed(rules, weight), &rules.objective.unit);
    format!("  not fulfilled: {name} ({lost})\n")
}

/// What was observed, in words: a line.
#[must_use]
pub fn observed(rules: &RuleSet, name: &str, value: Option<&Observed>) -> String {
    format!("  observed {name} {}\n", observed_value(rules, name, value))
}

/// The value of what was observed, in words.
#[must_use]
pub fn observed_value(rules: &RuleSet, name: &str, value: Option<&Observed>) -> String {
    match value {
        Some(Observed::Number(x)) => describe::term(rules, &rules.objective.unit, name, *x),
        Some(other) => other.to_string(),
        None => "has no value".to_owned(),
    }
}

/// What several worlds come to, in words; none of no world. Places are those of the values.
#[must_use]
pub fn together(
    direction: Direction,
    values: &[Option<f64>],
    unit: &str,
    world: impl Fn(usize) -> String,
) -> Option<String> {
    let found = elsewhere::together(direction, values)?;
    let quantity = |value: f64| describe::quantity(value, unit);
    let mut said = Vec::new();
    said.extend(found.mean.map(|mean| format!("{} on average", quantity(mean))));
    said.extend(found.tenth.map(|tenth| format!("{} or better in nine of ten", quantity(tenth))));
    said.push(match values.get(found.worst).copied().flatten() {
        Some(value) => format!("{} at worst ({})", quantity(value), world(found.worst)),
        None => format!("no value in {} of them, such as {}", found.without, world(found.worst)),
    });
    Some(said.join(", "))
}

/// What an objective is over several worlds, in words, before it is said what it is in each: where these do not tell it.
#[must_use]
pub fn whole(value: Option<f64>, unit: &str) -> String {
    let value = value.map_or("no value".to_owned(), |value| describe::quantity(value, unit));
    format!("{value} over all of them and the nominal world; in each world alone: ")
}

/// What a task comes to in worlds that the search never saw, in words: a line, where it names scenarios.
#[must_use]
pub fn tests(rules: &RuleSet, design: &SavedDesign, saved: &SavedTask) -> Option<String> {
    let task = rules.tasks.get(&saved.name)?;
    let less = |value: f64| design.less_penalties(task.objective.direction, value);
    let values: Vec<Option<f64>> = saved.tests.iter().map(|world| world.value.map(less)).collect();
    let world = |place: usize| saved.tests[place].differs.clone();
    let said = together(task.objective.direction, &values, &saved.unit, world)?;
    let whole = match task.objective.is_told_by_each_world() {
        true => String::new(),
        false => whole(saved.tested.map(less), &saved.unit),
    };
    Some(format!("in {} other worlds of `{}`: {whole}{said}", values.len(), task.scenarios.as_ref()?.name))
}

/// The value, tasks, terms and checks of a design in words.
#[must_use]
pub fn report(rules: &RuleSet, design: &SavedDesign) -> String {
    let mut out = format!("value {}\n", describe::quantity(design.value, &design.unit));
    for Beside { objective, value, unit } in &design.beside {
        out.push_str(&format!("  and {objective} {}\n", describe::quantity(*value, unit)));
    }
    for (name, weight) in &design.penalties {
        out.push_str(&not_fulfilled(rules, name, *weight));
    }
    for (name, value) in &design.observed {
        out.push_str(&observed(rules, name, value.as_ref()));
    }
    for saved in &design.tasks {
        if saved.name != RuleSet::ONLY_TASK {
            let value = describe::quantity(saved.value, &saved.unit);
            out.push_str(&format!("task {} {value}\n", saved.name));
        }
        if let Some(nominal) = saved.nominal {
            let nominal = design.less_penalties(rules.objective.direction, nominal);
            out.push_str(&format!("  in the nominal world {}\n", describe::quantity(nominal, &saved.unit)));
        }
        for (name, value) in &saved.terms {
            out.push_str(&format!("  {name} {}\n", describe::term(rules, &saved.unit, name, *value)));
        }
        if saved.nominal.is_some() && !saved.checks.is_empty() {
            out.push_str("  checked in the nominal world:\n");
        }
        for check in &saved.checks {
            let text = outcome(rules, design, saved, check);
            let remark = verdict(rules, saved, check).remark();
            out.push_str(&format!("  with {}: {text}{remark}\n", check.name));
        }
        out.extend(tests(rules, design, saved).map(|line| format!("{line}\n")));
    }
    if let Some(of_all) = &design.of_all {
        let all = if design.tasks.len() > 1 { "all tasks together" } else { "each objective" };
        let worlds = rules.tasks.values().any(Task::runs_over_worlds);
        out.push_str(&format!("{all}, checked{}:\n", if worlds { " over all worlds" } else { "" }));
        for check in &of_all.checks {
            let text = outcome_of_all(design, check);
            let remark = verdict_of_all(rules, design, of_all, check).remark();
            out.push_str(&format!("  with {}: {text}{remark}\n", check.name));
        }
    }
    out
}
