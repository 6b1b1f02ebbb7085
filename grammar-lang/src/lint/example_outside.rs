//! An example that gives a choice a value outside its domain, as after a variant has narrowed it.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{Domain, Value};
use crate::ir::{Application, ExampleClause, Expr, ExprKind, Spread, Ty};
use crate::units;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (example, steps) in &known.ruleset.examples {
        for clause in &steps.clauses {
            if let ExampleClause::Refuse { application, by: Some(by) } = clause
                && let Some((place, domain, why)) = outside(known, application)
            {
                let message = format!(
                    "the example `{example}` fails: this step is refused because of a value, not by `{by}`"
                );
                findings.push(
                    Diagnostic::new(Code::EXAMPLE_FAILS, place.span, message)
                        .label(why)
                        .also(domain.span, "the domain")
                        .help(format!(
                            "give it a value within the domain, for which `{by}` refuses the step"
                        )),
                );
            }
            if let ExampleClause::Step { name, application, .. } = clause
                && let Some((place, domain, why)) = outside(known, application)
            {
                let message = format!("the example `{example}` fails: the step `{name}` cannot be applied");
                findings.push(
                    Diagnostic::new(Code::EXAMPLE_FAILS, place.span, message)
                        .label(why)
                        .also(domain.span, "the domain")
                        .help(format!(
                            "give it another value; in a variant, `drop {example}` or \
                             `replace example {example} {{ ... }}`"
                        )),
                );
            }
        }
    }
}

/// The first value that certainly cannot be chosen, the domain that it is not in, and why.
fn outside<'r>(all: &Known<'r>, application: &'r Application) -> Option<(&'r Expr, &'r Expr, String)> {
    let rule = all.ruleset.rule(&application.rule)?;
    let first = rule.locals.len().checked_sub(rule.choices.len())?;
    // A domain that depends on a parameter holds the value for other settings of it.
    let known = |e: &Expr| {
        let fixed = !e.any(&mut |e| matches!(e.kind, ExprKind::Param(_)));
        all.value(e).ok().filter(|_| fixed)
    };
    let given = rule.choices.iter().zip(application.values.iter().skip(first));
    given.filter(|(choice, _)| choice.spread != Spread::Fixed).find_map(|(choice, value)| {
        let value = value.as_ref()?;
        let (Value::Domain(domain), chosen) = (known(&choice.domain)?, known(value)?) else { return None };
        let why = format!("this value is outside the domain of `{}`", choice.name);
        let dimension = match &choice.domain.ty {
            Ty::Domain(item) => item.dimension(),
            _ => None,
        };
        let why = match (&*domain, dimension) {
            (Domain::Range { low, high, .. }, Some(d)) => {
                format!("{why} {} .. {}", units::shown(*low, d), units::shown(*high, d))
            }
            _ => why,
        };
        (!domain.holds(&chosen)).then_some((value, &choice.domain, why))
    })
}
