//! The policies of a body: their networks, and what they decide.

use grammar_lang::eval::{EvalError, Value, evaluate};
use grammar_lang::ir::{
    Action, ActionSpace, Actuation, Bound, CurveMethod, Expr, ExprKind, Kernel, Mutation, Owner, Policy, Ty,
    Variable,
};
use grammar_lang::source::Span;

use super::network::Network;
use super::scope::DriveScope;
use super::{Drive, Field, Holder};
use crate::learn::GREATEST;
use crate::simulate::Unfit;

/// Weights lie within these ends. They are drawn with a deviation of 1.
const WEIGHTS: (f64, f64) = (-GREATEST as f64, GREATEST as f64);

/// What a policy knows is held within these ends.
const INPUT_LIMIT: f64 = 10.0;

/// The most values that a search varies: a checkpoint and a saved design hold them all.
const MOST_VALUES: usize = 20_000;
/// The same where `cma_es` tunes them: its covariance has a number for each pair, and each generation takes its Cholesky factor.
const MOST_BY_CMA_ES: usize = 1500;

/// What is varied of a body that has more values than its search can tune.
#[derive(Clone, Debug)]
pub(super) struct TooMany<'r> {
    /// What has the most of them.
    pub(super) name: &'r str,
    pub(super) span: Span,
    /// How many there are in all, and how many may be.
    pub(super) values: usize,
    pub(super) most: usize,
}

/// What answers in the place of a network: by the number of the policy, and what it knows.
pub(super) type Answer<'a> = dyn FnMut(usize, &[f64]) -> Vec<f64> + 'a;

/// What a policy decides for a body.
#[derive(Clone, Debug)]
pub struct Decision<'r> {
    /// The policy.
    pub policy: &'r Policy,
    /// How many numbers it knows.
    pub inputs: usize,
    /// What it decides, in the order of its outputs.
    pub spaces: Vec<&'r ActionSpace>,
    /// How many control intervals lie between two decisions.
    pub pace: usize,
}

/// A policy with the network that it needs for a body.
#[derive(Clone, Debug)]
pub(super) struct PolicyNetwork<'r> {
    name: &'r str,
    declared: &'r Policy,
    network: Network,
    /// Its weights, as what the search varies.
    pub(super) weights: Variable,
}

impl PolicyNetwork<'_> {
    /// Whether the weights of one are weights of the other.
    pub(super) fn is_alike(&self, other: &PolicyNetwork<'_>) -> bool {
        self.name == other.name && self.network == other.network
    }

    /// How many control intervals lie between two decisions.
    fn pace(&self, interval: f64) -> usize {
        let every = self.declared.every.unwrap_or(interval);
        (libm::ceil(every / interval - 1e-9) as usize).max(1)
    }
}

impl<'r> Drive<'r> {
    /// Gives each policy that decides for actuators of this body its network, and a field for its weights.
    pub(super) fn add_policies(&mut self) {
        let rules = self.candidate.rules;
        for (name, policy) in &rules.policies {
            let (mut inputs, mut outputs) = (policy.inputs.len(), 0);
            for driven in &self.actuators {
                for (_, action) in self.actions_of(driven.actuation, name) {
                    inputs += action.inputs.len();
                    outputs += action.space.outputs();
                }
            }
            if outputs == 0 {
                continue;
            }
            let network = Network::new(inputs, &policy.hidden, outputs);
            let size = network.weights();
            let number = |x: f64| Expr { kind: ExprKind::Number(x), ty: Ty::NUMBER, span: policy.span };
            let weights = Variable {
                name: name.clone(),
                owner: Owner::Body,
                size: Some(size),
                ty: Ty::NUMBER,
                domain: WEIGHTS,
                from: None,
                mutation: Mutation {
                    probability: number(policy.mutation_chance),
                    kernel: Kernel::Normal(number(0.0), number(policy.mutation_size)),
                    bound: Bound::Clamp,
                },
                span: policy.span,
            };
            let holder = Holder::Policy(self.policies.len());
            self.policies.push(PolicyNetwork { name, declared: policy, network, weights });
            self.fields.push(Field { actuation: 0, variable: 0, holder, start: self.length });
            self.length += size;
        }
    }

    /// Why a search cannot tune all that is varied of this body, if it cannot.
    #[must_use]
    pub fn untunable(&self) -> Option<Unfit> {
        let TooMany { name, values, most, .. } = self.too_many_values()?;
        let reason = format!(
            "{values} values are varied for this body, most of them for `{name}`, and its search tunes at most {most}"
        );
        Some(Unfit { reason })
    }

