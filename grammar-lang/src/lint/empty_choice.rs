//! A choice with nothing to choose from, and parameters chosen outside their domain.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{Value, evaluate};
use crate::ir::{Effect, ExprKind, Rule, RuleSet};
use crate::units;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for rule in &ruleset.rules {
        for choice in &rule.choices {
            let Ok(Value::Domain(domain)) = evaluate(&choice.domain, ruleset, &mut Vec::new()) else {
                continue;
            };
            let whole = matches!(&*domain, crate::eval::Domain::Range { whole: true, .. });
            let inverted = matches!(&*domain, crate::eval::Domain::Range { low, high, .. } if low > high);
            if whole && domain.count() == 0 && !inverted {
                findings.push(
                    Diagnostic::new(
                        Code::EMPTY_DOMAIN,
                        choice.domain.span,
                        "there is no whole number in this range",
                    )
                    .label(format!("`{}` has nothing to choose from", choice.name)),
                );
            }
        }
        for effect in &rule.effects {
            if let Effect::Attach { what, .. } = effect {
                what.any(&mut |e| {
                    if let ExprKind::Kind(kind, params) = &e.kind {
                        for (name, value) in params {
                            out_of_domain(ruleset, rule, kind, name, value, findings);
                        }
                    }
                    false
                });
            }
        }
    }
}

/// `segments = n` where `n` is chosen from more than `segments` may be.
fn out_of_domain(
    ruleset: &RuleSet,
    rule: &Rule,
    kind: &str,
    name: &str,
    value: &crate::ir::Expr,
    findings: &mut Vec<Diagnostic>,
) {
    let ExprKind::Local(slot) = value.kind else { return };
    let Some(choice) = rule.locals.get(slot).and_then(|n| rule.choices.iter().find(|c| c.name == *n)) else {
        return;
    };
    let Some((low, high)) =
        ruleset.actuators.get(kind).and_then(|a| a.params.get(name)).and_then(|p| p.domain)
    else {
        return;
    };
    let Ok(Value::Domain(domain)) = evaluate(&choice.domain, ruleset, &mut Vec::new()) else { return };
    let beyond = match &*domain {
        crate::eval::Domain::Range { low, high, .. } => vec![*low, *high],
        crate::eval::Domain::Items(items) => items.iter().filter_map(Value::as_number).collect(),
    }
    .into_iter()
    .find(|x| *x < low || *x > high);
    let shown = |x| units::shown(x, value.ty.dimension().unwrap_or_default());
    if let Some(x) = beyond {
        findings.push(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                choice.domain.span,
                format!("`{name}` of `{kind}` would be outside its domain"),
            )
            .label(format!("{} is not within {} .. {}", shown(x), shown(low), shown(high)))
            .also(value.span, "used here")
            .help("narrow the choice, or widen the parameter's domain"),
        );
    }
}
