//! A saved design in words: its value, tasks, terms and cross-checks.

use grammar_lang::ir::RuleSet;

use super::describe;
use super::robustness::{outcome, verdict};
use super::saved::SavedDesign;
use crate::score::Observed;

/// What a broken preference adds to the value.
#[must_use]
pub fn signed(rules: &RuleSet, weight: f64) -> f64 {
    rules.objective.direction.worse_by(0.0, weight)
}

/// What was observed, in words: a line.
#[must_use]
pub fn observed(rules: &RuleSet, name: &str, value: Option<&Observed>) -> String {
    format!("  observed {name} {}\n", observed_value(rules, name, value))
}

/// The value of what was observed, in words.
#[must_use]
pub fn observed_value(rules: &RuleSet, name: &str, value: Option<&Observed>) -> String {
    match value {
        Some(Observed::Number(x)) => describe::term(rules, &rules.objective.unit, name, *x),
        Some(other) => other.to_string(),
        None => "has no value".to_owned(),
    }
}

/// The value, tasks, terms and checks of a design in words.
#[must_use]
pub fn report(rules: &RuleSet, design: &SavedDesign) -> String {
    let mut out = format!("value {}\n", describe::quantity(design.value, &design.unit));
    for (name, weight) in &design.penalties {
        out.push_str(&format!(
            "  not fulfilled: {name} ({})\n",
            describe::quantity(signed(rules, *weight), &design.unit)
        ));
    }
    for (name, value) in &design.observed {
        out.push_str(&observed(rules, name, value.as_ref()));
    }
    for saved in &design.tasks {
        if saved.name != RuleSet::ONLY_TASK {
            let value = describe::quantity(saved.value, &saved.unit);
            out.push_str(&format!("task {} {value}\n", saved.name));
        }
        for (name, value) in &saved.terms {
            out.push_str(&format!("  {name} {}\n", describe::term(rules, &saved.unit, name, *value)));
        }
        for check in &saved.checks {
            let text = outcome(saved, check);
            let remark = verdict(rules, saved, check).remark();
            out.push_str(&format!("  with {}: {text}{remark}\n", check.name));
        }
    }
    out
}
