//! Examples: derivations that a grammar writes down by hand.

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::{Domain, EvalError, Reference, UNKNOWN_HERE, Value, evaluate};
use grammar_lang::ir::{
    Application, Effect, Example, ExampleClause, Expr, ExprKind, Operator, Rule, RuleSet, Spread, Ty,
};
use grammar_lang::source::{FileId, Span};
use grammar_lang::units;

use super::choosing::domain_of;
use super::{Blocked, Derivation, DesignScope};
use crate::design::{PartId, step_of};

/// What names no step.
const NO_STEP: u64 = u64::MAX;

/// A warning for each example that fails, of those that a text declares itself.
#[must_use]
pub fn failing_examples(rules: &RuleSet, own: FileId) -> Vec<Diagnostic> {
    let own = rules.examples.iter().filter(|(_, example)| example.span.file == own);
    own.filter_map(|(name, example)| run_example(rules, name, example).err())
        .map(|failure| {
            let reason = failure.labels.first().map_or_else(String::new, |label| label.text.clone());
            Diagnostic::new(Code::FAILING_EXAMPLE, failure.span(), failure.message)
                .label(reason)
                .help("`sgc test` derives examples: mend this line, or what the rule does")
        })
        .collect()
}

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
            "what this reads is not in the design (any more)".to_owned()
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
                        let (place, why) = falsehood(condition, &scope, &locals);
                        return Err(fail(place, "an expectation does not hold".into(), why));
                    }
                }
            }
            ExampleClause::Step { name, application, products } => {
                let step =
                    apply(rules, &derivation, application, &locals).map_err(|undone| match undone {
                        Undone::NoValue(error) => no_value(error),
                        Undone::Refused(Refused { reason, place, .. }) => {
                            let place = place.unwrap_or(application.span);
                            fail(place, format!("the step `{name}` cannot be applied"), reason)
                        }
                    })?;
                let (step, made) = step;
                // One that takes steps back is no step itself.
                let is_new = |id: &u64| derivation.steps.iter().all(|before| before.id != *id);
                let step_id = step.steps.last().map(|s| s.id).filter(is_new).unwrap_or(NO_STEP);
                derivation = step;
                let product = derivation.design.parts.keys().find(|p| step_of(**p) == step_id);
                locals.push(Value::Reference(Reference::Step(step_id)));
                let first = product.map_or(Reference::Step(step_id), |p| Reference::Part(*p));
                locals.push(Value::Reference(first));
                let effects = rules.rule(&application.rule).map_or(&[][..], |rule| &rule.effects);
                for makers in products {
                    let own = made.iter().filter(|(by, _)| makers.contains(by));
                    let mut own = own.map(|(_, part)| Value::Reference(Reference::Part(*part)));
                    locals.push(if makers.iter().any(|maker| Effect::is_repeated(effects, *maker)) {
                        Value::List(own.collect())
                    } else {
                        own.next().unwrap_or(Value::Reference(Reference::Step(step_id)))
                    });
                }
            }
            ExampleClause::Refuse { application, by } => {
                let Refused { blocked, reason, .. } = match apply(rules, &derivation, application, &locals) {
                    Err(Undone::Refused(refused)) => refused,
                    Err(Undone::NoValue(error)) => return Err(no_value(error)),
                    Ok((done, _)) => {
                        let message = format!("`{}` should be refused", application.rule);
                        let reason = holds(rules, &done, by.as_deref());
                        return Err(fail(application.span, message, reason));
                    }
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

/// That a step can be done which should have been refused, with the two sides of what should have refused it.
fn holds(rules: &RuleSet, done: &Derivation, by: Option<&str>) -> String {
    let requirement = by.and_then(|by| rules.requirements.iter().find(|one| one.name == by));
    let sides = requirement.and_then(|one| sides(&one.condition, &DesignScope::new(rules, done), &[]));
    match (requirement, sides) {
        (Some(one), Some(sides)) => {
            format!("but it can be applied: `{}` then holds, because {sides}", one.name)
        }
        _ => "but it can be applied".to_owned(),
    }
}

/// What stands on the two sides of a comparison, if it is one of numbers or vectors.
fn sides(condition: &Expr, scope: &DesignScope<'_>, locals: &[Value]) -> Option<String> {
    let ExprKind::Binary(a, operator, b) = &condition.kind else { return None };
    let side = |e: &Expr| match evaluate(e, scope, &mut locals.to_vec()) {
        Ok(Value::Number(x)) => e.ty.dimension().map(|d| units::shown(x, d)),
        Ok(Value::Vector(all)) => match e.ty {
            Ty::Vector(d) => Some(format!("vector({})", all.map(|x| units::shown(x, d)).join(", "))),
            _ => None,
        },
        _ => None,
    };
    Some(format!("{} {} {}", side(a)?, operator.symbol(), side(b)?))
}

/// Which part of an expectation does not hold, and why: what stands on its two sides, if that is what it compares.
fn falsehood(condition: &Expr, scope: &DesignScope<'_>, locals: &[Value]) -> (Span, String) {
    if let ExprKind::Binary(a, Operator::And, b) = &condition.kind {
        let holds = |e: &Expr| matches!(evaluate(e, scope, &mut locals.to_vec()), Ok(Value::Bool(true)));
        return falsehood(if holds(a) { b } else { a }, scope, locals);
    }
    let sides = sides(condition, scope, locals).map_or(String::new(), |sides| format!(": {sides}"));
    (condition.span, format!("false here{sides}"))
}

/// Why a rule cannot be applied with chosen values.
enum Undone {
    /// What the grammar writes has no value: a mistake in it.
    NoValue(EvalError),
    /// The rule does not do this.
    Refused(Refused),
}

struct Refused {
    /// As a table has it, if the rule was refused.
    blocked: Option<Blocked>,
    /// A sentence.
    reason: String,
    /// The value that is to blame, if one is.
    place: Option<Span>,
}

impl Undone {
    fn refused(blocked: Option<Blocked>, reason: impl Into<String>, place: Option<Span>) -> Self {
        Self::Refused(Refused { blocked, reason: reason.into(), place })
    }

    /// The values are none that the rule could have drawn.
    fn unfit(reason: impl Into<String>, place: Option<Span>) -> Self {
        Self::refused(Some(Blocked::NoMatch), reason, place)
    }
}

impl From<EvalError> for Undone {
    fn from(error: EvalError) -> Self {
        Self::NoValue(error)
    }
}

fn apply(
    rules: &RuleSet,
    derivation: &Derivation,
    application: &Application,
    names: &[Value],
) -> Result<(Derivation, Vec<(usize, PartId)>), Undone> {
    let rule = rules.rule(&application.rule);
    let rule = rule.ok_or_else(|| Undone::refused(None, "there is no such rule", None))?;
    let locals = values(rules, derivation, rule, application, names)?;
    derivation.apply_and_tell(rules, rule, &locals).map_err(|blocked| match blocked {
        Blocked::NoValue(error) => Undone::NoValue(error),
        blocked => {
            let mut reason = blocked.sentence(rules);
            if let Blocked::Requirement(broken) = blocked
                && let Some(which) = derivation
                    .would_overlap(rules, rule, &locals, broken)
                    .or_else(|| derivation.would_be(rules, rule, &locals, broken))
            {
                reason += &format!(" ({which})");
            }
            Undone::refused(Some(blocked), reason, None)
        }
    })
}

/// Says of which name of a rule no match is left, with the names before it as they are given.
fn unmatched(all: &[Vec<Value>], locals: &[Value], rule: &Rule, application: &Application) -> Undone {
    let fits = |known: usize| all.iter().any(|one| one.get(..known) == locals.get(..known));
    let first = (1..=locals.len()).find(|known| !fits(*known)).unwrap_or(locals.len()) - 1;
    let place = application.values.get(first).and_then(|given| given.as_ref()).map(|given| given.span);
    match rule.locals.get(first).filter(|name| !all.is_empty() && locals.len() > 1 && !name.is_empty()) {
        Some(name) => {
            let reason = format!(
                "the rule does not match there: no match has this `{name}` with what is given before it"
            );
            Undone::unfit(reason, place)
        }
        None => Undone::unfit("the rule does not match there", None),
    }
}

/// The values of all locals of a rule, if the rule could have drawn them.
fn values(
    rules: &RuleSet,
    derivation: &Derivation,
    rule: &Rule,
    application: &Application,
    names: &[Value],
) -> Result<Vec<Value>, Undone> {
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
                    return Err(Undone::unfit(reason, Some(given.span)));
                }
            },
            (None, Some(choice)) => {
                let only = domain_of(evaluate(&choice.domain, &scope, &mut locals.clone())?).item(0);
                only.unwrap_or(Value::Bool(false))
            }
            (None, None) => return Err(Undone::unfit(format!("`{called}` has no value"), None)),
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
                return Err(Undone::unfit(reason, given.as_ref().map(|g| g.span)));
            }
        }
        locals.push(value);
        if slot + 1 == matched {
            let all = derivation.matches(rules, rule)?;
            if !all.contains(&locals) {
                return Err(unmatched(&all, &locals, rule, application));
            }
        }
    }
    if matched == 0 && derivation.matches(rules, rule)?.is_empty() {
        return Err(Undone::unfit("a guard of the rule forbids it", None));
    }
    for guard in rule.guards.iter().filter(|g| g.needs > matched) {
        if evaluate(&guard.condition, &scope, &mut locals.clone())? != Value::Bool(true) {
            return Err(Undone::unfit("a guard of the rule forbids it", None));
        }
    }
    Ok(locals)
}
