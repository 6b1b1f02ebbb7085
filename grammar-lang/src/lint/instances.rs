//! Parts as their parameters can make them: tried at the ends of the domains, and at each value where these are few.

use indexmap::IndexMap;

use crate::eval::{Made, Unmade, Value};
use crate::ir::{InstanceParam, Kind, RuleSet, Ty};

use super::known::Known;

/// A count with more values than this is tried at its ends only.
const FEW: f64 = 16.0;
/// More combinations than this are not tried.
const MOST: usize = 1024;

/// The values of the parameters of one part, by name.
pub(super) type Given = IndexMap<String, Value>;

/// Parts of a kind, each with its parameters; one, without any, where no field reads them.
pub(super) fn made<'k>(
    known: &Known<'k>,
    kind: Kind<'k>,
) -> impl Iterator<Item = (Given, Result<Made, Unmade>)> + use<'k> {
    let rules = known.ruleset;
    let given = if varies(kind) { combinations(known, kind.params()) } else { vec![Given::new()] };
    given.into_iter().filter_map(move |given| {
        let made = Made::of(kind, rules, &given).transpose()?;
        Some((given, made))
    })
}

/// Whether a field of a kind reads the parameters.
fn varies(kind: Kind<'_>) -> bool {
    kind.varying().next().is_some()
}

/// Values for all parameters; none if one of them can have any value.
fn combinations(known: &Known<'_>, params: &IndexMap<String, InstanceParam>) -> Vec<Given> {
    let mut all = vec![Given::new()];
    for (name, param) in params {
        let values = values(known, param);
        if all.len() * values.len() > MOST {
            return Vec::new();
        }
        all = all
            .into_iter()
            .flat_map(|given| {
                values.iter().map(move |value| {
                    let mut given = given.clone();
                    given.insert(name.clone(), value.clone());
                    given
                })
            })
            .collect();
    }
    all
}

/// Some values that a parameter may have.
fn values(known: &Known<'_>, param: &InstanceParam) -> Vec<Value> {
    let numbers = |low: f64, high: f64| match param.ty {
        Ty::Count if high - low < FEW => {
            (low as i64..=high as i64).map(|n| Value::Number(n as f64)).collect()
        }
        _ => vec![Value::Number(low), Value::Number(high)],
    };
    let many = |rules: &RuleSet, name: &str| rules.enumerations.get(name).map_or(0, Vec::len);
    match (&param.ty, param.domain) {
        (Ty::Bool, _) => vec![Value::Bool(false), Value::Bool(true)],
        (Ty::Enum(name), _) => {
            (0..many(known.ruleset, name)).map(|place| Value::Number(place as f64)).collect()
        }
        (_, Some((low, high))) => numbers(low, high),
        _ => param.default.as_ref().and_then(|default| known.value(default).ok()).into_iter().collect(),
    }
}

/// The parameters of a part for people: `level = 3, wide = true`; empty without any.
pub(super) fn told(known: &Known<'_>, kind: Kind<'_>, given: &Given) -> String {
    let one = |(name, value): (&String, &Value)| {
        let ty = kind.params().get(name).map_or(&Ty::Unknown, |param| &param.ty);
        let value = match (ty, value) {
            (Ty::Enum(named), Value::Number(x)) => {
                known.ruleset.value_of(named, *x).unwrap_or("?").to_owned()
            }
            (_, Value::Number(x)) => crate::units::shown(*x, ty.dimension().unwrap_or_default()),
            (_, Value::Bool(x)) => x.to_string(),
            _ => "...".to_owned(),
        };
        format!("{name} = {value}")
    };
    given.iter().map(one).collect::<Vec<_>>().join(", ")
}
