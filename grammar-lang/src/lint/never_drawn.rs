//! A rule, or a value of a choice, whose weight is never above zero, or next to nothing beside that of another.

use crate::bounds::Interval;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Choice, Expr, ExprKind, Spread};

use super::known::Known;

/// A rule whose weight is below this share of another's is not drawn in a whole run.
const HARDLY: f64 = 1e-3;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for rule in &known.ruleset.rules {
        if known.numbers(&rule.weight).high <= 0.0 {
            findings.push(
                Diagnostic::new(
                    Code::NEVER_DRAWN,
                    rule.weight.span,
                    format!("the rule `{}` is never drawn", rule.name),
                )
                .label("never above zero")
                .help("give it a weight above zero, or remove the rule"),
            );
        }
    }
    for choice in known.ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        findings.extend(value_never_drawn(known, choice));
    }
    let weighed = known.ruleset.rules.iter().map(|rule| (rule, known.numbers(&rule.weight)));
    let Some((most, heaviest)) = weighed.clone().max_by(|a, b| a.1.low.total_cmp(&b.1.low)) else { return };
    let hardly = |(_, weight): &(_, Interval)| weight.high > 0.0 && weight.high < HARDLY * heaviest.low;
    if let Some((least, _)) = weighed.clone().find(hardly) {
        findings.push(
            Diagnostic::new(
                Code::NEVER_DRAWN,
                most.weight.span,
                format!("because of this weight, the rule `{}` is hardly ever drawn", least.name),
            )
            .label(format!("more than {:.0} times as often", (1.0 / HARDLY)))
            .also(least.span, "less than once in a whole run")
            .help("weights are relative: every rule without one has a weight of 1"),
        );
    }
}

/// A value of a set whose weight is zero, whatever the parameters are.
fn value_never_drawn(known: &Known<'_>, choice: &Choice) -> Option<Diagnostic> {
    let (Spread::Weights(weights), ExprKind::Set(items)) = (&choice.spread, &choice.domain.kind) else {
        return None;
    };
    let ExprKind::List(weights) = &weights.kind else { return None };
    let number = |weight: &Expr| known.fixed(weight)?.as_number();
    let place = weights.iter().position(|weight| number(weight).is_some_and(|x| x <= 0.0))?;
    let (weight, item) = (weights.get(place)?, items.get(place)?);
    Some(
        Diagnostic::new(
            Code::NEVER_DRAWN,
            weight.span,
            format!("a value of `{}` is never drawn", choice.name),
        )
        .label("its weight is zero")
        .also(item.span, "this value")
        .help(
            "leave the value out, or give it a weight above zero; a parameter as a weight can switch it off",
        ),
    )
}
