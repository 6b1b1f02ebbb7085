//! Checks learners: what they are told, and whether there is a policy that they can learn.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::Values;
use super::tasks::Tasks;
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{self, ActionSpace, CurveMethod, Ty};
use crate::source::Span;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::{Dimension, shown};

/// Fields that every learner has.
macro_rules! learner_fields {
    ($($own:literal),*) => {
        &[$($own,)* "learning_rate", "discount", "batch", "updates", "replay", "warm_up", "target_rate", "worlds"]
    };
}

pub(super) const ACTOR_CRITIC: &[&str] = learner_fields!["critic", "entropy"];
pub(super) const Q_LEARNING: &[&str] = learner_fields!["exploration"];

/// What a field of a learner may be, and what it is if it is not said.
struct Setting {
    name: &'static str,
    usual: f64,
    within: (f64, f64),
    example: &'static str,
}

const fn setting(name: &'static str, usual: f64, within: (f64, f64), example: &'static str) -> Setting {
    Setting { name, usual, within, example }
}

/// The step of Adam: weights are drawn with a deviation of 1, so that this is some ten times what is usual for weights that are
/// drawn smaller in large layers.
const LEARNING_RATE: Setting = setting("learning_rate", 0.003, (1e-6, 1.0), "0.003");
/// Rewards of some fifty decisions count.
const DISCOUNT: Setting = setting("discount", 0.98, (0.0, 0.9999), "0.98");
const BATCH: Setting = setting("batch", 256.0, (1.0, 4096.0), "256");
const UPDATES: Setting = setting("updates", 1.0, (0.01, 100.0), "1");
const REPLAY: Setting = setting("replay", 100_000.0, (100.0, 1e6), "100000");
const WARM_UP: Setting = setting("warm_up", 10.0, (1.0, 1e5), "10");
const TARGET_RATE: Setting = setting("target_rate", 0.005, (1e-5, 1.0), "0.005");
/// Of actions between -1 and 1: that of an even draw is 0.69.
const ENTROPY: Setting = setting("entropy", -1.0, (-10.0, 0.69), "-1");

/// The hidden layers of a critic.
const USUAL_CRITIC: &[usize] = &[64, 64];

