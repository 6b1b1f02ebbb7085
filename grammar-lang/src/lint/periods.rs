//! Periods that are shorter than a few samples of the drive, or longer than the motion, and schedules of valves and actuators that
//! are too slow for them.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{Actuation, Backend, Kind, Task, Ty, Variable};
use crate::source::Span;
use crate::units::{Dimension, shown};

use super::instances::{driven_range, made};
use super::known::{Actuated, Known};

/// A search may try periods that are too long, but not many times so.
const FAR: f64 = 5.0;
/// A curve needs so many samples in a period to be one.
const FEWEST_SAMPLES: f64 = 4.0;
/// An actuator that moves by less than this share of its range in half a period cannot follow.
const HARDLY: f64 = 0.1;
/// A cycle of valves has so many states at least: in which air comes in, and in which it goes out.
const FEWEST_STATES: f64 = 2.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut told = BTreeSet::new();
    for task in ruleset.tasks.values() {
        for (kind, name) in &task.actuated {
            let Some(actuation) = ruleset.actuations.get(name) else { continue };
            let fixed = || fixed_period(known, actuation);
            let Some(period) = period(actuation).or_else(fixed) else { continue };
            if let Some(finding) = unusual(task, period)
                && told.insert(period.span)
            {
                findings.push(finding);
            }
            for (target, air) in &ruleset.targets {
                let Backend::Pneumatic(valves) = &air.backend else { continue };
                if air.kind == *kind
                    && FEWEST_STATES * valves.shortest > period.domain.0 * (1.0 + 1e-9)
                    && told.insert(air.span)
                {
                    findings.push(too_slow(target, air.span, valves.shortest, period));
                }
            }
        }
    }
    for finding in ruleset.tasks.values().filter_map(|task| decides_once(known, task)) {
        if told.insert(finding.span()) {
            findings.push(finding);
        }
    }
    for actuated in known.actuated() {
        if let Some(finding) = cannot_follow(known, &actuated)
            && told.insert(finding.span())
        {
            findings.push(finding);
        }
    }
}

/// A policy that decides only once in a motion.
fn decides_once(known: &Known<'_>, task: &Task) -> Option<Diagnostic> {
    let ruleset = known.ruleset;
    let actuations = task.actuated.values().filter_map(|name| ruleset.actuations.get(name));
    let mut policies = actuations.flat_map(|actuation| &actuation.actions).map(|action| &action.policy);
    policies.find_map(|name| {
        let policy = ruleset.policies.get(name)?;
        let every = policy.every.filter(|every| *every >= task.model.duration)?;
        let time = |x: f64| shown(x, Dimension::TIME);
        Some(
            Diagnostic::new(
                Code::UNUSUAL,
                policy.span,
                format!("`{name}` decides only once in a motion of {}", time(task.model.duration)),
            )
            .label(format!("it decides every {}", time(every)))
            .help("is the unit right? Write for example `every = 0.3 s`"),
        )
    })
}

/// An actuator that is so slow that it hardly moves in a period of middle length.
fn cannot_follow(known: &Known<'_>, actuated: &Actuated<'_>) -> Option<Diagnostic> {
    let &Actuated { kind, actuator, actuation, .. } = actuated;
    let period = period(actuation)?;
    let dimension = actuator.joint.kind.driven();
    if actuation.drive.ty != Ty::Quantity(dimension) || dimension == Dimension::ANGULAR_VELOCITY {
        return None;
    }
    let (low, high) = driven_range(known, actuator)?;
    let speeds = made(known, Kind::Actuator(actuator)).filter_map(|(_, made)| match made.ok()? {
        Made::Actuator(own) => own.motor.map(|motor| motor.speed.most()),
        _ => None,
    });
    let fastest = speeds.reduce(f64::max)?;
    // Half of a period of a middle length.
    let moved = fastest * (period.domain.0 + period.domain.1) / 4.0;
    let told = |x: f64| shown(x, dimension);
    (moved < HARDLY * (high - low)).then(|| {
        Diagnostic::new(Code::UNUSUAL, period.span, format!("`{kind}` is too slow for these periods"))
            .label(format!(
                "in half of a period of middle length, it moves {} of its range of {}",
                told(moved),
                told(high - low)
            ))
            .also(
                actuator.span,
                format!(
                    "its {} is {}",
                    actuator.joint.kind.speed_field(),
                    shown(fastest, dimension.over(Dimension::TIME).unwrap_or_default())
                ),
            )
            .help("check the units. If they are right, make the period longer or the actuator faster")
    })
}

/// How long the periods of an actuation are, from the shortest to the longest, s.
#[derive(Clone, Copy)]
struct Periods {
    domain: (f64, f64),
    span: Span,
}

/// The varied period of an actuation.
fn period(actuation: &Actuation) -> Option<Periods> {
    let is_period = |v: &&Variable| v.name == "period" && v.ty.dimension() == Some(Dimension::TIME);
    actuation.variables.iter().find(is_period).map(|v| Periods { domain: v.domain, span: v.span })
}

/// The one that is a number.
fn fixed_period(known: &Known<'_>, actuation: &Actuation) -> Option<Periods> {
    let (_, value) = actuation.lets.iter().find(|(name, _)| name == "period")?;
    let period = known.fixed(value)?.as_number().filter(|_| value.ty.dimension() == Some(Dimension::TIME))?;
    Some(Periods { domain: (period, period), span: value.span })
}

fn unusual(task: &Task, period: Periods) -> Option<Diagnostic> {
    let time = |x: f64| shown(x, Dimension::TIME);
    let (low, high) = period.domain;
    let (control, duration) = (task.model.control, task.model.duration);
    let (message, label, help) = if low < FEWEST_SAMPLES * control * (1.0 - 1e-9) {
        (
            format!("a period of {} is too short for the drive", time(low)),
            format!("a drive is sampled every {}", time(control)),
            "is the unit right? If it is, set a shorter `control` in the model",
        )
    } else if low > duration || high > FAR * duration {
        let long = if low > duration { low } else { high };
        (
            format!("a period of {} is longer than the motion", time(long)),
            format!("the motion lasts {}", time(duration)),
            "is the unit right? If it is, simulate a longer motion: `simulate ... for 20 s`",
        )
    } else {
        return None;
    };
    Some(Diagnostic::new(Code::UNUSUAL, period.span, message).label(label).help(help))
}

fn too_slow(target: &str, place: Span, shortest: f64, period: Periods) -> Diagnostic {
    let time = |x: f64| shown(x, Dimension::TIME);
    Diagnostic::new(Code::TOO_SHORT, place, format!("the valves of `{target}` are too slow for some periods"))
        .label(format!("a valve stays in one state for at least {}", time(shortest)))
        .also(period.span, format!("a period may be as short as {}: two states do not fit into it", time(period.domain.0)))
        .help("start the domain of the period at a longer time, or set a shorter `shortest` if the valves can do it")
}
