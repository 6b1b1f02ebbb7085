//! From a saved design to the scene that the viewer shows.

use grammar_lang::ir::{JointKind, RuleSet};
use grammar_lang::source::SourceMap;
use indexmap::IndexMap;

use super::DesignError;
use super::making::{look, making};
use super::saved::{SavedDesign, SavedTask};
use super::view::{Check, Curve, Element, Measure, Scene, Worlds};
use super::{describe, elsewhere, genuine, replay, robustness, summary};
use crate::derive::Candidate;
use crate::design::{Part, lattice};
use crate::score::Observed;
use crate::simulate::Stop;

/// Simulates a design and describes what is to be seen of one of its tasks, the first if none is named.
///
/// # Errors
///
/// A sentence: the design does not fit its grammar, or its motion is not valid.
pub fn scene(
    rules: &RuleSet,
    sources: &SourceMap,
    design: &SavedDesign,
    task: Option<&str>,
) -> Result<Scene, DesignError> {
    let mut replayed = replay::replay(rules, design, &design.solver, replay::Precision::Model)?;
    genuine::check_body(rules, design)?;
    genuine::check_values(rules, design, &replayed)?;
    let candidate = replayed.candidate.clone();
    let saved = design.task(task)?;
    let place = replayed.tasks.iter().position(|t| t.name == saved.name).ok_or(DesignError::NoTask)?;
    let moved = replayed.tasks.swap_remove(place);
    let motion = moved.motion?;
    let parts = &candidate.derivation.design.parts;
    let names = design.names(rules, &candidate.derivation);
    let elements = candidate
        .body
        .assembly
        .elements
        .iter()
        .zip(&candidate.body.parts_of_elements)
        .enumerate()
        .filter_map(|(index, (element, id))| {
            let swelling = candidate.body.assembly.swellings.iter().find(|s| s.element == index);
            let actuator = swelling.map(|swelling| swelling.actuator);
            let actuator = actuator.or_else(|| candidate.body.actuators.iter().position(|a| a == id));
            let mut look = look(rules, parts.get(id)?, element.shape);
            if !lattice::is_cell(*id) {
                look.label = names.get(*id)?.to_owned();
            }
            Some(Element { look, actuator })
        })
        .collect();
    let targets = &moved.targets;
    let curves = candidate
        .body
        .actuators
        .iter()
        .enumerate()
        .map(|(i, id)| Curve {
            name: names.get(*id).unwrap_or_default().to_owned(),
            measure: measure(rules, parts.get(id)),
            interval: targets.interval,
            targets: targets.angles.iter().skip(i).step_by(targets.actuators.max(1)).copied().collect(),
        })
        .collect();
    let checks = saved
        .checks
        .iter()
        .map(|check| Check {
            name: check.name.clone(),
            text: robustness::outcome(rules, design, saved, check),
            ok: robustness::verdict(rules, saved, check).remark().is_empty(),
        })
        .collect();
    let terms = terms(rules, design, saved, &replayed.observed);
    let shown =
        if saved.name == RuleSet::ONLY_TASK { String::new() } else { format!(", task {}", saved.name) };
    Ok(Scene {
        title: design.grammar.name.clone(),
        subtitle: vec![
            format!(
                "seed {}, found by move {} of the search, solver {}",
                design.seed, design.found_at, design.solver
            ),
            match &rules.lattice {
                Some(_) => {
                    format!("{} cells of {} kinds{shown}", parts.len(), candidate.body.actuators.len())
                }
                None => format!("{} parts, {} actuators{shown}", parts.len(), candidate.body.actuators.len()),
            },
        ],
        value: std::iter::once(describe::quantity(design.value, &design.unit))
            .chain(
                design.beside.iter().map(|other| {
                    format!("{} {}", other.objective, describe::quantity(other.value, &other.unit))
                }),
            )
            .collect::<Vec<_>>()
            .join(", "),
        terms,
        elements,
        motion,
        curves,
        making: making(rules, sources, &candidate.derivation, &names),
        checks,
        worlds: worlds(rules, &candidate, design, saved)?,
    })
}

/// What is driven of an actuator, or of the cells of a lattice.
fn measure(rules: &RuleSet, part: Option<&Part>) -> Measure {
    let row = part.and_then(|part| rules.actuators.get(&part.kind));
    match row.map(|row| row.joint.kind) {
        None => Measure::Strain,
        Some(JointKind::Bend | JointKind::Twist | JointKind::Socket) => Measure::Angle,
        Some(JointKind::Slide) => Measure::Distance,
        Some(JointKind::Spin) => Measure::Speed,
    }
}

/// How a task does in the worlds that it was tested in, with the motion in the worst of them.
fn worlds(
    rules: &RuleSet,
    candidate: &Candidate<'_>,
    design: &SavedDesign,
    saved: &SavedTask,
) -> Result<Option<Worlds>, DesignError> {
    let (Some(text), Some(task)) = (summary::tests(rules, design, saved), rules.tasks.get(&saved.name))
    else {
        return Ok(None);
    };
    let less = |value: f64| design.less_penalties(task.objective.direction, value);
    let values: Vec<Option<f64>> = saved.tests.iter().map(|world| world.value.map(less)).collect();
    let worst = elsewhere::together(task.objective.direction, &values).map(|found| found.worst);
    let scenario = worst.and_then(|worst| robustness::tested(rules, saved).into_iter().nth(worst));
    let worst = match scenario {
        Some(scenario) => {
            let driven = replay::Driven::new(candidate, saved, replay::Precision::Model)?;
            driven.motions(&[scenario], &design.solver, Stop::NEVER)?.into_iter().next().and_then(Result::ok)
        }
        None => None,
    };
    // A page is no terminal: no quotes around names, and a sentence begins with a capital.
    let text = text.replace('`', "").replacen("in ", "In ", 1);
    Ok(Some(Worlds { values, unit: saved.unit.clone(), nominal: less(saved.in_nominal()), text, worst }))
}

/// What is told beside the value: those of the tasks, where there are several, and what it gives up; the terms of one
/// task; what was observed.
fn terms(
    rules: &RuleSet,
    design: &SavedDesign,
    saved: &SavedTask,
    observed: &IndexMap<String, Option<Observed>>,
) -> Vec<(String, String)> {
    let tasks = design.tasks.iter().filter(|t| t.name != RuleSet::ONLY_TASK);
    let tasks = tasks.map(|t| (format!("task {}", t.name), describe::quantity(t.value, &t.unit)));
    let penalties = design.penalties.iter().map(|(name, weight)| {
        let lost = describe::quantity(summary::signed(rules, *weight), &design.unit);
        (format!("not fulfilled: {name}"), lost)
    });
    let terms =
        saved.terms.iter().map(|(name, v)| (name.clone(), describe::term(rules, &saved.unit, name, *v)));
    let observed = observed.iter().map(|(name, value)| {
        (format!("observed: {name}"), summary::observed_value(rules, name, value.as_ref()))
    });
    tasks.chain(penalties).chain(terms).chain(observed).collect()
}
