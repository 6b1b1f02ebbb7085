//! Settings of a search that take away what they are for.

use crate::bounds::{Interval, Truth};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{
    BodyLoop, BodyMethod, Expr, ExprKind, Function, Population, Schedule, SearchMethod, SearchWord, Word,
    without_spans,
};
use crate::source::Span;
use crate::units::Dimension;

use super::known::Known;

/// Above this temperature any loss is accepted: no objective has values so large.
const HOT: f64 = 1e6;

/// No robot that crawls for a minute loses so much from one gait to the next, m.
const FAR: f64 = 5.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let search = &known.ruleset.search;
    let numbers = |expr: &Expr| known.reasoning(&[]).numbers(expr);
    if let Some(selection) = search.selection() {
        let (size, drawn) = (numbers(&selection.size), numbers(&selection.tournament));
        if drawn.low > size.high {
            findings.push(told(
                selection.tournament.span,
                "this tournament draws more designs than the search keeps",
                &format!("it keeps at most {}", size.high),
                "write a smaller number, such as 4: designs other than the best then have a chance, too",
            ));
        }
    }
    if let Some(BodyLoop { schedule, method }) = &search.bodies {
        let moves = numbers(&schedule.iterations).high * numbers(&schedule.moves).high;
        let iterations = numbers(&schedule.iterations).high;
        if moves > 1.0 && iterations <= 1.0 {
            findings.push(told(
                schedule.iterations.span,
                "this search stops after its first iteration",
                &format!("after {moves} moves"),
                "a search needs many iterations: write `iterations = 100`",
            ));
        }
        if moves <= 1.0 {
            findings.push(told(
                schedule.iterations.span,
                "this search tries only one body besides the first",
                "one iteration of one move",
                "a search tries hundreds of bodies: write `iterations = 100`, `moves = 3`",
            ));
        }
        if let BodyMethod::Population(Population { restart: Some(restart), .. }) = method
            && known.reasoning(&[]).truth(restart) == Truth::Always
        {
            findings.push(told(
                restart.span,
                "the population begins anew after each iteration",
                "this always holds",
                "let it depend on what was gained: `iteration >= 40 and gain(40) < 5 % * max(abs(best), 1)`",
            ));
        }
        if let BodyMethod::Archive(archive) = method {
            let fixed = archive.descriptors.values().find(|kind| numbers(&kind.value).single().is_some());
            let axes: Vec<&Expr> = archive.descriptors.values().map(|kind| &kind.value).collect();
            let is_repeated = |(place, value): &(usize, &&Expr)| {
                axes.iter().take(*place).any(|other| without_spans(other).ok() == without_spans(value).ok())
            };
            let repeated = axes.iter().enumerate().find(is_repeated);
            findings.extend(repeated.map(|(_, value)| {
                told(
                    value.span,
                    "two axes of the archive are the same",
                    "the same value as of another descriptor",
                    "describe something else here, such as `count(actuator)`",
                )
            }));
            findings.extend(fixed.map(|kind| {
                told(
                    kind.value.span,
                    "every design belongs to the same kind",
                    "always the same value",
                    "describe what differs from design to design, such as `count(part)`",
                )
            }));
        }
    }
    for (schedule, method) in search.loops() {
        findings.extend(looks_back_too_far(known, schedule));
        findings.extend(never_stops(known, schedule));
        if let SearchMethod::Annealing(annealing) = method {
            findings.extend(heats(known, schedule, &annealing.temperature));
            let hottest = at_iteration(known, &annealing.temperature, 0.0).high;
            let lost =
                of_lengths(known).map(|scale| hottest * scale).filter(|lost| lost.is_finite() && *lost > FAR);
            if let Some(lost) = lost {
                findings.push(told(
                    annealing.temperature.span,
                    "at this temperature every loss is accepted",
                    &format!("losses of up to about {lost:.0} m"),
                    "the temperature is in the unit of the objective: write `in cm` there, or a lower temperature here",
                ));
            } else if numbers(&annealing.temperature).low > HOT {
                findings.push(told(
                    annealing.temperature.span,
                    "at this temperature every loss is accepted",
                    "the temperature is on the scale of the objective",
                    "with an objective `in cm`, a temperature of 9 accepts losses of about 9 cm",
                ));
            }
        }
    }
}

/// The numbers that an expression may have after so many iterations.
fn at_iteration(known: &Known<'_>, expr: &Expr, iteration: f64) -> Interval {
    let word = Word::Search(SearchWord::Iteration);
    let facts = known.facts.clone().with(word, Interval::point(iteration));
    crate::bounds::Reasoning::new(&facts, Vec::new()).numbers(expr)
}

/// In how many metres the value is told, if it is a length.
fn of_lengths(known: &Known<'_>) -> Option<f64> {
    let objective = known.ruleset.objectives().next()?;
    let ExprKind::Convert(inner, factor) = &objective.value.kind else { return None };
    (inner.ty.dimension() == Some(Dimension::LENGTH)).then_some(*factor)
}

/// A condition to stop that no iteration of the loop fulfils. A plain `false` is meant.
fn never_stops(known: &Known<'_>, schedule: &Schedule) -> Option<Diagnostic> {
    let iterations = known.numbers(&schedule.iterations).high;
    let within = Interval::new(0.0, iterations);
    let counted = [SearchWord::Iteration, SearchWord::Idle, SearchWord::Stagnant];
    let facts =
        counted.into_iter().fold(known.facts.clone(), |facts, word| facts.with(Word::Search(word), within));
    let mut reasoning = crate::bounds::Reasoning::new(&facts, Vec::new());
    let stop = &schedule.stop;
    (!matches!(stop.kind, ExprKind::Bool(_)) && reasoning.truth(stop) == Truth::Never).then(|| {
        told(
            stop.span,
            "this search never stops early",
            &format!("never holds within {iterations} iterations"),
            "write a number below `iterations`, or `stop = false` to make all of them",
        )
    })
}

/// `gain(n)` of more iterations than there are.
fn looks_back_too_far(known: &Known<'_>, schedule: &Schedule) -> Option<Diagnostic> {
    let iterations = known.numbers(&schedule.iterations);
    let mut found = None;
    schedule.stop.any(&mut |e| {
        if let ExprKind::Call(Function::Gain, arguments) = &e.kind
            && let [back] = arguments.as_slice()
            && known.numbers(back).low > iterations.high
        {
            found = Some(e.span);
        }
        found.is_some()
    });
    found.map(|span| {
        told(
            span,
            "this looks back over more iterations than the search makes",
            &format!("there are {}", iterations.high),
            "write a smaller number, such as `gain(20)`, to ask what the last iterations gained",
        )
    })
}

/// A temperature that is higher at the end than at the beginning.
fn heats(known: &Known<'_>, schedule: &Schedule, temperature: &Expr) -> Option<Diagnostic> {
    let last = known.numbers(&schedule.iterations).single()? - 1.0;
    let (first, last) =
        (at_iteration(known, temperature, 0.0), at_iteration(known, temperature, last.max(0.0)));
    (last.low > first.high).then(|| {
        told(
            temperature.span,
            "the temperature is higher at the end than at the beginning",
            "in annealing, the temperature should fall",
            "let it fall with `iteration`, as in `9 / (1 + iteration / 10)`",
        )
    })
}

fn told(place: Span, message: &str, label: &str, help: &str) -> Diagnostic {
    Diagnostic::new(Code::POINTLESS, place, message).label(label).help(help)
}
