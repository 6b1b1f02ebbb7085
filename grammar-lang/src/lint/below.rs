//! What falls below zero, or beyond its limits, in the course of the search. Only
//! what certainly happens is told: the schedule is followed step by step.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{EvalError, Scope, UNKNOWN_HERE, Value};
use crate::ir::{Expr, ExprKind, Kernel, Schedule, SearchMethod, SearchWord, Spread, Word};
use crate::units;

use super::known::Known;

/// How many iterations are followed.
const FOLLOWED: usize = 10_000;

/// A place of the search: the iteration and its temperature.
#[derive(Clone, Copy)]
struct Moment<'k> {
    known: &'k Known<'k>,
    iteration: f64,
    temperature: f64,
}

impl Scope for Moment<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.known.ruleset)
    }
    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Search(SearchWord::Iteration) => Some(Value::Number(self.iteration)),
            Word::Search(SearchWord::Temperature) => Some(Value::Number(self.temperature)),
            _ => None,
        }
    }
}

impl Moment<'_> {
    /// The value of an expression, if it has one that is a number.
    fn number(&self, expr: &Expr) -> Option<f64> {
        self.known.value_in(expr, self).ok()?.as_number()
    }

    /// Why an expression has no value, if that is so whatever the search finds.
    fn without_value(&self, expr: &Expr) -> Option<EvalError> {
        self.known.value_in(expr, self).err().filter(|error| error.reason != UNKNOWN_HERE)
    }
}

/// The moments that a search comes to: as far as it certainly goes.
fn course<'k>(known: &'k Known<'k>, schedule: &Schedule, method: SearchMethod<'_>) -> Vec<Moment<'k>> {
    let moment = |i: usize, temperature| Moment { known, iteration: i as f64, temperature };
    let most = moment(0, 0.0).number(&schedule.iterations).unwrap_or(0.0).clamp(0.0, FOLLOWED as f64);
    let mut all = Vec::new();
    for i in 0..most as usize {
        let before = all.last().map_or(0.0, |m: &Moment<'_>| m.temperature);
        let temperature = method.temperature().map_or(Some(0.0), |t| moment(i, before).number(t));
        let Some(temperature) = temperature else { break };
        // What cannot be known here may stop the search.
        let next = moment(i + 1, 0.0);
        all.push(moment(i, temperature));
        if known.value_in(&schedule.stop, &next) != Ok(Value::Bool(false)) {
            break;
        }
    }
    all
}

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let search = &ruleset.search;
    for (schedule, method) in search.loops() {
        missing(known, schedule, method, findings);
        cold(known, schedule, method, findings);
    }
    // Where no bodies are searched for, no rule is applied.
    let bodies = search.bodies.as_ref().map(|bodies| course(known, &bodies.schedule, bodies.method()));
    let bodies = bodies.unwrap_or_default();
    for rule in &ruleset.rules {
        if let Some((moment, x)) = first(&bodies, &rule.weight, |x| x < 0.0) {
            let message = format!("the weight of the rule `{}` falls below zero", rule.name);
            findings.push(told(Code::WEIGHT_BELOW, &rule.weight, message, moment, x));
        }
        for choice in &rule.choices {
            if let Spread::Normal(_, deviation) = &choice.spread {
                spread(&bodies, deviation, "a deviation falls below zero", |x| x < 0.0, findings);
            }
        }
    }
    // Curves are varied within their own loop, or else with the body.
    let curves = search.curves.as_ref().map(|curves| course(known, &curves.schedule, curves.method()));
    let course = curves.as_ref().unwrap_or(&bodies);
    for mutation in ruleset.actuations.values().flat_map(|a| &a.variables).map(|v| &v.mutation) {
        let beyond = |x: f64| !(0.0..=1.0).contains(&x);
        spread(course, &mutation.probability, "a probability goes outside 0 .. 1", beyond, findings);
        if let Kernel::Normal(_, deviation) = &mutation.kernel {
            spread(course, deviation, "a deviation falls below zero", |x| x < 0.0, findings);
        }
    }
}

