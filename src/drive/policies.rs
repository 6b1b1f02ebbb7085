//! The policies of a body: their networks, and what they decide.

use grammar_lang::eval::{EvalError, Value, evaluate};
use grammar_lang::ir::{
    Action, ActionSpace, Actuation, Bound, Expr, ExprKind, Kernel, Mutation, Owner, Policy, Ty, Variable,
};

use super::network::Network;
use super::scope::DriveScope;
use super::sides::Side;
use super::{Drive, Field, Holder};
use crate::learn::GREATEST;

/// Weights lie within these ends. They are drawn with a deviation of 1.
const WEIGHTS: (f64, f64) = (-GREATEST as f64, GREATEST as f64);

/// What a policy knows is held within these ends.
pub const INPUT_LIMIT: f64 = 10.0;

/// What is asked of a network: what a policy, by its number, decides for one side of the robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub(super) policy: usize,
    pub(super) side: usize,
}

/// What answers in the place of a network, by what it knows.
pub(super) type Answer<'a> = dyn FnMut(Query, &[f64]) -> Vec<f64> + 'a;

/// What a policy decides for a body.
#[derive(Clone, Debug)]
pub struct Decision<'r> {
    /// The policy.
    pub policy: &'r Policy,
    /// How many sides the robot has for which it decides, one after the other, by the same weights.
    pub sides: usize,
    /// What it knows for the first side, in the order of its inputs.
    pub known: Vec<&'r Expr>,
    /// What it decides for a side, in the order of its outputs.
    pub spaces: Vec<&'r ActionSpace>,
    /// How many control intervals lie between two decisions.
    pub pace: usize,
}

/// A policy with the network that it needs for a body.
#[derive(Clone, Debug)]
pub(super) struct PolicyNetwork<'r> {
    pub(super) name: &'r str,
    declared: &'r Policy,
    sides: Vec<Side>,
    network: Network,
    /// Its weights, as what the search varies.
    pub(super) weights: Variable,
}

impl PolicyNetwork<'_> {
    /// Whether the weights of one are weights of the other.
    pub(super) fn is_alike(&self, other: &PolicyNetwork<'_>) -> bool {
        self.name == other.name && self.network == other.network && self.sides.len() == other.sides.len()
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
            let sides = self.sides(name, policy);
            let Some(side) = sides.first() else { continue };
            let of_actuators: usize = side
                .known()
                .flat_map(|own| self.actions_of(own, name))
                .map(|(_, action)| action.inputs.len())
                .sum();
            let inputs = policy.known().count() + of_actuators;
            let decided = side.own.iter().flat_map(|own| self.actions_of(*own, name));
            let outputs = decided.map(|(_, action)| action.space.outputs()).sum();
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
            self.policies.push(PolicyNetwork { name, declared: policy, sides, network, weights });
            self.fields.push(Field { actuation: 0, variable: 0, holder, start: self.length });
            self.length += size;
        }
    }

    /// The actions of an actuator that a policy decides, with their places among all of its actuation.
    pub(super) fn actions_of<'a>(
        &self,
        actuator: usize,
        policy: &'a str,
    ) -> impl Iterator<Item = (usize, &'r Action)> + use<'r, 'a> {
        let driven = self.actuators.get(actuator);
        let actuation: Option<&'r Actuation> =
            driven.and_then(|driven| self.actuations.get(driven.actuation)).map(|(_, actuation)| *actuation);
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
        let first = policy.sides.first()?;
        let actions = |actuator| self.actions_of(actuator, policy.name).map(|(_, action)| action);
        let of_actuators = first.known().flat_map(actions).flat_map(|action| &action.inputs);
        Some(Decision {
            policy: policy.declared,
            sides: policy.sides.len(),
            known: policy.declared.known().chain(of_actuators).collect(),
            spaces: first.own.iter().flat_map(|own| actions(*own)).map(|action| &action.space).collect(),
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
            // All sides know what was decided last for the others.
            let known = policy
                .sides
                .iter()
                .enumerate()
                .map(|(side, of)| self.known(policy, (side, of), scope, locals));
            let known: Vec<Vec<f64>> = known.collect::<Result<_, _>>()?;
            for (side, (of, inputs)) in policy.sides.iter().zip(known).enumerate() {
                let outputs = answer(Query { policy: number, side }, &inputs);
                let mut outputs = outputs.as_slice();
                for actuator in &of.own {
                    for (place, action) in self.actions_of(*actuator, policy.name) {
                        let (these, rest) =
                            outputs.split_at_checked(action.space.outputs()).unwrap_or_default();
                        outputs = rest;
                        let first = self.first_action(*actuator);
                        let own = locals.get_mut(*actuator).and_then(Option::as_mut);
                        let slot = own.zip(first).and_then(|(own, first)| own.get_mut(first + place));
                        slot.into_iter().for_each(|slot| *slot = taken(action, these));
                    }
                }
            }
        }
        Ok(())
    }

    /// What a policy knows when it decides for a side.
    fn known(
        &self,
        policy: &PolicyNetwork<'_>,
        (number, side): (usize, &Side),
        scope: &DriveScope<'_>,
        locals: &mut [Option<Vec<Value>>],
    ) -> Result<Vec<f64>, EvalError> {
        let mut known = Vec::with_capacity(policy.network.inputs());
        for input in &policy.declared.inputs {
            known.push(number_of(input, scope, &mut Vec::new())?);
        }
        let sign = if number == 0 { 1.0 } else { -1.0 };
        for input in policy.declared.mirrored.iter().flatten() {
            known.push(sign * number_of(input, scope, &mut Vec::new())?);
        }
        for actuator in side.known() {
            let Some(own) = locals.get_mut(actuator).and_then(Option::as_mut) else { continue };
            for (_, action) in self.actions_of(actuator, policy.name) {
                for input in &action.inputs {
                    known.push(number_of(input, scope, own)?);
                }
            }
        }
        Ok(known)
    }

    /// Where the actions of an actuator begin among its locals.
    fn first_action(&self, actuator: usize) -> Option<usize> {
        let driven = self.actuators.get(actuator)?;
        self.actuations.get(driven.actuation).map(|(_, actuation)| actuation.first_action())
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
