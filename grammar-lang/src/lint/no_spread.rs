//! Draws that always give the same: a deviation of zero, ends that are equal.

use crate::bounds::Reasoning;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Choice, Expr, Kernel, Spread};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.all);
        for choice in &rule.choices {
            let (what, is_single) = match &choice.spread {
                Spread::Normal(_, deviation) => (deviation, is_zero(&mut reasoning, deviation)),
                Spread::Uniform(low, high) => (high, is_same(&mut reasoning, low, high)),
                Spread::Even | Spread::Fixed | Spread::Weights(_) => continue,
            };
            if is_single || is_beyond(&mut reasoning, choice) {
                findings.push(told(what, &format!("`{}` is always drawn the same", choice.name)));
            }
        }
    }
    let mut reasoning = known.reasoning(&[]);
    for variable in known.ruleset.actuations.values().flat_map(|a| &a.variables) {
        let (what, is_single) = match &variable.mutation.kernel {
            // Of a mean beside zero something is left: it drifts.
            Kernel::Normal(mean, deviation) => {
                (deviation, is_zero(&mut reasoning, mean) && is_zero(&mut reasoning, deviation))
            }
            Kernel::Uniform(low, high) => {
                (high, is_zero(&mut reasoning, low) && is_zero(&mut reasoning, high))
            }
            Kernel::Flip => continue,
        };
        if is_single {
            findings.push(told(what, &format!("`{}` never changes", variable.name)));
        } else if let Kernel::Normal(mean, _) = &variable.mutation.kernel {
            let (low, high) = variable.domain;
            let mean = reasoning.numbers(mean);
            if mean.low > high - low || mean.high < low - high {
                findings.push(told(
                    what,
                    &format!("each move takes `{}` to an end of its domain", variable.name),
                ));
            }
        }
    }
}

/// Whether the mean of a normal distribution lies so far outside of the domain that an end of it is always drawn.
fn is_beyond(reasoning: &mut Reasoning<'_>, choice: &Choice) -> bool {
    let Spread::Normal(mean, deviation) = &choice.spread else { return false };
    let within = reasoning.value(&choice.domain).item().numbers();
    let far = 6.0 * reasoning.numbers(deviation).high;
    let mean = reasoning.numbers(mean);
    within.is_finite() && (mean.low - far > within.high || mean.high + far < within.low)
}

fn is_zero(reasoning: &mut Reasoning<'_>, expr: &Expr) -> bool {
    reasoning.numbers(expr).single() == Some(0.0)
}

fn is_same(reasoning: &mut Reasoning<'_>, low: &Expr, high: &Expr) -> bool {
    let low = reasoning.numbers(low).single();
    low.is_some() && low == reasoning.numbers(high).single()
}

fn told(what: &Expr, message: &str) -> Diagnostic {
    Diagnostic::new(Code::NO_SPREAD, what.span, message)
        .label("nothing is left to draw")
        .help("give it a width above zero, and a mean within the domain; what shall stay the same is a `let`")
}