/// What a schedule asks for and does not have at a moment that the search comes to.
fn missing(known: &Known<'_>, schedule: &Schedule, method: SearchMethod<'_>, findings: &mut Vec<Diagnostic>) {
    let exploration = match method {
        SearchMethod::QLearning(own) => Some(&own.exploration),
        _ => None,
    };
    let asked = || method.temperature().into_iter().chain([&schedule.moves]).chain(exploration);
    let all = course(known, schedule, method);
    let next = all.last().map_or(0.0, |moment| moment.iteration + 1.0);
    let last = Moment { known, iteration: next, temperature: all.last().map_or(0.0, |m| m.temperature) };
    // Beyond the last moment, what is not known may stop the search.
    let goes_on = all.last().is_none_or(|_| known.value_in(&schedule.stop, &last) == Ok(Value::Bool(false)));
    let within = last.number(&schedule.iterations).is_none_or(|most| next < most) && next < FOLLOWED as f64;
    let moments = all.iter().chain((goes_on && within).then_some(&last));
    let found = moments
        .flat_map(|m| asked().map(move |expr| (m, expr)))
        .find_map(|(m, expr)| Some((m, m.without_value(expr)?)));
    let Some((moment, error)) = found else { return };
    findings.push(
        Diagnostic::new(Code::NO_VALUE, error.span, "this has no value, and the run would end here")
            .label(format!("{}, in iteration {}", error.reason, moment.iteration))
            .help("`iteration` begins at 0: for example, divide by `iteration + 1`, or use `max`"),
    );
}

fn cold(known: &Known<'_>, schedule: &Schedule, method: SearchMethod<'_>, findings: &mut Vec<Diagnostic>) {
    let Some(temperature) = method.temperature() else { return };
    let all = course(known, schedule, method);
    if let Some(moment) = all.iter().find(|m| m.temperature < 0.0) {
        findings.push(
            Diagnostic::new(Code::COLD, temperature.span, "the temperature falls below zero")
                .label(format!(
                    "{} in iteration {}",
                    shown(temperature, moment.temperature),
                    moment.iteration
                ))
                .help("a temperature below zero counts as zero: write `max(..., 0)` if that is meant"),
        );
    }
}

fn spread(
    course: &[Moment<'_>],
    expr: &Expr,
    message: &str,
    wrong: impl Fn(f64) -> bool,
    findings: &mut Vec<Diagnostic>,
) {
    if let Some((moment, x)) = first(course, expr, wrong) {
        findings.push(told(Code::SPREAD_BEYOND, expr, message.to_owned(), moment, x));
    }
}

/// The first moment at which an expression is wrong, and its value then.
fn first<'m, 'r>(
    course: &'m [Moment<'r>],
    expr: &Expr,
    wrong: impl Fn(f64) -> bool,
) -> Option<(&'m Moment<'r>, f64)> {
    // Most expressions are the same at every moment.
    let moving = |e: &Expr| {
        matches!(e.kind, ExprKind::Word(Word::Search(SearchWord::Iteration | SearchWord::Temperature)))
    };
    let followed = if expr.any(&mut |e| moving(e)) { course.len() } else { 1 };
    let value = |moment: &Moment<'_>| moment.number(expr).filter(|x| wrong(*x));
    course.iter().take(followed).find_map(|moment| Some((moment, value(moment)?)))
}

fn shown(expr: &Expr, x: f64) -> String {
    units::shown(x, expr.ty.dimension().unwrap_or_default())
}

fn told(code: &'static Code, expr: &Expr, message: String, moment: &Moment<'_>, x: f64) -> Diagnostic {
    let temperature = units::shown(moment.temperature, units::Dimension::NUMBER);
    Diagnostic::new(code, expr.span, message)
        .label(format!("{} in iteration {}, at temperature {temperature}", shown(expr, x), moment.iteration))
        .help("keep it within its limits with `max`, `min` or `clamp`")
}
