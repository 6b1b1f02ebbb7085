//! Passive joints that always lie on their stops, some that never give way, and some that take longer to spring back than the motion.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::source::Span;

use super::{Trial, Trials, odd};
use crate::design::assembly::{Control, Dof, JointKind};
use crate::drive::position_of;
use crate::simulate::Motion;

/// What happens as a body settles does not count, s.
const SETTLED: f64 = 0.5;
/// So close to an end of its range, as a share of it, a joint lies on its stop.
const ON_STOP: f64 = 0.02;
/// A joint that moves by less than this share of its range does not give way.
const STIFF: f64 = 5e-3;
/// So many joints are looked at, at least.
const ENOUGH: usize = 4;
/// What is so much of the motion a joint needs to come back by 63 %: its damping for its stiffness.
const SLOW: f64 = 0.5;

#[derive(Default)]
struct Seen {
    joints: usize,
    stopped: usize,
    stiff: usize,
    /// The shortest time in which one comes back by 63 % by itself, without a load, s.
    returns: f64,
}

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let mut kinds: BTreeMap<(String, Span), Seen> = BTreeMap::new();
    for (trial, _, motion) in trials.motions() {
        for joint in &trial.drive.candidate().body.assembly.joints {
            let JointKind::Dof(dof) = &joint.kind else { continue };
            let Some((kind, span)) = trial.kind_of(joint.child).filter(|_| is_passive(dof)) else { continue };
            let places = places(trial, motion, (joint.parent, joint.child), dof);
            // A motion may end before the body has settled.
            if places.is_empty() {
                continue;
            }
            let (low, high) = dof.limits;
            let Control::Passive { neutral: slack } = dof.control else { continue };
            let near = ON_STOP * (high - low);
            let (least, most) =
                places.iter().fold((f64::MAX, f64::MIN), |(a, b), place| (a.min(*place), b.max(*place)));
            let seen = kinds.entry((kind.to_owned(), span)).or_default();
            seen.joints += 1;
            seen.returns = if seen.joints == 1 { returns(dof) } else { seen.returns.min(returns(dof)) };
            seen.stopped += usize::from(most < low + near || least > high - near);
            // From where its spring is slack: one that carries a load holds it near rest.
            let way = (most - slack).abs().max((least - slack).abs());
            seen.stiff += usize::from(way < STIFF * (high - low));
        }
    }
    let task = trials.trials.first().map(|trial| trial.drive.task().name.as_str());
    let whole = task.and_then(|task| trials.whole.tasks.get(task));
    let duration = whole.map_or(f64::INFINITY, |task| task.model.duration);
    let told = |((kind, span), seen): (&(String, Span), &Seen)| {
        if seen.joints < ENOUGH {
            None
        } else if seen.returns > SLOW * duration {
            Some(
                odd(*span, format!("the joint of `{kind}` hardly springs back in the whole motion"))
                    .label(format!(
                        "`damping / stiffness` is {:.0} s, and the motion takes {duration:.0} s",
                        seen.returns
                    ))
                    .help("is the damping in the right unit? Real joints come back within a second"),
            )
        } else if seen.stopped == seen.joints {
            Some(
                odd(*span, format!("the joint of `{kind}` always lies on its stop"))
                    .label(format!("{} joints in short motions: its spring does not carry what hangs on it", seen.joints))
                    .help("is the stiffness in the right unit? Compare it with the weight on the joint by its lever; for a buffer, write `allow W0746 because \"...\"`"),
            )
        } else if seen.stiff == seen.joints {
            Some(
                odd(*span, format!("the joint of `{kind}` never gives way"))
                    .label(format!("{} joints move by less than a hundredth of their range", seen.joints))
                    .help("is the stiffness in the right unit? Compare it with the weight on the joint by its lever"),
            )
        } else {
            None
        }
    };
    kinds.iter().filter_map(told).collect()
}

/// How long a joint takes to come back by 63 % where its inertia counts for nothing, s.
fn returns(dof: &Dof) -> f64 {
    if dof.stiffness > 0.0 { dof.damping / dof.stiffness } else { 0.0 }
}

fn is_passive(dof: &Dof) -> bool {
    matches!(dof.control, Control::Passive { .. }) && dof.limits.0.is_finite() && dof.limits.1 > dof.limits.0
}

/// Where a joint is in the frames of a motion once the body has settled, rad or m.
fn places(trial: &Trial<'_>, motion: &Motion, (parent, child): (usize, usize), dof: &Dof) -> Vec<f64> {
    let elements = &trial.drive.candidate().body.assembly.elements;
    let rest = (elements[parent].pose, elements[child].pose);
    let times = (0..motion.frames()).map(|frame| motion.time(frame)).filter(|t| *t >= SETTLED);
    times
        .filter_map(|t| Some(position_of(dof, rest, (motion.pose(parent, t)?, motion.pose(child, t)?))))
        .collect()
}
