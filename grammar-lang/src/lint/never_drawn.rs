//! A rule whose weight is never above zero, or next to nothing beside that of another.

use crate::bounds::Interval;
use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

/// A rule whose weight is below this share of another's is not drawn in a whole run.
const HARDLY: f64 = 1e-5;

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
    let weighed = known.ruleset.rules.iter().map(|rule| (rule, known.numbers(&rule.weight)));
    let Some((most, heaviest)) = weighed.clone().max_by(|a, b| a.1.low.total_cmp(&b.1.low)) else { return };
    let hardly = |(_, weight): &(_, Interval)| weight.high > 0.0 && weight.high < HARDLY * heaviest.low;
    if let Some((least, _)) = weighed.clone().find(hardly) {
        findings.push(
            Diagnostic::new(
                Code::NEVER_DRAWN,
                most.weight.span,
                format!("beside this weight, the rule `{}` is hardly ever drawn", least.name),
            )
            .label(format!("more than {:.0} times as often", (1.0 / HARDLY)))
            .also(least.span, "less than once in a whole run")
            .help("weights are relative: every rule without one has a weight of 1"),
        );
    }
}
