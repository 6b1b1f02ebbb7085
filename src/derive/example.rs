//! Examples: derivations that a grammar writes down by hand.

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::{Domain, EvalError, Reference, UNKNOWN_HERE, Value, evaluate};
use grammar_lang::ir::{Application, Example, ExampleClause, Expr, ExprKind, Rule, RuleSet, Spread, Ty};
use grammar_lang::source::Span;
use grammar_lang::units;

use super::choosing::domain_of;
use super::{Blocked, Derivation, DesignScope};
use crate::design::step_of;

/// Derives an example and checks what it expects.
///
/// # Errors
///
/// The first clause that does not hold, and why.
pub fn run_example(rules: &RuleSet, name: &str, example: &Example) -> Result<Derivation, Box<Diagnostic>> {
    let mut derivation = Derivation::begin(rules);
    let mut locals: Vec<Value> = Vec::new();
    let fail = |span: Span, message: String, reason: String| {
        Box::new(
            Diagnostic::new(Code::EXAMPLE_FAILS, span, format!("the example `{name}` fails: {message}"))
                .label(reason),
        )
    };
    let no_value = |e: EvalError| {
        let reason = if e.reason == UNKNOWN_HERE {
            "what this reads is not there (any more)".to_owned()
        } else {
            e.reason
        };
        fail(e.span, "an expression has no value".to_owned(), reason)
    };
    for clause in &example.clauses {
        match clause {
            ExampleClause::Expect(condition) => {
                let scope = DesignScope::new(rules, &derivation);
                match evaluate(condition, &scope, &mut locals.clone()).map_err(no_value)? {
                    Value::Bool(true) => {}
                    _ => {
                        return Err(fail(
                            condition.span,
                            "an expectation does not hold".into(),
                            falsehood(condition, &scope, &locals),
                        ));
                    }
                }
            }
            ExampleClause::Step { name, application } => {
                let step = apply(rules, &derivation, application, &locals).map_err(no_value)?;
                let step = step.map_err(|reason| {
                    let place = reason.2.unwrap_or(application.span);
                    fail(place, format!("`{name}` cannot be done"), reason.1)
                })?;
                let id = step.steps.last().map_or(0, |s| s.id);
                derivation = step;
                let product = derivation.design.parts.keys().find(|p| step_of(**p) == id);
                locals.push(Value::Reference(Reference::Step(id)));
                let made = product.map_or(Reference::Step(id), |p| Reference::Part(*p));
                locals.push(Value::Reference(made));
            }
            ExampleClause::Refuse { application, by } => {
                let outcome = apply(rules, &derivation, application, &locals).map_err(no_value)?;
                let Err((blocked, reason, _)) = outcome else {
                    let message = format!("`{}` should be refused", application.rule);
                    return Err(fail(application.span, message, "but it can be done".into()));
                };
                let stopped = blocked.map_or(String::new(), |b| b.text(rules));
                if let Some(by) = by.as_ref().filter(|by| **by != stopped) {
                    let message = format!("`{}` should be refused by `{by}`", application.rule);
                    return Err(fail(application.span, message, format!("but {reason}")));
                }
            }
        }
    }
    Ok(derivation)
}

/// Why an expectation does not hold: what stands on its two sides, if that is what it compares.
fn falsehood(condition: &Expr, scope: &DesignScope<'_>, locals: &[Value]) -> String {
    let ExprKind::Binary(a, operator, b) = &condition.kind else { return "false here".to_owned() };
    let side = |e: &Expr| match evaluate(e, scope, &mut locals.to_vec()) {
        Ok(Value::Number(x)) => e.ty.dimension().map(|d| units::shown(x, d)),
        _ => None,
    };
    match (side(a), side(b)) {
        (Some(a), Some(b)) => format!("false here: {a} {} {b}", operator.symbol()),
        _ => "false here".to_owned(),
    }
}

