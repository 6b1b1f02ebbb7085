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
use crate::design::PartId;
use crate::learn::GREATEST;
use crate::simulate::Unfit;

/// Weights lie within these ends. They are drawn with a deviation of 1.
const WEIGHTS: (f64, f64) = (-GREATEST as f64, GREATEST as f64);

/// What a policy knows is held within these ends.
pub const INPUT_LIMIT: f64 = 10.0;

/// The most values that a search varies: a checkpoint and a saved design hold them all.
const MOST_VALUES: usize = 20_000;
/// The same where `cma_es` tunes them: its covariance has a number for each pair, and each generation takes its Cholesky factor.
const MOST_BY_CMA_ES: usize = 1500;

/// Why what is varied of a body cannot be tuned.
#[derive(Clone, Debug)]
pub(super) enum Untunable<'r> {
    /// There are more values than its search can tune.
    TooMany {
        /// What has the most of them.
        name: &'r str,
        span: Span,
        /// How many there are in all, and how many may be.
        values: usize,
        most: usize,
    },
    /// A policy has two sides, and an actuator is on neither.
    OnNoSide {
        /// The policy.
        name: &'r str,
        span: Span,
        /// The kind of the actuator.
        kind: String,
    },
}

/// Who asks a network: a policy by its number, for one side of the robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) policy: usize,
    pub(super) side: usize,
}

/// What answers in the place of a network, by what it knows.
pub(super) type Answer<'a> = dyn FnMut(Asked, &[f64]) -> Vec<f64> + 'a;

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
    name: &'r str,
    declared: &'r Policy,
    sides: Vec<Side>,
    network: Network,
    /// Its weights, as what the search varies.
    pub(super) weights: Variable,
}

/// A side of the robot, or all of it.
#[derive(Clone, Debug, Default)]
struct Side {
    /// The actuators for which is decided, by their places.
    own: Vec<usize>,
    /// The images of these, in the same order.
    others: Vec<usize>,
}

impl Side {
    /// The actuators of which something is known, in this order.
    fn known(&self) -> impl Iterator<Item = usize> {
        self.own.iter().chain(&self.others).copied()
    }
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

    /// The sides of the robot for which a policy decides: all of it, or the originals and their images in the mirror.
    fn sides(&self, name: &str, policy: &Policy) -> Vec<Side> {
        let is_decided = |place: &usize| self.actions_of(*place, name).next().is_some();
        let all = || (0..self.actuators.len()).filter(is_decided);
        if policy.mirrored.is_none() {
            return vec![Side { own: all().collect(), others: Vec::new() }];
        }
        let mut side = Side::default();
        for place in all().filter(|place| self.original(*place).is_none()) {
            let images =
                all().filter(|other| self.original(*other) == self.actuators.get(place).map(|own| own.id));
            if let [image] = images.collect::<Vec<_>>()[..] {
                side.own.push(place);
                side.others.push(image);
            }
        }
        let other = Side { own: side.others.clone(), others: side.own.clone() };
        vec![side, other]
    }

    /// What an actuator is an image of.
    fn original(&self, place: usize) -> Option<PartId> {
        self.candidate.derivation.design.parts.get(&self.actuators.get(place)?.id)?.image_of
    }

    /// Why a search cannot tune all that is varied of this body, if it cannot.
    #[must_use]
    pub fn unfit(&self) -> Option<Unfit> {
        let reason = match self.untunable()? {
            Untunable::TooMany { name, values, most, .. } => format!(
                "{values} values are varied for this body, most of them for `{name}`, and its search tunes at most {most}"
            ),
            Untunable::OnNoSide { name, kind, .. } => format!(
                "the policy `{name}` has `mirrored` inputs, so that it decides for two sides of the robot, but a `{kind}` of this body has no mirror image"
            ),
        };
        Some(Unfit { reason })
    }

    /// Why a search cannot tune all that is varied of this body, if it cannot, and where that is written.
    pub(super) fn untunable(&self) -> Option<Untunable<'r>> {
        self.on_no_side().or_else(|| self.too_many_values())
    }

    /// An actuator for which a policy of two sides decides, and which is on neither.
    fn on_no_side(&self) -> Option<Untunable<'r>> {
        for (name, policy) in
            self.candidate.rules.policies.iter().filter(|(_, policy)| policy.mirrored.is_some())
        {
            let sides = self.sides(name, policy);
            for (place, driven) in self.actuators.iter().enumerate() {
                let is_decided = self.actions_of(place, name).next().is_some();
                if is_decided && !sides.iter().any(|side| side.own.contains(&place)) {
                    let kind = self.candidate.derivation.design.parts.get(&driven.id)?.kind.clone();
                    return Some(Untunable::OnNoSide { name, span: policy.span, kind });
                }
            }
        }
        None
    }

    /// What has the most values, if there are more for this body than its search can tune.
    fn too_many_values(&self) -> Option<Untunable<'r>> {
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
        Some(Untunable::TooMany { name, span, values: self.length, most })
    }

    /// The actions of an actuator that a policy decides, with their places among all of its actuation.
    fn actions_of<'a>(
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
                let outputs = answer(Asked { policy: number, side }, &inputs);
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
