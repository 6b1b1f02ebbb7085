//! Draws that always give the same: a deviation of zero, ends that are equal.

use crate::bounds::Reasoning;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Bound, Choice, CurveMethod, Difference, Expr, Kernel, Spread, Ty};

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
                findings.push(told(what, &format!("`{}` always gets the same value", choice.name)));
            }
        }
    }
    for (name, set) in &known.ruleset.scenarios {
        let same = |(low, high): &(f64, f64)| low == high;
        if set.drawn > 0 && !set.ranges.is_empty() && set.ranges.values().all(same) {
            let message = format!("all worlds that `{name}` draws are the same");
            let fixed = Diagnostic::new(Code::NO_SPREAD, set.span, message);
            findings.push(
                fixed
                    .label("every range contains only one value")
                    .help("give a range a width, or write one `case` for this world"),
            );
        }
        let ground: Vec<f64> = known.ruleset.tasks.values().map(|task| task.model.ground_friction).collect();
        let is_nominal = |(differs, value): (&Difference, &f64)| match differs {
            Difference::GroundFriction => !ground.is_empty() && ground.iter().all(|own| own == value),
            Difference::Tilt | Difference::Slope | Difference::Late => *value == 0.0,
            _ => Ty::from(*differs) == Ty::NUMBER && *value == 1.0,
        };
        let unchanged = set.cases.iter().find(|(_, differs)| differs.iter().all(is_nominal));
        if let Some((one, _)) = unchanged {
            let message = format!("the case `{one}` of `{name}` is the nominal world");
            let nominal = Diagnostic::new(Code::NO_SPREAD, set.span, message);
            findings.push(nominal.label("nothing differs there").help(
                "leave it out: every set has the nominal world; or let something differ, as in `mass = 90 %`",
            ));
        }
        let mut cases = set.cases.iter();
        while let Some((one, differs)) = cases.next() {
            if let Some((other, _)) = cases.clone().find(|(_, other)| *other == differs) {
                let message = format!("the cases `{one}` and `{other}` of `{name}` are the same world");
                let twice = Diagnostic::new(Code::NO_SPREAD, set.span, message);
                findings.push(twice.label("counts twice").help("leave one of them out, or make them differ"));
            }
        }
    }
    for (name, param) in &known.ruleset.params {
        if param.domain.is_some_and(|(low, high)| low == high) {
            findings.push(
                Diagnostic::new(Code::NO_SPREAD, param.span, format!("`{name}` can only have one value"))
                    .label("both ends of its domain are the same")
                    .help("give its domain a width; for a fixed value, use `let`"),
            );
        }
    }
    for variable in known.ruleset.actuations.values().flat_map(|a| &a.variables) {
        if variable.domain.0 == variable.domain.1 {
            findings.push(
                Diagnostic::new(Code::NO_SPREAD, variable.span, format!("`{}` has one value", variable.name))
                    .label("both ends are the same")
                    .help("give its domain a width; for a fixed value, use `let`"),
            );
        }
    }
    // Others than annealing use no mutations.
    let curves = known.ruleset.search.curves.as_ref();
    if curves.is_some_and(|curves| !matches!(curves.method, CurveMethod::Annealing(_))) {
        return;
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
            Kernel::Flip => (&variable.mutation.probability, false),
        };
        if is_zero(&mut reasoning, &variable.mutation.probability) {
            let never = format!("`{}` never changes", variable.name);
            findings.push(
                Diagnostic::new(Code::NO_SPREAD, variable.mutation.probability.span, never)
                    .label("a probability of zero")
                    .help("give it a probability above zero; for a fixed value, use `let`"),
            );
        } else if is_single {
            findings.push(told(what, &format!("`{}` never changes", variable.name)));
        } else if let Kernel::Normal(mean, deviation) = &variable.mutation.kernel {
            let (low, high) = variable.domain;
            let mean = reasoning.numbers(mean);
            let (least, most) = (mean.low.max(-mean.high), reasoning.numbers(deviation).high);
            if least > 0.0 && most == 0.0 {
                findings.push(
                    Diagnostic::new(
                        Code::NO_SPREAD,
                        deviation.span,
                        format!("each move changes `{}` by the same amount", variable.name),
                    )
                    .label("a deviation of zero")
                    .help(
                        "the mean comes first, and is usually 0: write for example `normal(0 deg, 20 deg)`",
                    ),
                );
            } else if mean.low > high - low || mean.high < low - high {
                findings.push(told(
                    what,
                    &format!("each move takes `{}` to an end of its domain", variable.name),
                ));
            }
        } else if let Kernel::Uniform(low, high) = &variable.mutation.kernel {
            let (least, most) = (reasoning.numbers(low), reasoning.numbers(high));
            let stays = variable.mutation.bound == Bound::Clamp;
            if stays && (least.low >= 0.0 || most.high <= 0.0) {
                let way = if least.low >= 0.0 { "larger" } else { "smaller" };
                findings.push(
                    Diagnostic::new(
                        Code::NO_SPREAD,
                        low.span.join(high.span),
                        format!("each move makes `{}` {way}, or leaves it as it is", variable.name),
                    )
                    .label("never the other way")
                    .help("what is drawn is added to the value: write both signs, such as `uniform(-10 deg, 10 deg)`"),
                );
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
        .label("this gives only one value")
        .help("give it a width above zero, and a mean within the domain; for a fixed value, use `let`")
}
