//! Distributions and probabilities that cannot be: a negative deviation, a list of
//! weights of another length than the domain, a probability beyond 1.

use crate::bounds::{Interval, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Choice, Expr, Kernel, Spread};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.rules() {
        let mut asks = Asks { reasoning: known.reasoning(&locals.all) };
        findings.extend(rule.choices.iter().filter_map(|choice| asks.spread(choice)));
    }
    let mut asks = Asks { reasoning: known.reasoning(&[]) };
    for variable in known.ruleset.actuations.values().flat_map(|a| &a.variables) {
        findings.extend(asks.probability(&variable.mutation.probability));
        findings.extend(match &variable.mutation.kernel {
            Kernel::Flip => None,
            Kernel::Normal(_, deviation) => asks.deviation(deviation),
            Kernel::Uniform(low, high) => asks.ends(low, high),
        });
    }
}

struct Asks<'f> {
    reasoning: Reasoning<'f>,
}

impl Asks<'_> {
    fn numbers(&mut self, expr: &Expr) -> Interval {
        self.reasoning.numbers(expr)
    }

    fn spread(&mut self, choice: &Choice) -> Option<Diagnostic> {
        match &choice.spread {
            Spread::Even | Spread::Fixed => None,
            Spread::Normal(_, deviation) => self.deviation(deviation),
            Spread::Uniform(low, high) => self.ends(low, high),
            Spread::Weights(weights) => self.weights(choice, weights),
        }
    }

    fn deviation(&mut self, deviation: &Expr) -> Option<Diagnostic> {
        let negative = self.numbers(deviation).high < 0.0;
        negative.then(|| {
            Diagnostic::new(Code::BAD_SPREAD, deviation.span, "a deviation cannot be negative")
                .label("always below zero")
                .help("the second number of `normal` says how wide it is: write it without the sign")
        })
    }

    fn ends(&mut self, low: &Expr, high: &Expr) -> Option<Diagnostic> {
        let swapped = self.numbers(low).low > self.numbers(high).high;
        swapped.then(|| {
            Diagnostic::new(Code::BAD_SPREAD, low.span, "there is nothing between these ends")
                .label("always above the other end")
                .also(high.span, "the other end")
                .help("write the lower end first")
        })
    }

    fn weights(&mut self, choice: &Choice, weights: &Expr) -> Option<Diagnostic> {
        let list = self.reasoning.value(weights);
        let (values, given) = (self.reasoning.value(&choice.domain).length(), list.length());
        if let (Some(values), Some(given)) = (values.single(), given.single())
            && values != given
        {
            let message = format!("{given} weights for {values} values of `{}`", choice.name);
            return Some(
                Diagnostic::new(Code::BAD_SPREAD, weights.span, message)
                    .label(format!("{given} weights"))
                    .also(choice.domain.span, format!("{values} values"))
                    .help("write one weight for each value, in the same order"),
            );
        }
        let nothing = given.high > 0.0 && list.item().numbers().high <= 0.0;
        nothing.then(|| {
            let message = format!("no value of `{}` is ever drawn", choice.name);
            Diagnostic::new(Code::BAD_SPREAD, weights.span, message)
                .label("none is above zero")
                .help("give at least one value a weight above zero")
        })
    }

    fn probability(&mut self, probability: &Expr) -> Option<Diagnostic> {
        let p = self.numbers(probability);
        (p.high < 0.0 || p.low > 1.0).then(|| {
            Diagnostic::new(Code::BAD_SPREAD, probability.span, "a probability lies within 0 .. 1")
                .label("always outside")
                .help("write it as a share: 0.3, or 30 %")
        })
    }
}
