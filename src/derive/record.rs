//! Steps as they are kept and saved.

use std::sync::Arc;

use grammar_lang::eval::{KindValue, Reference, Value};
use serde::{Deserialize, Serialize};

/// One rule application: what it matched and what it chose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Its number, which never changes: parts are named after it.
    pub id: u64,
    /// The rule.
    pub rule: String,
    /// The values of the rule's locals: matches, then choices.
    pub locals: Vec<Recorded>,
}

/// A value of a match or choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Recorded {
    /// A quantity in SI units or a count.
    Number(f64),
    /// True or false.
    Bool(bool),
    /// A text.
    Text(String),
    /// A pattern's name.
    Pattern(String),
    /// A kind of part with its parameters.
    Kind(String, Vec<(String, Recorded)>),
    /// A part, port or step.
    Reference(Reference),
}

impl Recorded {
    /// Records a value; `None` for one that no rule can match or choose.
    #[must_use]
    pub fn new(value: &Value) -> Option<Self> {
        Some(match value {
            Value::Number(x) => Self::Number(*x),
            Value::Bool(x) => Self::Bool(*x),
            Value::Text(x) => Self::Text(x.to_string()),
            Value::Pattern(x) => Self::Pattern(x.to_string()),
            Value::Reference(x) => Self::Reference(*x),
            Value::Kind(kind) => {
                let params = kind
                    .params
                    .iter()
                    .map(|(n, v)| Some((n.clone(), Self::new(v)?)))
                    .collect::<Option<_>>()?;
                Self::Kind(kind.name.clone(), params)
            }
            _ => return None,
        })
    }

    /// The value that was recorded.
    #[must_use]
    pub fn value(&self) -> Value {
        match self {
            Self::Number(x) => Value::Number(*x),
            Self::Bool(x) => Value::Bool(*x),
            Self::Text(x) => Value::Text(x.as_str().into()),
            Self::Pattern(x) => Value::Pattern(x.as_str().into()),
            Self::Reference(x) => Value::Reference(*x),
            Self::Kind(name, params) => Value::Kind(Arc::new(KindValue {
                name: name.clone(),
                params: params.iter().map(|(n, v)| (n.clone(), v.value())).collect(),
            })),
        }
    }
}
