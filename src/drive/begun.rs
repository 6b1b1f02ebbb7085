//! What is found in a grammar once its initial design and its examples are driven.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use grammar_lang::Compiled;
use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::{EvalError, MOST_OPERATIONS};
use grammar_lang::ir::{RuleSet, Symmetry};
use grammar_lang::source::{FileId, SourceMap, Span};

use super::untunable::Untunable;
use super::{Drive, uneven};
use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation, check_begun, run_example};

/// Draws of what the actuations vary, and moments of a motion, at which a drive must have a value somewhere.
const DRAWS: u64 = 4;
const MOMENTS: usize = 32;
/// How many operations all of this may take: more than all draws of one expression that takes too long by itself, which is told.
const TRIED: u64 = (DRAWS + 1) * MOST_OPERATIONS;

/// The example that a finding is about; none for the initial design.
type Where<'a> = Option<(&'a str, Span)>;

/// All that is found in a grammar once its initial design and its examples are driven.
#[must_use]
pub fn check_driven(compiled: &Compiled, entry: FileId, sources: &SourceMap) -> Vec<Diagnostic> {
    let mut found = check_begun(compiled, entry, sources);
    if let Some(rules) = compiled.ruleset.as_ref().filter(|_| !found.iter().any(Diagnostic::is_error)) {
        found.extend(check_drives(rules));
    }
    found
}

/// An error for each drive that never has a value, and a warning for each kind of actuator that swings unevenly across the
/// mirror, in the initial design or in an example.
fn check_drives(rules: &RuleSet) -> Vec<Diagnostic> {
    let begun = (None, Derivation::begin(rules));
    let examples = rules.examples.iter().filter_map(|(name, example)| {
        Some((Some((name.as_str(), example.span)), run_example(rules, name, example).ok()?))
    });
    let mut found: Vec<Diagnostic> = Vec::new();
    let left = Arc::new(AtomicU64::new(TRIED));
    // What is cut short says nothing.
    let is_spent = || left.load(Ordering::Relaxed) == 0;
    for (example, derivation) in std::iter::once(begun).chain(examples) {
        let candidate = Candidate::new(rules, Arc::new(derivation));
        for task in rules.tasks.values() {
            let drive = match Drive::new(&candidate, task) {
                Ok(drive) => drive.tried_with(&left),
                Err(error) => {
                    found.push(
                        no_value(error, example).help("each actuator needs a value that gives its group"),
                    );
                    continue;
                }
            };
            if let Some(why) = drive.untunable() {
                found.extend(
                    Some(untunable(&why, example))
                        .filter(|one| found.iter().all(|known| known.span() != one.span())),
                );
                continue;
            }
            let driven = drive.never_has_a_value().map(|error| {
                no_value(error, example).help(
                    "what drives an actuator needs a value at each time of the motion, from `t = 0 s` on",
                )
            });
            let gained = || {
                drive.reward_fails_at_rest().map(|error| {
                    no_value(error, example)
                        .help("a reward needs a value at each decision, even while the body stands still")
                })
            };
            let one = match driven.or_else(gained) {
                Some(told) => Some(told),
                None if !matches!(rules.symmetry, Symmetry::Mirror(_)) => None,
                None => drive.uneven_swing().ok().flatten().map(|(kind, a)| uneven::told(&kind, a, example)),
            };
            if is_spent() {
                return found;
            }
            found.extend(one.filter(|one| found.iter().all(|known| known.span() != one.span())));
        }
    }
    found
}

fn untunable(why: &Untunable<'_>, example: Where<'_>) -> Diagnostic {
    let told = match why {
        Untunable::TooMany { name, span, values, most } => Diagnostic::new(
            Code::OUT_OF_DOMAIN,
            *span,
            format!("`{name}` gives this body too many values for its search"),
        )
        .label(format!("{values} values in all; at most {most} can be tuned"))
        .help("vary fewer values, or make `hidden` of a policy smaller; `annealing` tunes more values than `cma_es`"),
        Untunable::OnNoSide { name, span, kind } => Diagnostic::new(
            Code::MODEL_MISFIT,
            *span,
            format!("`{name}` decides for the two sides of a robot, but a `{kind}` has no mirror image"),
        )
        .label("`mirrored` gives it two sides")
        .help("place the actuator beside the plane of a mirror (`symmetry mirror xy`), or leave out `mirrored`: then there is one network for the whole robot"),
    };
    match example {
        Some((name, span)) => told.also(span, format!("here in `{name}`")),
        None => told,
    }
}

fn no_value(EvalError { span, reason }: EvalError, example: Where<'_>) -> Diagnostic {
    let told =
        Diagnostic::new(Code::NO_VALUE, span, "this has no value, whatever the search varies").label(reason);
    match example {
        Some((name, span)) => told.also(span, format!("here in `{name}`")),
        None => told,
    }
}

impl Drive<'_> {
    /// Why an actuator is driven to nothing at some time of the motion, if it is so whatever the search draws.
    fn never_has_a_value(&self) -> Option<EvalError> {
        let mut first = None;
        for draw in 0..DRAWS {
            let parameters = self.draw(&mut Stream::named(draw, "drives"));
            match self.has_values(&parameters) {
                Ok(()) => return None,
                Err(error) => first = first.or(Some(error)),
            }
        }
        first
    }

    fn has_values(&self, parameters: &[f64]) -> Result<(), EvalError> {
        let duration = self.task.model.duration;
        for driven in &self.actuators {
            if !self.reacts(driven) && self.valves(driven, parameters)?.is_none() {
                let times = (0..=MOMENTS).map(|moment| duration * moment as f64 / MOMENTS as f64);
                self.bends(driven, parameters, times)?;
            }
        }
        self.control_law(parameters)?.fails_at_first(MOMENTS).map_or(Ok(()), Err)
    }
}