/// The outcome of a rule that is applied with chosen values: the reason as a table has it and in
/// words, and which value is to blame if one is.
type Outcome = Result<Derivation, (Option<Blocked>, String, Option<Span>)>;

fn apply(
    rules: &RuleSet,
    derivation: &Derivation,
    application: &Application,
    names: &[Value],
) -> Result<Outcome, EvalError> {
    let Some(rule) = rules.rules.iter().find(|r| r.name == application.rule) else {
        return Ok(Err((None, "there is no such rule".to_owned(), None)));
    };
    let locals = match values(rules, derivation, rule, application, names)? {
        Ok(locals) => locals,
        Err((reason, place)) => return Ok(Err((Some(Blocked::NoMatch), reason, place))),
    };
    Ok(match derivation.apply(rules, rule, &locals)? {
        Ok(next) => Ok(next),
        Err(blocked) => {
            let reason = blocked.sentence(rules);
            Err((Some(blocked), reason, None))
        }
    })
}

/// Why values do not fit a rule, and which of them is to blame if one is.
type Unfit = (String, Option<Span>);

/// The values of all locals of a rule, if the rule could have drawn them.
fn values(
    rules: &RuleSet,
    derivation: &Derivation,
    rule: &Rule,
    application: &Application,
    names: &[Value],
) -> Result<Result<Vec<Value>, Unfit>, EvalError> {
    let scope = DesignScope::new(rules, derivation);
    let matched: usize = rule.matches.iter().map(grammar_lang::ir::Match::slots).sum();
    let mut locals: Vec<Value> = Vec::new();
    for (slot, given) in application.values.iter().enumerate() {
        let called = rule.locals.get(slot).map_or("", String::as_str);
        let choice = slot.checked_sub(matched).and_then(|i| rule.choices.get(i));
        let value = match (given, choice) {
            // What is not there (any more) is a reason like any other.
            (Some(given), _) => match evaluate(given, &scope, &mut names.to_vec()) {
                Ok(value) => value,
                Err(error) => {
                    let reason = format!("`{called}` has no value: {}", error.reason);
                    return Ok(Err((reason, Some(given.span))));
                }
            },
            (None, Some(choice)) => {
                let only = domain_of(evaluate(&choice.domain, &scope, &mut locals.clone())?).item(0);
                only.unwrap_or(Value::Bool(false))
            }
            (None, None) => return Ok(Err((format!("`{called}` has no value"), None))),
        };
        if let Some(choice) = choice.filter(|c| c.spread != Spread::Fixed) {
            let domain = domain_of(evaluate(&choice.domain, &scope, &mut locals.clone())?);
            if !domain.holds(&value) {
                let reason = format!("`{called}` cannot be chosen like this: outside its domain");
                let dimension = match &choice.domain.ty {
                    Ty::Domain(item) | Ty::List(item) => item.dimension(),
                    _ => None,
                };
                let reason = match (&*domain, dimension) {
                    (Domain::Range { low, high, .. }, Some(d)) => {
                        format!("{reason} {} .. {}", units::shown(*low, d), units::shown(*high, d))
                    }
                    _ => reason,
                };
                return Ok(Err((reason, given.as_ref().map(|g| g.span))));
            }
        }
        locals.push(value);
        if slot + 1 == matched && !derivation.matches(rules, rule)?.contains(&locals) {
            return Ok(Err(("the rule does not match there".to_owned(), None)));
        }
    }
    if matched == 0 && derivation.matches(rules, rule)?.is_empty() {
        return Ok(Err(("a guard of the rule forbids it".to_owned(), None)));
    }
    for guard in rule.guards.iter().filter(|g| g.needs > matched) {
        if evaluate(&guard.condition, &scope, &mut locals.clone())? != Value::Bool(true) {
            return Ok(Err(("a guard of the rule forbids it".to_owned(), None)));
        }
    }
    Ok(Ok(locals))
}
