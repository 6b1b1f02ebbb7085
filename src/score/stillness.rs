//! What an objective is of a body that does not move, and objectives of which that is the best value.

use std::sync::Arc;

use grammar_lang::Compiled;
use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::evaluate_result;
use grammar_lang::ir::{Expr, ExprKind, Gather, Operator, RuleSet, Task};
use grammar_lang::source::{FileId, SourceMap};
use grammar_lang::units::shown;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{MotionScope, Recording, objective};
use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation};
use crate::design::assembly::Element;
use crate::drive::{Drive, check_driven};
use crate::simulate::{Motion, Placement};

/// After so many random moves a body without actuators is as good as one with some.
const MOVES: usize = 30;
/// A motion that is tried has so many frames at most.
const FRAMES: f64 = 100.0;
/// How far a body goes, m.
const WAY: f64 = 0.2;
/// By how much it turns, and each actuator bends, rad.
const TURN: f64 = 0.5;
/// The work that all actuators do together, J: none, and some.
const WORK: [f64; 2] = [0.0, 1.0];

/// What a body does in a motion that is tried.
#[derive(Clone, Copy)]
enum Tried {
    /// Nothing.
    Still,
    /// It goes a way.
    Goes(Vector3<f64>),
    /// It goes a way, and comes back.
    Returns(Vector3<f64>),
    /// It turns about the vertical.
    Turns(f64),
    /// Each element goes and comes back along a direction of its own, and all actuators bend.
    Wobbles,
}

/// All of them that move.
fn moving() -> Vec<Tried> {
    let ways = [Vector3::x(), -Vector3::x(), Vector3::z(), -Vector3::z(), Vector3::y()];
    let goes = ways.iter().map(|way| Tried::Goes(way * WAY));
    let returns = ways.iter().map(|way| Tried::Returns(way * WAY));
    goes.chain(returns).chain([Tried::Turns(TURN), Tried::Turns(-TURN), Tried::Wobbles]).collect()
}

/// All that is found in a grammar once its initial design and its examples are built, driven and scored.
#[must_use]
pub fn check_designs(compiled: &Compiled, entry: FileId, sources: &SourceMap) -> Vec<Diagnostic> {
    let mut found = check_driven(compiled, entry, sources);
    if let Some(rules) = compiled.ruleset.as_ref().filter(|_| !found.iter().any(Diagnostic::is_error)) {
        found.extend(check_still(rules));
    }
    found
}

/// A warning for each task of whose objective no motion has a better value than a body that stands still. The motions that are
/// tried are made up and obey no law: what is worse in all of them leads no search to a robot that moves.
fn check_still(rules: &RuleSet) -> Vec<Diagnostic> {
    if rules.lattice.is_some() {
        return Vec::new();
    }
    // Without an actuator there is no work.
    let mut random = Stream::named(0, "still");
    let mut derivation = Derivation::begin(rules);
    let mut candidate = Candidate::new(rules, Arc::new(derivation.clone()));
    for _ in 0..MOVES {
        if !candidate.body.actuators.is_empty() {
            break;
        }
        derivation = derivation.advance(rules, &mut random, 0.0).result.unwrap_or(derivation);
        candidate = Candidate::new(rules, Arc::new(derivation.clone()));
    }
    let alone = |task: &&Task| task.objectives().count() == 1;
    rules.tasks.values().filter(alone).filter_map(|task| best_still(&candidate, task)).collect()
}

/// What each objective of a task is of a body that stands as it begins and does not move: what a motion is worth lies beyond that.
/// What has no value there is 0. Nothing where the motion cannot be scored at all, or a value is not finite.
#[must_use]
pub fn at_rest(drive: &Drive<'_>, parameters: &[f64]) -> Option<Vec<f64>> {
    let motion = made_up(drive.candidate(), drive.task(), Tried::Still, 0.0);
    let scope = MotionScope::new(Recording::nominal(drive, parameters, &motion)).ok()?;
    let values: Vec<f64> =
        drive.task().objectives().map(|objective| resting(&objective.value, &scope).unwrap_or(0.0)).collect();
    values.iter().all(|value| value.is_finite()).then_some(values)
}

/// Whether the objective of a task has a value where nothing moves: what is divided by a distance or by the work of actuators has none.
#[must_use]
pub fn has_value_at_rest(drive: &Drive<'_>, parameters: &[f64]) -> bool {
    let motion = made_up(drive.candidate(), drive.task(), Tried::Still, 0.0);
    objective(Recording::nominal(drive, parameters, &motion)).is_ok_and(f64::is_finite)
}

