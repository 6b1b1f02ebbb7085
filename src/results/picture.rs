//! From a saved design to the scene that the viewer shows.

use grammar_lang::ir::{Direction, JointKind, RuleSet};
use grammar_lang::source::SourceMap;
use indexmap::IndexMap;

use super::DesignError;
use super::making::{look, making};
use super::saved::{SavedDesign, SavedTask};
use super::verdict::{self, verdict};
use super::view::{Check, Curve, Element, Elsewhere, Measure, Scene, Worlds};
use super::{describe, elsewhere, genuine, replay, robustness, summary};
use crate::derive::Candidate;
use crate::design::{Part, lattice};
use crate::scenarios::Scenario;
use crate::score::Observed;
use crate::simulate::Stop;

/// Simulates a design and describes what is to be seen of one of its tasks, the first if none is named; beside it its motion in
/// another world, which is the worst that it was tested in if none is chosen.
///
/// # Errors
///
/// A sentence: the design does not fit its grammar, or its motion is not valid.
pub fn scene(
    rules: &RuleSet,
    sources: &SourceMap,
    design: &SavedDesign,
    task: Option<&str>,
    chosen: Option<&Scenario>,
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
            let mut look = look(parts.get(id)?, element.shape);
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
            text: verdict::outcome(rules, design, saved, check),
            agrees: verdict(rules, saved, check).agrees(),
        })
        .chain(design.of_all.iter().flat_map(|of_all| {
            of_all.checks.iter().map(|check| Check {
                name: format!("{} (all objectives)", check.name),
                text: verdict::outcome_of_all(design, check),
                agrees: verdict::verdict_of_all(rules, design, of_all, check).agrees(),
            })
        }))
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
        worlds: worlds(rules, design, saved),
        elsewhere: elsewhere(&candidate, design, saved, chosen)?,
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

/// How a task does in the worlds that it was tested in.
fn worlds(rules: &RuleSet, design: &SavedDesign, saved: &SavedTask) -> Option<Worlds> {
    let (text, task) = (summary::tests(rules, design, saved)?, rules.tasks.get(&saved.name)?);
    let values = tested(design, saved, task.objective.direction);
    let nominal = design.less_penalties(task.objective.direction, saved.in_nominal());
    // A page is no terminal: no quotes around names, and a sentence begins with a capital.
    let text = text.replace('`', "").replacen("in ", "In ", 1);
    Some(Worlds { values, unit: saved.unit.clone(), nominal, text })
}

/// The values in the worlds that a task was tested in.
fn tested(design: &SavedDesign, saved: &SavedTask, direction: Direction) -> Vec<Option<f64>> {
    let less = |value: f64| design.less_penalties(direction, value);
    saved.tests.iter().map(|world| world.value.map(less)).collect()
}

/// The motion in the chosen world, or in the worst that a task was tested in, where there is a valid one.
fn elsewhere(
    candidate: &Candidate<'_>,
    design: &SavedDesign,
    saved: &SavedTask,
    chosen: Option<&Scenario>,
) -> Result<Option<Elsewhere>, DesignError> {
    let rules = candidate.rules;
    let driven = replay::Driven::new(candidate, saved, replay::Precision::Model)?;
    if let Some(scenario) = chosen {
        let motion = driven.motion_in(scenario, &design.solver, Stop::NEVER)??;
        return Ok(Some(Elsewhere { world: scenario.name.clone(), motion }));
    }
    let Some(direction) = rules.tasks.get(&saved.name).map(|task| task.objective.direction) else {
        return Ok(None);
    };
    let worst = elsewhere::together(direction, &tested(design, saved, direction)).map(|found| found.worst);
    let scenario = worst.and_then(|worst| robustness::tested(rules, saved).into_iter().nth(worst));
    let Some(scenario) = scenario else { return Ok(None) };
    let motion = driven.motion_in(&scenario, &design.solver, Stop::NEVER)?;
    Ok(motion.ok().map(|motion| Elsewhere { world: "Worst world".to_owned(), motion }))
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
