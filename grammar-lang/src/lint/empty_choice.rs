//! A choice with nothing to choose from, and parameters chosen outside their domain.

use crate::bounds::{Abstract, Repeated};
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{Effect, ExprKind, Rule, Settable};
use crate::units;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for (rule, locals) in known.rules() {
        for choice in &rule.choices {
            let Ok(Value::Domain(domain)) = known.value(&choice.domain) else {
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
        known.reasoning(&locals.narrowed).through_effects(
            &rule.effects,
            Repeated::Together,
            &mut |reasoning, effect| match effect {
                Effect::Attach { what, .. } | Effect::Replace { with: what, .. } => {
                    what.any(&mut |e| {
                        if let ExprKind::Kind(kind, params) = &e.kind {
                            let all = params.iter();
                            findings.extend(all.filter_map(|(n, v)| out_of_domain(known, rule, kind, n, v)));
                        }
                        false
                    });
                }
                Effect::Set { part, attribute: Settable::Param(name), value } => {
                    let Abstract::Part(kinds) = reasoning.value(part) else { return };
                    let kinds = known.facts.names(&kinds);
                    let has = |kind: &&str| ruleset.params_of(kind).is_some_and(|p| p.contains_key(name));
                    // A value that is beyond one actuator's domain may be meant for the others.
                    let beyond = kinds.into_iter().filter(has);
                    let beyond = beyond.map(|kind| out_of_domain(known, rule, kind, name, value));
                    let beyond: Option<Vec<Diagnostic>> = beyond.collect();
                    findings.extend(beyond.into_iter().flatten().next());
                }
                Effect::Cells(cells) => {
                    if let Some(ExprKind::Kind(kind, params)) = cells.with.as_ref().map(|with| &with.kind) {
                        let all = params.iter();
                        findings.extend(all.filter_map(|(n, v)| out_of_domain(known, rule, kind, n, v)));
                    }
                }
                Effect::SetOfBody { name, value } => {
                    let domain = ruleset.params.get(name).and_then(|param| param.domain);
                    let beyond = |domain| beyond_domain(known, rule, (&format!("`{name}`"), domain), value);
                    findings.extend(domain.and_then(beyond));
                }
                Effect::Set { attribute: Settable::Turn, .. }
                | Effect::Remove(_)
                | Effect::Revert(_)
                | Effect::Repeat { .. }
                | Effect::Let(_)
                | Effect::Then => {}
            },
        );
    }
}

/// `segments = n` where `n` is chosen from more than `segments` may be.
fn out_of_domain(
    known: &Known<'_>,
    rule: &Rule,
    kind: &str,
    name: &str,
    value: &crate::ir::Expr,
) -> Option<Diagnostic> {
    let domain = known.ruleset.params_of(kind)?.get(name)?.domain?;
    beyond_domain(known, rule, (&format!("`{name}` of `{kind}`"), domain), value)
}

/// The same for what has this domain.
fn beyond_domain(
    known: &Known<'_>,
    rule: &Rule,
    (what, (low, high)): (&str, (f64, f64)),
    value: &crate::ir::Expr,
) -> Option<Diagnostic> {
    let ExprKind::Local(slot) = value.kind else { return None };
    let choice = rule.locals.get(slot).and_then(|n| rule.choices.iter().find(|c| c.name == *n))?;
    let Ok(Value::Domain(domain)) = known.value(&choice.domain) else { return None };
    let beyond = match &*domain {
        crate::eval::Domain::Range { low, high, .. } => vec![*low, *high],
        crate::eval::Domain::Items(items) => items.iter().filter_map(Value::as_number).collect(),
    }
    .into_iter()
    .find(|x| *x < low || *x > high);
    let shown = |x| units::shown(x, value.ty.dimension().unwrap_or_default());
    beyond.map(|x| {
        Diagnostic::new(
            Code::OUT_OF_DOMAIN,
            choice.domain.span,
            format!("{what} would be outside its domain"),
        )
        .label(format!("{} is not within {} .. {}", shown(x), shown(low), shown(high)))
        .also(value.span, "used here")
        .help("narrow the choice, or widen the parameter's domain")
    })
}