/// What an expression is where nothing moves. Of a sum with a part that has no value there, such as a distance by an energy of zero, it is
/// what the other parts come to.
fn resting(value: &Expr, scope: &MotionScope<'_>) -> Option<f64> {
    let whole = evaluate_result(value, scope).ok().and_then(|value| value.as_number());
    if let Some(whole) = whole.filter(|whole| whole.is_finite()) {
        return Some(whole);
    }
    let of = |e: &Expr| resting(e, scope);
    match &value.kind {
        ExprKind::Negate(x) => of(x).map(|x| -x),
        ExprKind::Convert(x, unit) => of(x).map(|x| x / unit),
        ExprKind::Binary(a, operator @ (Operator::Add | Operator::Subtract), b) => {
            let sign = if *operator == Operator::Add { 1.0 } else { -1.0 };
            let (a, b) = (of(a), of(b));
            (a.is_some() || b.is_some()).then(|| a.unwrap_or(0.0) + sign * b.unwrap_or(0.0))
        }
        ExprKind::Binary(a, Operator::Multiply, b) => Some(of(a)? * of(b)?),
        ExprKind::Binary(a, Operator::Divide, b) => Some(of(a)? / of(b)?).filter(|x| x.is_finite()),
        ExprKind::Aggregate {
            how: Gather::Min | Gather::Max | Gather::Mean | Gather::Quantile,
            body: Some(body),
            ..
        } => of(body),
        ExprKind::Bind { body, .. } => of(body),
        ExprKind::Term(name) => of(&scope.recording.drive.candidate().rules.terms.get(name)?.value),
        _ => None,
    }
}

fn best_still<'r>(candidate: &Candidate<'r>, task: &'r Task) -> Option<Diagnostic> {
    let drive = Drive::new(candidate, task).ok()?;
    let parameters = drive.draw(&mut Stream::named(0, "still"));
    let value = |tried, work| {
        let motion = made_up(candidate, task, tried, work);
        objective(Recording::nominal(&drive, &parameters, &motion)).ok()
    };
    let still = value(Tried::Still, 0.0)?;
    let fitness = |value| task.objective.direction.fitness(value);
    let mut is_worse = false;
    for tried in moving() {
        for work in WORK {
            let other = value(tried, work)?;
            if fitness(other) > fitness(still) {
                return None;
            }
            is_worse |= fitness(other) < fitness(still);
        }
    }
    let dimension = task.objective.value.ty.dimension().unwrap_or_default();
    is_worse.then(|| {
        Diagnostic::new(
            Code::BEST_STILL,
            task.objective.value.span,
            "a robot that stands still has the best value of this objective",
        )
        .label(format!("it has {}, and nothing that moves has a better one", shown(still, dimension)))
        .help("reward what the robot should do, and subtract what it costs: `maximize travel / (1 cm) - 0.1 * energy / (1 J)`")
    })
}

/// A motion of a body.
fn made_up(candidate: &Candidate<'_>, task: &Task, tried: Tried, work: f64) -> Motion {
    let body = &candidate.body;
    let (duration, elements) = (task.model.duration, &body.assembly.elements);
    let interval = task.model.record.max(duration / FRAMES);
    // As a motion begins: its lowest point is on the ground.
    let lowest = elements.iter().map(|element| element.shape.lowest(&element.pose)).reduce(f64::min);
    let set_down = Translation3::new(0.0, -lowest.unwrap_or(0.0), 0.0);
    let frames = libm::ceil(duration / interval - 1e-9) as usize + 1;
    let actuators = body.actuators.len();
    let mut poses = Vec::with_capacity(frames * elements.len());
    let mut bends = Vec::with_capacity(frames * actuators);
    for frame in 0..frames {
        let share = (frame as f64 * interval / duration).min(1.0);
        let swing = libm::sin(share * 4.0 * std::f64::consts::PI);
        for (i, element) in elements.iter().enumerate() {
            let moved = match tried {
                Tried::Still => Isometry3::identity(),
                Tried::Goes(way) => Translation3::from(way * share).into(),
                Tried::Returns(way) => Translation3::from(way * swing).into(),
                Tried::Turns(angle) => {
                    UnitQuaternion::from_scaled_axis(Vector3::y() * angle * share) * Isometry3::identity()
                }
                Tried::Wobbles => {
                    let [x, y, z] = [1.0, 1.7, 2.3].map(|k| libm::sin(k * (i + 1) as f64));
                    Translation3::from(Vector3::new(x, y.abs(), z) * WAY * swing).into()
                }
            };
            poses.push(set_down * moved * element.pose);
        }
        let bend = if let Tried::Wobbles = tried { TURN * swing } else { 0.0 };
        bends.extend(std::iter::repeat_n(bend, actuators));
    }
    let placement =
        |(body, element): (usize, &Element)| Placement::new(body, Isometry3::identity(), element.shape);
    Motion {
        interval,
        duration,
        bodies: elements.len(),
        poses,
        bends,
        work: vec![work / actuators.max(1) as f64; actuators],
        commands: None,
        placements: elements.iter().enumerate().map(placement).collect(),
    }
}
