//! Sensors whose noise is larger than what they are compared with.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Operator};
use crate::units::{Dimension, shown};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    for (kind, name) in rules.tasks.values().flat_map(|task| &task.actuated) {
        let Some(actuation) = rules.actuations.get(name).filter(|_| rules.actuators.contains_key(kind))
        else {
            continue;
        };
        for value in actuation.values() {
            value.any(&mut |part| {
                findings.extend(
                    drowned(known, part)
                        .filter(|told| findings.iter().all(|known| known.span() != told.span())),
                );
                false
            });
        }
    }
}

/// A comparison of a sensor with a number that is smaller than its noise.
fn drowned(known: &Known<'_>, part: &Expr) -> Option<Diagnostic> {
    let ExprKind::Binary(
        a,
        Operator::Less | Operator::LessEqual | Operator::Greater | Operator::GreaterEqual,
        b,
    ) = &part.kind
    else {
        return None;
    };
    [(a, b), (b, a)].into_iter().find_map(|(sensed, limit)| {
        let ExprKind::Sensor(name, _) = &sensed.kind else { return None };
        let noise = known.ruleset.sensors.get(name)?.noise;
        let limit_at = known.numbers(limit).single()?;
        // Around zero, noise decides whatever the limit is.
        (limit_at != 0.0 && noise > limit_at.abs()).then(|| {
            let dimension = sensed.ty.dimension().unwrap_or(Dimension::NUMBER);
            Diagnostic::new(Code::UNUSUAL, limit.span, format!("the noise of `{name}` is larger than this limit"))
                .label(format!("{} of noise, and the limit is {}", shown(noise, dimension), shown(limit_at, dimension)))
                .help("mostly the noise decides this: choose a higher limit, a better sensor, or the mean of several readings (`state`)")
        })
    })
}