    /// What has the most values, if there are more for this body than its search can tune.
    pub(super) fn too_many_values(&self) -> Option<TooMany<'r>> {
        let rules = self.candidate.rules;
        let curves = rules.search.curves.as_ref();
        let is_cma_es = curves.is_some_and(|curves| matches!(curves.method, CurveMethod::CmaEs(_)));
        let most = if is_cma_es { MOST_BY_CMA_ES } else { MOST_VALUES };
        if self.length <= most {
            return None;
        }
        let large = self.policies.iter().max_by_key(|policy| policy.network.weights());
        let (name, span) = match large {
            Some(policy) => (policy.name, policy.declared.span),
            None => {
                let (_, actuation) = self.actuations.first()?;
                let largest = actuation.variables.iter().max_by_key(|variable| variable.size)?;
                (largest.name.as_str(), largest.span)
            }
        };
        Some(TooMany { name, span, values: self.length, most })
    }

    /// The actions of an actuation that a policy decides, with their places among all of it.
    fn actions_of<'a>(
        &self,
        actuation: usize,
        policy: &'a str,
    ) -> impl Iterator<Item = (usize, &'r Action)> + use<'r, 'a> {
        let actuation: Option<&'r Actuation> =
            self.actuations.get(actuation).map(|(_, actuation)| *actuation);
        let actions = actuation.into_iter().flat_map(|actuation| actuation.actions.iter().enumerate());
        actions.filter(move |(_, action)| action.policy == policy)
    }

    /// What the network of a policy answers with these weights among all values.
    pub(super) fn answer(&self, parameters: &[f64], policy: usize, known: &[f64]) -> Vec<f64> {
        let Some(of) = self.policies.get(policy) else { return Vec::new() };
        let field = self.fields.iter().find(|field| field.holder == Holder::Policy(policy));
        let start = field.map_or(0, |field| field.start);
        let weights = parameters.get(start..start + of.network.weights());
        of.network.answer(weights.unwrap_or_default(), known)
    }

    /// The one policy that decides for the body.
    #[must_use]
    pub fn decision(&self) -> Option<Decision<'r>> {
        let [policy] = self.policies.as_slice() else { return None };
        let actions = |driven| self.actions_of(driven, policy.name).map(|(_, action)| &action.space);
        Some(Decision {
            policy: policy.declared,
            inputs: policy.network.inputs(),
            spaces: self.actuators.iter().flat_map(|driven| actions(driven.actuation)).collect(),
            pace: policy.pace(self.task.model.control),
        })
    }

    /// Decides what is to be decided in a control moment, by what something answers in the place of networks: writes the actions among
    /// the locals of the actuators.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when something that a policy knows has no value.
    pub(super) fn decide(
        &self,
        moment: usize,
        scope: &DriveScope<'_>,
        locals: &mut [Option<Vec<Value>>],
        answer: &mut Answer<'_>,
    ) -> Result<(), EvalError> {
        for (number, policy) in self.policies.iter().enumerate() {
            if !moment.is_multiple_of(policy.pace(self.task.model.control)) {
                continue;
            }
            let mut inputs = Vec::with_capacity(policy.network.inputs());
            for input in &policy.declared.inputs {
                inputs.push(number_of(input, scope, &mut Vec::new())?);
            }
            for (driven, own) in self.actuators.iter().zip(&mut *locals) {
                let Some(own) = own else { continue };
                for (_, action) in self.actions_of(driven.actuation, policy.name) {
                    for input in &action.inputs {
                        inputs.push(number_of(input, scope, own)?);
                    }
                }
            }
            let outputs = answer(number, &inputs);
            let mut outputs = outputs.as_slice();
            for (driven, own) in self.actuators.iter().zip(&mut *locals) {
                let Some((_, actuation)) = self.actuations.get(driven.actuation) else { continue };
                for (place, action) in self.actions_of(driven.actuation, policy.name) {
                    let (these, rest) = outputs.split_at_checked(action.space.outputs()).unwrap_or_default();
                    outputs = rest;
                    let slot = own.as_mut().and_then(|own| own.get_mut(actuation.first_action() + place));
                    slot.into_iter().for_each(|slot| *slot = taken(action, these));
                }
            }
        }
        Ok(())
    }
}

/// The actions of an actuation before anything is decided: the middle of a range, the first of several values.
pub(super) fn undecided(actuation: &Actuation) -> impl Iterator<Item = Value> + '_ {
    actuation.actions.iter().map(|action| taken(action, &vec![0.0; action.space.outputs()]))
}

/// What a policy takes by its outputs: a share of a range, or the value with the greatest output.
fn taken(action: &Action, outputs: &[f64]) -> Value {
    let value = match &action.space {
        ActionSpace::Continuous(low, high) => {
            let output = outputs.first().copied().unwrap_or(0.0);
            low + (high - low) * (0.5 + 0.5 * libm::tanh(output))
        }
        ActionSpace::Discrete(values) => {
            let mut best = 0;
            for (place, output) in outputs.iter().enumerate() {
                if outputs.get(best).is_some_and(|most| output > most) {
                    best = place;
                }
            }
            values.get(best).copied().unwrap_or(0.0)
        }
    };
    if action.ty == Ty::Bool { Value::Bool(value != 0.0) } else { Value::Number(value) }
}

/// A number that a policy knows; of a Bool 0 or 1.
fn number_of(input: &Expr, scope: &DriveScope<'_>, locals: &mut Vec<Value>) -> Result<f64, EvalError> {
    let value = match evaluate(input, scope, locals)? {
        Value::Bool(yes) => Some(f64::from(u8::from(yes))),
        value => value.as_number(),
    };
    let none = || EvalError { span: input.span, reason: "a policy knows finite numbers only".to_owned() };
    // One wild reading does not rule all nodes.
    value.filter(|x| x.is_finite()).map(|x| x.clamp(-INPUT_LIMIT, INPUT_LIMIT)).ok_or_else(none)
}
