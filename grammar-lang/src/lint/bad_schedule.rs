//! A schedule that does nothing: no iteration, no move, or a negative temperature.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, SearchMethod, Selection};

use super::known::Known;
use crate::types::USUAL;
use crate::units::{Dimension, shown};

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (schedule, method) in known.ruleset.search.loops() {
        let most = |expr| known.numbers(expr).high;
        let mut report = |span, message: &str, label: &str, help: &str| {
            findings.push(Diagnostic::new(Code::BAD_SCHEDULE, span, message).label(label).help(help));
        };
        for (expr, what) in [(&schedule.iterations, "iteration"), (&schedule.moves, "move")] {
            // A plain zero leaves the loop out on purpose; a learner learns nothing then.
            let learns = matches!(method, SearchMethod::ActorCritic(_) | SearchMethod::QLearning(_));
            if most(expr) < 1.0 && (learns || !matches!(expr.kind, ExprKind::Number(0.0))) {
                let message = format!("this search never makes a single {what}");
                report(expr.span, &message, "always below 1", "write a number above zero");
            }
        }
        if let SearchMethod::QLearning(own) = method {
            let share = known.numbers(&own.exploration);
            if share.low > 1.0 || share.high < 0.0 {
                findings.push(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        own.exploration.span,
                        "`exploration` is a share: it must lie within 0 % .. 100 %",
                    )
                    .label("always outside this range")
                    .help("write for example `exploration = max(5 %, 90 % - iteration * 1 %)`"),
                );
            }
        }
        let selection = match method {
            SearchMethod::Population(population) => Some((&population.selection, false)),
            SearchMethod::Front(front) => Some((&front.selection, true)),
            SearchMethod::Annealing(_)
            | SearchMethod::Archive(_)
            | SearchMethod::CmaEs(_)
            | SearchMethod::ActorCritic(_)
            | SearchMethod::QLearning(_) => None,
        };
        if let Some((selection, is_front)) = selection {
            for (expr, limit) in selection.exprs().into_iter().zip(Selection::limits(is_front)) {
                let range = known.numbers(expr);
                findings.extend(limit.excludes(range.low, range.high).map(|why| {
                    Diagnostic::new(Code::OUT_OF_DOMAIN, expr.span, why)
                        .label("always outside this range")
                        .help(format!("write for example `{} = {}`", limit.name, limit.example))
                }));
            }
        }
        let mut report = |span, message: &str, label: &str, help: &str| {
            findings.push(Diagnostic::new(Code::BAD_SCHEDULE, span, message).label(label).help(help));
        };
        if let Some(temperature) = method.temperature()
            && most(temperature) < 0.0
        {
            let span = temperature.span;
            report(span, "a temperature cannot be negative", "always below zero", "let it fall towards 0");
        }
        findings.extend(method.temperature().and_then(|temperature| unusual(known, temperature)));
    }
}

/// A temperature that even at its highest is so low that nothing worse is ever accepted, or so high that everything is.
fn unusual(known: &Known<'_>, temperature: &Expr) -> Option<Diagnostic> {
    let usual = USUAL.iter().find(|usual| (usual.of, usual.field) == ("a search", "temperature"))?;
    let highest = known.numbers(temperature).high;
    let told = |x: f64| shown(x, Dimension::NUMBER);
    let accepts = match highest {
        // A plain zero accepts nothing worse on purpose.
        highest if highest <= 0.0 || !highest.is_finite() => return None,
        highest if highest < usual.least => "no worse design is ever accepted",
        highest if highest > usual.most => "at the beginning every worse design is accepted",
        _ => return None,
    };
    let message = format!("this temperature reaches {}: {accepts}", told(highest));
    Some(
        Diagnostic::new(Code::UNUSUAL, temperature.span, message)
            .label(format!("usual: {} .. {} in the unit of the objective", told(usual.least), told(usual.most)))
            .help("a temperature is a loss that is often accepted: begin with a tenth of a good value, and let it fall"),
    )
}
