//! Sensors that wait for a load that is far above the weight of the whole body.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::eval::evaluate;
use grammar_lang::ir::{Attribute, Expr, ExprKind, Operator, RuleSet, Track};
use grammar_lang::units::{Dimension, shown};

use super::{Trials, odd};

/// So many times the weight of a body is no load that it feels.
const FAR: f64 = 5.0;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let Some(first) = trials.trials.first() else { return Vec::new() };
    let rules = first.drive.candidate().rules;
    let gravity = first.drive.task().model.gravity;
    let mass = |trial: &super::Trial<'_>| {
        trial.drive.candidate().body.assembly.elements.iter().map(|element| element.mass).sum::<f64>()
    };
    let heaviest = trials.trials.iter().map(|trial| mass(trial) * gravity).fold(0.0, f64::max);
    let of_sensors = rules.sensors.values().map(|sensor| &sensor.value);
    let of_actuations = rules.actuations.values().flat_map(|actuation| actuation.values());
    let of_states = rules.states.values().flat_map(|state| state.values());
    let mut found: Vec<Diagnostic> = Vec::new();
    for value in of_sensors.chain(of_actuations).chain(of_states) {
        value.any(&mut |e| {
            let Some(limit) = limit_of_load(rules, e) else { return false };
            let Ok(value) = evaluate(limit, rules, &mut Vec::new()) else { return false };
            let is_far = value.as_number().is_some_and(|limit| limit > FAR * heaviest);
            if is_far && found.iter().all(|known| known.span() != limit.span) {
                found.push(
                    odd(limit.span, "a sensor waits for more than the whole body weighs".to_owned())
                        .label(format!(
                            "the heaviest body of short motions weighs {}",
                            shown(heaviest, Dimension::FORCE)
                        ))
                        .help("compare with the weight that one foot carries"),
                );
            }
            is_far
        });
    }
    found
}

/// What a load is compared with.
fn limit_of_load<'e>(rules: &RuleSet, e: &'e Expr) -> Option<&'e Expr> {
    let reads_load =
        |e: &Expr| e.any(&mut |e| matches!(&e.kind, ExprKind::Attribute(_, Attribute::Track(Track::Load))));
    // The load itself, or a sensor that measures it.
    let is_load = |e: &Expr| {
        reads_load(e)
            || e.any(&mut |e| {
                matches!(&e.kind, ExprKind::Sensor(name, _) if rules.sensors.get(name).is_some_and(|s| reads_load(&s.value)))
            })
    };
    match &e.kind {
        ExprKind::Binary(load, Operator::Greater | Operator::GreaterEqual, limit) if is_load(load) => {
            Some(limit)
        }
        ExprKind::Binary(limit, Operator::Less | Operator::LessEqual, load) if is_load(load) => Some(limit),
        _ => None,
    }
}
