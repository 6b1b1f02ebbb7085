//! Learners that never begin to learn, or that look ahead for less than a movement takes.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Learner, SearchMethod};

use super::known::Known;

/// A learner that looks less far ahead than this, s, does not see what comes of a step.
const AHEAD: f64 = 0.2;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (schedule, method) in known.ruleset.search.loops() {
        let learner: &Learner = match method {
            SearchMethod::ActorCritic(method) => &method.learner,
            SearchMethod::QLearning(method) => &method.learner,
            _ => continue,
        };
        let most = known.numbers(&schedule.iterations).high * known.numbers(&schedule.moves).high;
        if learner.warm_up as f64 >= most {
            findings.push(
                Diagnostic::new(
                    Code::POINTLESS,
                    schedule.iterations.span,
                    "this learner never begins to learn",
                )
                .label(format!("at most {most} motions explore, and `warm_up` is {}", learner.warm_up))
                .help("write a lower `warm_up`, such as 10, or more iterations"),
            );
        }
        for policy in known.ruleset.policies.values().filter(|policy| policy.reward.is_some()) {
            let ahead = policy.every.map(|every| every / (1.0 - learner.discount).max(1e-9));
            if let Some(ahead) = ahead.filter(|ahead| *ahead < AHEAD) {
                findings.push(
                    Diagnostic::new(Code::UNUSUAL, policy.span, "the learner of this policy looks hardly ahead")
                        .label(format!(
                            "a reward counts half as much after {:.0} ms: `every`, and a `discount` of {}",
                            1000.0 * ahead * std::f64::consts::LN_2,
                            learner.discount
                        ))
                        .help("a stride takes a second or more: write a longer `every`, or a `discount` closer to 1, such as 0.98"),
                );
            }
        }
    }
}
