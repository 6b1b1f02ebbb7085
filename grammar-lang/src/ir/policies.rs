//! Policies: small neural networks that decide what actuators do from what sensors read.

use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, quantity, range};
use super::{Expr, Ty};
use crate::source::Span;
use crate::units::{self, Dimension};

/// A policy: one network for the whole robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Policy {
    /// What it knows of the whole robot, apart from what each action tells it of its actuator.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Expr>,
    /// What it knows of the whole robot and what changes its sign in the mirror. With it, the policy decides for the two sides of the robot by the
    /// same weights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirrored: Option<Vec<Expr>>,
    /// The sizes of its hidden layers.
    pub hidden: Vec<usize>,
    /// The time between two decisions, s; each control interval if none is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<f64>,
    /// What a learner gets for the time between two decisions: a number of the reward stage. Other searches have no use for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reward: Option<Expr>,
    /// How likely one of its weights changes in a move of the search.
    pub mutation_chance: f64,
    /// The standard deviation of that change. A weight is drawn with a deviation of 1, and divided by the root of the number of
    /// inputs of its layer where it is used.
    pub mutation_size: f64,
    /// Where it is declared.
    pub span: Span,
}

impl Policy {
    /// What it knows of the whole robot, what changes its sign in the mirror last.
    pub fn known(&self) -> impl Iterator<Item = &Expr> {
        self.inputs.iter().chain(self.mirrored.iter().flatten())
    }
}

/// What a policy decides of each actuator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Action {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Ty,
    /// The values to decide between.
    pub space: ActionSpace,
    /// The policy.
    pub policy: String,
    /// What it knows of the actuator. May read the actuator, the variables, the states and the last actions.
    pub inputs: Vec<Expr>,
}

/// The values between which a policy decides, in SI units; of a Bool 0 and 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActionSpace {
    /// Any value from the least to the greatest.
    Continuous(f64, f64),
    /// One of several.
    Discrete(Vec<f64>),
}

impl ActionSpace {
    /// How many outputs of the network it takes.
    #[must_use]
    pub fn outputs(&self) -> usize {
        match self {
            Self::Continuous(..) => 1,
            Self::Discrete(values) => values.len(),
        }
    }
}

impl Writer<'_> {
    pub(super) fn policy(&mut self, name: &str, policy: &Policy) {
        self.gap();
        self.line(0, format!("policy {name} {{"));
        if !policy.inputs.is_empty() {
            let inputs: Vec<_> = policy.inputs.iter().map(|input| self.expr(input, &Names::new())).collect();
            self.line(1, format!("inputs = [{}]", inputs.join(", ")));
        }
        if let Some(mirrored) = &policy.mirrored {
            let mirrored: Vec<_> = mirrored.iter().map(|input| self.expr(input, &Names::new())).collect();
            self.line(1, format!("mirrored = [{}]", mirrored.join(", ")));
        }
        let hidden: Vec<_> = policy.hidden.iter().map(ToString::to_string).collect();
        self.line(1, format!("hidden = [{}]", hidden.join(", ")));
        if let Some(every) = policy.every {
            self.line(1, format!("every = {}", units::shown(every, Dimension::TIME)));
        }
        if let Some(reward) = &policy.reward {
            self.line(1, format!("reward = {}", self.expr(reward, &Names::new())));
        }
        self.line(1, format!("mutation_chance = {}", policy.mutation_chance));
        self.line(1, format!("mutation_size = {}", policy.mutation_size));
        self.line(0, "}");
    }

    pub(super) fn action(&mut self, action: &Action, names: &Names) {
        let domain = match &action.space {
            ActionSpace::Continuous(low, high) => range((*low, *high), &action.ty),
            ActionSpace::Discrete(values) => {
                let values: Vec<_> = values.iter().map(|value| quantity(*value, &action.ty)).collect();
                format!("{{ {} }}", values.join(", "))
            }
        };
        let inputs: Vec<_> = action.inputs.iter().map(|input| self.expr(input, names)).collect();
        let (name, ty, policy) = (&action.name, &action.ty, &action.policy);
        self.line(1, format!("action {name} : {ty} in {domain} of {policy} from [{}]", inputs.join(", ")));
    }
}