impl Declarations<'_> {
    pub(super) fn actor_critic(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::ActorCritic> {
        let learner = self.learner(from, damaged);
        let critic = self.hidden(from, "critic", USUAL_CRITIC, &Context::new(Stage::Declaration, damaged));
        let entropy = self.setting(from, &ENTROPY, damaged);
        Some(ir::ActorCritic { learner: learner?, critic: critic?, entropy: entropy? })
    }

    pub(super) fn q_learning(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::QLearning> {
        let learner = self.learner(from, damaged);
        let exploration =
            self.scheduled(from, "exploration", &Ty::NUMBER, "max(5 %, 90 % - iteration * 1 %)", damaged);
        Some(ir::QLearning { learner: learner?, exploration: exploration? })
    }

    fn learner(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::Learner> {
        let learning_rate = self.setting(from, &LEARNING_RATE, damaged);
        let discount = self.setting(from, &DISCOUNT, damaged);
        let batch = self.setting(from, &BATCH, damaged);
        let updates = self.setting(from, &UPDATES, damaged);
        let replay = self.setting(from, &REPLAY, damaged);
        let warm_up = self.setting(from, &WARM_UP, damaged);
        let target_rate = self.setting(from, &TARGET_RATE, damaged);
        let worlds = self.in_worlds(from, damaged);
        Some(ir::Learner {
            learning_rate: learning_rate?,
            discount: discount?,
            batch: batch? as usize,
            updates: updates?,
            replay: replay? as usize,
            warm_up: warm_up? as usize,
            target_rate: target_rate?,
            worlds: worlds?,
        })
    }

    /// Whether motions that explore run in worlds.
    fn in_worlds(&mut self, from: &Values<'_>, damaged: bool) -> Option<bool> {
        if !from.values.contains_key("worlds") {
            return Some(false);
        }
        let cx = Context::new(Stage::Declaration, damaged);
        self.value(from, "worlds", &Ty::Bool, "true", &cx).map(|(value, _)| value == Value::Bool(true))
    }

    fn setting(&mut self, from: &Values<'_>, setting: &Setting, damaged: bool) -> Option<f64> {
        let Setting { name, usual, within, example } = setting;
        if !from.values.contains_key(*name) {
            return Some(*usual);
        }
        // Whole numbers where what is usual is counted.
        let counted = ["batch", "replay", "warm_up"].contains(name);
        let ty = if counted { Ty::Count } else { Ty::NUMBER };
        self.bounded(from, name, &ty, *within, example, damaged)
    }

    /// Whether there is one policy that the search can learn, for each task.
    pub(in crate::types) fn check_learners(
        &mut self,
        search: Option<&ir::Search>,
        tasks: &Tasks,
        actuations: &IndexMap<String, ir::Actuation>,
        policies: &IndexMap<String, ir::Policy>,
    ) {
        let Some(curves) = search.and_then(|search| search.curves.as_ref()) else { return };
        let (within_range, told) = match &curves.method {
            CurveMethod::ActorCritic(own) => (true, &own.learner),
            CurveMethod::QLearning(own) => (false, &own.learner),
            CurveMethod::Annealing(_) | CurveMethod::CmaEs(_) => return,
        };
        let learner = Of { name: curves.method().name(), within_range };
        let wrong = tasks.values().find_map(|(task, actuated)| {
            let driven = actuated
                .iter()
                .filter_map(|(_, (with, place))| Some((with.as_str(), actuations.get(with)?, *place)));
            let driven: Vec<Driven<'_>> = driven.collect();
            (told.worlds && !task.runs_over_worlds())
                .then(|| {
                    misfit(
                        task.objective.value.span,
                        format!(
                            "`worlds = true` of `{}`, but this objective runs over no worlds",
                            learner.name
                        ),
                        "of the nominal world alone",
                        "write for example `min over w in workshop of travel`, or leave `worlds` out",
                    )
                })
                .or_else(|| learner.cannot_tune(&driven))
                .or_else(|| learner.cannot_learn(&driven, policies, task.model.duration))
        });
        if let Some(wrong) = wrong {
            self.report(wrong);
        }
    }
}

/// An actuation of a task, by its name, and where the task says so.
type Driven<'a> = (&'a str, &'a ir::Actuation, Span);

/// A learner: its name in texts, and whether its actions lie within a range.
#[derive(Clone, Copy)]
struct Of {
    name: &'static str,
    within_range: bool,
}

impl Of {
    /// What it cannot tune of a task: values that are no weights, and actions that are not of its kind.
    fn cannot_tune(self, driven: &[Driven<'_>]) -> Option<Diagnostic> {
        let learner = self.name;
        for (with, actuation, place) in driven {
            if let Some(variable) = actuation.variables.first() {
                return Some(misfit(
                    *place,
                    format!(
                        "`{with}` varies `{}`, but `{learner}` learns only the weights of a policy",
                        variable.name
                    ),
                    "a learner cannot tune this value",
                    "give it a fixed value with `let`, or search by `cma_es`, which tunes such values and weights together",
                ));
            }
            let is_other = |action: &&ir::Action| {
                matches!(action.space, ActionSpace::Continuous(..)) != self.within_range
            };
            if let Some(action) = actuation.actions.iter().find(is_other) {
                let (is, help) = if self.within_range {
                    (
                        "one of several values",
                        "give the action a range, as in `in -1 .. 1`, or search with `double_dqn`",
                    )
                } else {
                    (
                        "within a range",
                        "let it be one of several values, as in `in { -1, 0, 1 }`, or search by `soft_actor_critic`",
                    )
                };
                let name = &action.name;
                return Some(misfit(
                    *place,
                    format!(
                        "the action `{name}` of `{with}` is {is}, but `{learner}` cannot learn such actions"
                    ),
                    "its actions do not fit the method",
                    help,
                ));
            }
        }
        None
    }

    /// Why a task has not the one policy that it can learn.
    fn cannot_learn(
        self,
        driven: &[Driven<'_>],
        policies: &IndexMap<String, ir::Policy>,
        duration: f64,
    ) -> Option<Diagnostic> {
        let learner = self.name;
        let mut decided = driven.iter().flat_map(|(_, actuation, place)| {
            actuation.actions.iter().map(|action| (action.policy.as_str(), *place))
        });
        let Some((name, place)) = decided.next() else {
            let (_, _, place) = driven.first()?;
            return Some(misfit(
                *place,
                format!("`{learner}` learns a policy, but no actuation leaves an action to a policy"),
                "nothing to learn",
                "leave an action to a policy, as in `action push : Number in -1 .. 1 of brain from [bent(a) / 60 deg]`",
            ));
        };
        if let Some((_, place)) = decided.find(|(policy, _)| *policy != name) {
            return Some(misfit(
                place,
                format!("`{learner}` learns one policy, and this task has several"),
                "leaves actions to another policy",
                "leave all actions to one policy: this policy gets the inputs of all actions",
            ));
        }
        let policy = policies.get(name)?;
        if policy.reward.is_none() {
            let message = format!("`{name}` lacks a `reward`, which `{learner}` learns from");
            return Some(
                Diagnostic::new(Code::MISSING_FIELD, policy.span, message)
                    .label("without a `reward`")
                    .help("add for example `reward = (first(elements).velocity at now).x / (5 cm/s)`"),
            );
        }
        let hardly = policy.every.is_some_and(|every| 2.0 * every > duration);
        hardly.then(|| {
            let duration = shown(duration, Dimension::TIME);
            misfit(
                policy.span,
                format!("`{name}` makes too few decisions in a motion of {duration}: `{learner}` learns from what happens between two decisions"),
                "too few decisions",
                "make `every` of the policy shorter, such as `every = 0.2 s`, or the motion longer",
            )
            .also(place, "learns here")
        })
    }
}

fn misfit(place: Span, message: String, label: &str, help: &str) -> Diagnostic {
    Diagnostic::new(Code::MODEL_MISFIT, place, message).label(label).help(help)
}
