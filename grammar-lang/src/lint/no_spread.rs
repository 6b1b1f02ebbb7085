//! Draws that always give the same: a deviation of zero, ends that are equal.

use crate::bounds::Reasoning;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, Kernel, Spread};

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
            if is_single {
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
        }
    }
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
        .label("no width")
        .help("give it a width above zero; what shall stay the same is a `let`")
}
