//! Preferences and temperatures that are on another scale than the objective.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::eval::{Scope, Value, evaluate};
use grammar_lang::ir::{Objective, RuleSet, SearchWord, Word};

use super::{Trials, odd};

/// So many motions have a value, at least.
const ENOUGH: usize = 4;
/// What is so many times as large as all that short motions come to, if they went on in the same way, is on another scale: a search may
/// find what goes ten times as far.
const FAR: f64 = 30.0;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let rules = trials.whole;
    let Some((task, first)) = rules.tasks.get(RuleSet::ONLY_TASK).zip(trials.trials.first()) else {
        return Vec::new();
    };
    let objective = &task.objective;
    let values = trials.values(&objective.value);
    let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let ahead = most * task.model.duration / first.drive.task().model.duration;
    if values.len() < ENOUGH || ahead <= 0.0 {
        return Vec::new();
    }
    let mut found: Vec<Diagnostic> = heavy(rules, objective, ahead);
    found.extend(hot(rules, objective, ahead));
    found
}

/// Preferences that count far more than the objective.
fn heavy(rules: &RuleSet, objective: &Objective, ahead: f64) -> Vec<Diagnostic> {
    let weight_of = |weight| evaluate(weight, rules, &mut Vec::new()).ok()?.as_number();
    let heavy = rules.preferences.iter().filter_map(|preference| {
        let weight = weight_of(&preference.weight)?;
        (weight > FAR * ahead).then(|| {
            odd(
                preference.weight.span,
                format!("the preference `{}` counts far more than the objective", preference.name),
            )
            .label(format!(
                "{weight}, and short motions come to {} at the most if they go on in the same way",
                with_unit(ahead, objective)
            ))
            .help("the weight is on the scale of the objective; for what must hold, write `require`")
        })
    });
    heavy.collect()
}

/// A temperature at which a search accepts everything.
fn hot(rules: &RuleSet, objective: &Objective, ahead: f64) -> Option<Diagnostic> {
    let begins = |temperature| evaluate(temperature, &Begins(rules), &mut Vec::new()).ok()?.as_number();
    let temperatures = rules.search.loops().filter_map(|(_, method)| begins(method.temperature()?));
    let highest = temperatures.fold(0.0, f64::max);
    (highest > FAR * ahead).then(|| {
        odd(objective.value.span, "the temperature of the search is on another scale than this objective".to_owned())
            .label(format!(
                "it begins at {highest}, and short motions come to {} at the most if they go on in the same way",
                with_unit(ahead, objective)
            ))
            .help("losses of about the temperature are accepted: choose it, or the unit of the objective, so that it is a part of what a good design comes to. If nothing moves the robot, do its legs reach the ground?")
    })
}

/// A search that begins. What it knows only later has no value.
struct Begins<'r>(&'r RuleSet);

impl Scope for Begins<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.0)
    }

    fn word(&self, word: Word) -> Option<Value> {
        matches!(word, Word::Search(SearchWord::Iteration | SearchWord::Chain)).then_some(Value::Number(0.0))
    }
}

/// A value with two digits.
fn with_unit(value: f64, objective: &Objective) -> String {
    let digits = (1.0 - libm::floor(libm::log10(value.abs()))).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$} {}", objective.unit).trim_end().to_owned()
}
