//! Distributions and probabilities that cannot be: a negative deviation, a list of
//! weights of another length than the domain, a probability beyond 1.

use crate::bounds::{Interval, Reasoning};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Choice, Expr, ExprKind, Kernel, Spread, Ty, Variable};
use crate::units::shown;

use super::known::Known;

/// A deviation is tiny if it is less than this share of the domain.
const TINY: f64 = 1e-3;
/// A Bool that changes more often than this changes in nearly every move.
const OFTEN: f64 = 0.9;
/// One that changes less often hardly ever does.
const SELDOM: f64 = 1e-3;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.rules() {
        let mut asks = Asks { reasoning: known.reasoning(&locals.all) };
        findings.extend(rule.choices.iter().filter_map(|choice| asks.spread(choice)));
    }
    let mut asks = Asks { reasoning: known.reasoning(&[]) };
    for variable in known.ruleset.actuations.values().flat_map(|a| &a.variables) {
        findings.extend(asks.probability(&variable.mutation.probability));
        findings.extend(match &variable.mutation.kernel {
            Kernel::Flip => asks.always_flips(variable).or_else(|| asks.never_flips(variable)),
            Kernel::Normal(mean, deviation) => asks
                .deviation(deviation)
                .or_else(|| asks.beyond(variable, deviation))
                .or_else(|| asks.tiny(variable, deviation))
                .or_else(|| asks.one_way(variable, mean, deviation)),
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
            Spread::Normal(mean, deviation) => {
                self.deviation(deviation).or_else(|| self.far(choice, mean, deviation))
            }
            Spread::Uniform(low, high) => self.ends(low, high).or_else(|| self.outside(choice, low, high)),
            Spread::Weights(weights) => self.weights(choice, weights),
        }
    }

    /// A uniform distribution between ends that no value of the domain lies between.
    fn outside(&mut self, choice: &Choice, low: &Expr, high: &Expr) -> Option<Diagnostic> {
        let within = self.reasoning.value(&choice.domain).item().numbers();
        let (low_end, high_end) = (self.numbers(low), self.numbers(high));
        let apart = low_end.low > within.high || high_end.high < within.low;
        // Of whole numbers there may be none between ends that are near to each other.
        let whole = choice.domain.ty == Ty::Domain(Box::new(Ty::Count));
        let (least, most) = (low_end.low.max(within.low), high_end.high.min(within.high));
        let skipped = whole && least.ceil() > most.floor();
        (apart || skipped).then(|| never(choice, low, "no value of the domain lies between these ends"))
    }

    /// A normal distribution so far away from the domain that a draw never hits it.
    fn far(&mut self, choice: &Choice, mean: &Expr, deviation: &Expr) -> Option<Diagnostic> {
        let within = self.reasoning.value(&choice.domain).item().numbers();
        // Values that can be listed are weighed, and weights vanish later than draws do.
        let whole = choice.domain.ty == Ty::Domain(Box::new(Ty::Count));
        let far = if whole { 39.0 } else { 8.0 } * self.numbers(deviation).high;
        let middle = self.numbers(mean);
        let beyond = within.is_finite() && (middle.low - far > within.high || middle.high + far < within.low);
        beyond.then(|| never(choice, mean, "too far from the domain, given the deviation"))
    }

    fn deviation(&mut self, deviation: &Expr) -> Option<Diagnostic> {
        let negative = self.numbers(deviation).high < 0.0;
        negative.then(|| {
            Diagnostic::new(Code::BAD_SPREAD, deviation.span, "a deviation cannot be negative")
                .label("always below zero")
                .help("the second number of `normal` is the deviation: write it without the minus sign")
        })
    }

    /// Changes that go one way nearly always: their mean is further from zero than their deviation.
    fn one_way(&mut self, variable: &Variable, mean: &Expr, deviation: &Expr) -> Option<Diagnostic> {
        let (middle, most) = (self.numbers(mean), self.numbers(deviation).high);
        let nearest = if middle.low > 0.0 { middle.low } else { -middle.high };
        (most > 0.0 && nearest > 0.0 && nearest >= most).then(|| {
            Diagnostic::new(
                Code::UNUSUAL,
                mean.span,
                format!("changes of `{}` go one way nearly always", variable.name),
            )
            .label("the mean of the changes is further from zero than their deviation")
            .help("a search must be able to come back: give the changes a mean of zero, as in `normal(0 deg, 20 deg)`")
        })
    }

    /// A Bool that nearly every change inverts.
    fn always_flips(&mut self, variable: &Variable) -> Option<Diagnostic> {
        let chance = &variable.mutation.probability;
        (self.numbers(chance).low > OFTEN).then(|| {
            Diagnostic::new(
                Code::UNUSUAL,
                chance.span,
                format!("nearly every move inverts `{}`", variable.name),
            )
            .label("so that no move keeps it and changes something else")
            .help("a usual probability is 10 %: write `flip 0.1`")
        })
    }

    /// A Bool that hardly any change inverts.
    fn never_flips(&mut self, variable: &Variable) -> Option<Diagnostic> {
        let chance = &variable.mutation.probability;
        // Never at all is told as what never changes.
        let most = self.numbers(chance).high;
        (most > 0.0 && most < SELDOM).then(|| {
            Diagnostic::new(
                Code::UNUSUAL,
                chance.span,
                format!("hardly any move inverts `{}`", variable.name),
            )
            .label("less than one move of a thousand")
            .help("a usual probability is 10 %: write `flip 0.1`")
        })
    }

    /// A deviation that is larger than the whole domain, whatever the search does: nearly every change ends at an end of it.
    fn beyond(&mut self, variable: &Variable, deviation: &Expr) -> Option<Diagnostic> {
        let (least, width) = (self.numbers(deviation).low, variable.domain.1 - variable.domain.0);
        let dimension = variable.ty.dimension()?;
        (width > 0.0 && least > width * (1.0 + 1e-9)).then(|| {
            Diagnostic::new(
                Code::UNUSUAL,
                deviation.span,
                format!("a change of `{}` is mostly larger than its whole domain", variable.name),
            )
            .label(format!("the domain is only {} wide", shown(width, dimension)))
            .help("write a smaller deviation, such as a fifth of the domain")
        })
    }

    /// A deviation that is tiny beside the domain, whatever the search does: it takes thousands of changes to cross it.
    fn tiny(&mut self, variable: &Variable, deviation: &Expr) -> Option<Diagnostic> {
        let (most, width) = (self.numbers(deviation).high, variable.domain.1 - variable.domain.0);
        let dimension = variable.ty.dimension()?;
        (most > 0.0 && most < TINY * width).then(|| {
            Diagnostic::new(
                Code::UNUSUAL,
                deviation.span,
                format!("changes of `{}` are tiny beside its domain", variable.name),
            )
            .label(format!(
                "at most {}, and the domain is {} wide",
                shown(most, dimension),
                shown(width, dimension)
            ))
            .help("is the unit right? Write for example a fifth of the domain")
        })
    }

    fn ends(&mut self, low: &Expr, high: &Expr) -> Option<Diagnostic> {
        let swapped = self.numbers(low).low > self.numbers(high).high;
        swapped.then(|| {
            Diagnostic::new(Code::BAD_SPREAD, low.span, "the ends of `uniform` are in the wrong order")
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
        if let ExprKind::List(each) = &weights.kind
            && let Some(negative) = each.iter().find(|weight| self.numbers(weight).high < 0.0)
        {
            let message = format!("a weight of `{}` is negative", choice.name);
            return Some(
                Diagnostic::new(Code::BAD_SPREAD, negative.span, message)
                    .label("always below zero")
                    .help("write 0 for a value that must not be drawn"),
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
            Diagnostic::new(Code::BAD_SPREAD, probability.span, "a probability must lie within 0 .. 1")
                .label("always outside")
                .help("write it as a share: 0.3, or 30 %")
        })
    }
}

/// A choice of which no value is ever drawn.
fn never(choice: &Choice, place: &Expr, why: &str) -> Diagnostic {
    Diagnostic::new(Code::BAD_SPREAD, place.span, format!("no value of `{}` is ever drawn", choice.name))
        .label(why)
        .also(choice.domain.span, "the domain")
        .help("choose a distribution that overlaps the domain")
}
