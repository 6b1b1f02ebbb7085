//! Parts as their parameters can make them: tried at the ends of the domains, at zero and at the default, and at each value
//! where these are few.

use std::collections::BTreeSet;
use std::sync::Arc;

use indexmap::IndexMap;

use crate::eval::{BodyValues, Made, MadeActuator, Unmade, Value, WithValues};
use crate::ir::{Actuator, ExprKind, InstanceParam, Kind, Param, RuleSet, Ty};

use super::known::Known;

/// A count with more values than this is tried at its ends only.
const FEW: f64 = 16.0;
/// More combinations than this are not tried: fewer of a part with many ports, each of which is worked out for each.
const MOST: usize = 1024;
/// A part with so many ports is tried with half as many combinations.
const PORTS: usize = 16;

/// The values of the parameters of one part, by name; behind them those of the parameters of the grammar that its fields read and
/// rules set.
pub(super) type Given = IndexMap<String, Value>;

/// Parts of a kind, each with its parameters; one, without any, where no field reads them.
pub(super) fn made<'k>(
    known: &Known<'k>,
    kind: Kind<'k>,
) -> impl Iterator<Item = (Given, Result<Made, Unmade>)> + use<'k> {
    let rules = known.ruleset;
    let given = match varies(kind) {
        true => [Tried::Within, Tried::Ends].into_iter().find_map(|tried| combinations(known, kind, tried)),
        false => Some(vec![Given::new()]),
    };
    let given = given.unwrap_or_default();
    let left = Arc::clone(&known.tried);
    given.into_iter().map_while(move |given| {
        let (own, values) = given
            .iter()
            .map(|(n, v)| (n.clone(), v.clone()))
            .partition::<IndexMap<_, _>, _>(|(name, _)| kind.params().contains_key(name));
        let values = values.into_iter().collect();
        let made = Made::within(kind, &WithValues { rules, values: &values }, &own, &left)?;
        Some((given, made))
    })
}

/// The parameters of the grammar that the fields of a kind read and rules set. One that hides a parameter of the kind is an error.
fn of_body<'k>(known: &Known<'k>, kind: Kind<'k>) -> impl Iterator<Item = (&'k String, &'k Param)> {
    let mut read: BTreeSet<String> = BTreeSet::new();
    for (_, field) in kind.varying() {
        field.any(&mut |e| {
            if let ExprKind::OfBody(name) = &e.kind {
                read.insert(name.clone());
            }
            false
        });
    }
    known.ruleset.params.iter().filter(move |(name, _)| read.contains(*name))
}

/// What drives can ask of the actuators of a kind, from the least of any to the greatest of any of those that are tried; none where
/// there are too many.
pub(super) fn driven_range<'k>(known: &Known<'k>, actuator: &'k Actuator) -> Option<(f64, f64)> {
    let range = |made| if let Made::Actuator(actuator) = made { Some(actuator.driven_range()) } else { None };
    made(known, Kind::Actuator(actuator))
        .filter_map(|(_, made)| range(made.ok()?))
        .reduce(|(low, high), (least, most)| (low.min(least), high.max(most)))
}

/// An actuator with the parameters that its kind gives it; none where a rule must give them.
pub(super) fn usual(known: &Known<'_>, actuator: &Actuator) -> Option<MadeActuator> {
    let default = |(name, param): (&String, &InstanceParam)| {
        Some((name.clone(), known.value(param.default.as_ref()?).ok()?))
    };
    let kind = Kind::Actuator(actuator);
    let given = if varies(kind) {
        actuator.params.iter().map(default).collect::<Option<Given>>()?
    } else {
        Given::new()
    };
    let scope = WithValues { rules: known.ruleset, values: &BodyValues::new() };
    match Made::of(kind, &scope, &given) {
        Ok(Made::Actuator(made)) => Some(made),
        _ => None,
    }
}

/// Whether a field of a kind reads the parameters.
fn varies(kind: Kind<'_>) -> bool {
    kind.varying().next().is_some()
}

/// Where in its domain a parameter is tried.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Tried {
    /// At its ends, at zero and at its default.
    Within,
    /// At its ends only.
    Ends,
}

/// Values for all parameters; none if these are too many.
fn combinations(known: &Known<'_>, kind: Kind<'_>, tried: Tried) -> Option<Vec<Given>> {
    let ports = if let Kind::Block(part) = kind { part.ports.len() } else { 0 };
    let mut all = vec![Given::new()];
    let own = kind.params().iter().map(|(name, param)| {
        let default = || param.default.as_ref().and_then(|default| known.value(default).ok());
        (name, values(known, (&param.ty, param.domain), &default, tried))
    });
    let of_body = of_body(known, kind).map(|(name, param)| {
        (name, values(known, (&param.ty, param.domain), &|| Some(param.in_force()), tried))
    });
    for (name, values) in own.chain(of_body) {
        if all.len() * values.len() > MOST * PORTS / (PORTS + ports) {
            return None;
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
    Some(all)
}

/// Some values that a parameter may have.
fn values(
    known: &Known<'_>,
    (ty, domain): (&Ty, Option<(f64, f64)>),
    default: &dyn Fn() -> Option<Value>,
    tried: Tried,
) -> Vec<Value> {
    let numbers = |low: f64, high: f64| match ty {
        Ty::Count if high - low < FEW => {
            (low as i64..=high as i64).map(|n| Value::Number(n as f64)).collect()
        }
        _ => {
            let mut values = vec![low, high];
            let within = [default().and_then(|default| default.as_number()), Some(0.0)];
            for value in within.into_iter().flatten().filter(|_| tried == Tried::Within) {
                if value > low && value < high && !values.contains(&value) {
                    values.push(value);
                }
            }
            values.into_iter().map(Value::Number).collect()
        }
    };
    let many = |rules: &RuleSet, name: &str| rules.enumerations.get(name).map_or(0, Vec::len);
    match (ty, domain) {
        (Ty::Bool, _) => vec![Value::Bool(false), Value::Bool(true)],
        (Ty::Enum(name), _) => {
            (0..many(known.ruleset, name)).map(|place| Value::Number(place as f64)).collect()
        }
        (_, Some((low, high))) => numbers(low, high),
        _ => default().into_iter().collect(),
    }
}

/// The parameters of a part for people: `level = 3, wide = true`; empty without any.
pub(super) fn told(known: &Known<'_>, kind: Kind<'_>, given: &Given) -> String {
    let one = |(name, value): (&String, &Value)| {
        let of_body = || known.ruleset.params.get(name).map(|param| &param.ty);
        let ty = kind.params().get(name).map(|param| &param.ty).or_else(of_body).unwrap_or(&Ty::Unknown);
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
