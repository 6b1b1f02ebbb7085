//! What a robot that reacts felt, remembered and was asked for, as a table.

use std::fmt::Write as _;

use grammar_lang::eval::Value;
use grammar_lang::ir::{RuleSet, Ty};
use grammar_lang::units;

use super::names::Names;
use crate::drive::{Signal, Trace};

/// A table of comma-separated values: a row for each control moment, with its time in s and a column for each signal.
#[must_use]
pub fn table(rules: &RuleSet, names: &Names, trace: &Trace) -> String {
    let mut text = String::from("time (s)");
    for signal in &trace.signals {
        let _ = write!(text, ",{}", heading(signal, names));
    }
    text.push('\n');
    for (moment, row) in trace.rows.iter().enumerate() {
        let _ = write!(text, "{}", rounded(moment as f64 * trace.interval));
        for (signal, value) in trace.signals.iter().zip(row) {
            let shown = value.as_ref().map_or(String::new(), |value| shown(rules, &signal.ty, value));
            let _ = write!(text, ",{shown}");
        }
        text.push('\n');
    }
    text
}

/// What a column is called: `lean (deg)`, `phase of core`, `bender-1 (deg)`.
fn heading(signal: &Signal, names: &Names) -> String {
    let of = signal.of.map(|part| names.get(part).unwrap_or("a part without a name"));
    let name = match of {
        None => signal.name.clone(),
        Some(of) if signal.name.is_empty() => format!("{of} is asked for"),
        Some(of) => format!("{} of {of}", signal.name),
    };
    match signal.ty.dimension().filter(|dimension| !dimension.is_number()) {
        Some(dimension) => format!("{name} ({})", units::suggest(dimension)),
        None => name,
    }
}

fn shown(rules: &RuleSet, ty: &Ty, value: &Value) -> String {
    match (ty, value) {
        (_, Value::Bool(yes)) => yes.to_string(),
        (Ty::Enum(name), Value::Number(x)) => {
            let values = rules.enumerations.get(name);
            values.and_then(|values| values.get(*x as usize)).cloned().unwrap_or_default()
        }
        (ty, Value::Number(x)) => {
            let unit = ty.dimension().map(units::suggest).and_then(|unit| units::parse(&unit).ok());
            rounded(x / unit.map_or(1.0, |unit| unit.factor)).to_string()
        }
        _ => String::new(),
    }
}

/// To a millionth: more is not measured.
fn rounded(x: f64) -> f64 {
    let rounded = libm::round(x * 1e6) / 1e6;
    if rounded == 0.0 { 0.0 } else { rounded }
}
