//! Whether the initial design fulfils the requirements.

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::ir::RuleSet;

use super::Derivation;

/// Reports the requirement that the initial design breaks, if it does.
#[must_use]
pub fn check_start(rules: &RuleSet) -> Option<Diagnostic> {
    let start = Derivation::begin(rules);
    match start.broken(rules) {
        Ok(None) => None,
        Ok(Some(i)) => {
            let requirement = rules.requirements.get(i)?;
            let reason =
                requirement.because.as_ref().map_or(String::new(), |b| format!(" (because \"{b}\")"));
            let mut error = Diagnostic::new(
                Code::START_BREAKS,
                requirement.condition.span,
                format!("the initial design breaks `{}`{reason}", requirement.name),
            )
            .label("does not hold at the start")
            .help("every design starts from `begin`: relax the requirement, or begin with another design");
            if let Some(placed) = rules.begin.first() {
                error = error.also(placed.span, "the initial design");
            }
            Some(error)
        }
        Err(error) => Some(
            Diagnostic::new(Code::NO_VALUE, error.span, "this has no value for the initial design")
                .label(error.reason),
        ),
    }
}
