//! Expressions that have no value whatever the design: `1 / 0`, an index beyond a list.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{EvalError, UNKNOWN_HERE, evaluate};
use crate::ir::{Effect, Expr};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut exprs: Vec<&Expr> = Vec::new();
    for rule in &ruleset.rules {
        exprs.push(&rule.weight);
        exprs.extend(rule.choices.iter().map(|c| &c.domain));
        exprs.extend(rule.guards.iter().map(|g| &g.condition));
        for effect in &rule.effects {
            match effect {
                Effect::Attach { what, on } => exprs.extend([what, &on.port].into_iter().chain(&on.turned)),
                Effect::Replace { with, .. } => exprs.push(with),
                Effect::Set { value, .. } => exprs.push(value),
                Effect::Revert(_) | Effect::Remove(_) => {}
            }
        }
    }
    exprs.extend(ruleset.requirements.iter().map(|r| &r.condition));
    exprs.extend(ruleset.preferences.iter().flat_map(|p| [&p.condition, &p.weight]));
    for actuation in ruleset.actuations.values() {
        exprs
            .extend(actuation.lets.iter().chain(&actuation.moving).map(|(_, e)| e).chain([&actuation.drive]));
        exprs.extend(actuation.variables.iter().map(|v| &v.mutation.probability));
    }
    for schedule in [Some(&ruleset.search.outer), ruleset.search.inner.as_ref()].into_iter().flatten() {
        exprs.extend([&schedule.iterations, &schedule.moves, &schedule.temperature, &schedule.stop]);
    }
    for expr in exprs {
        // What reads the design has no value here either, but for another reason.
        if let Err(EvalError { span, reason }) = evaluate(expr, ruleset, &mut Vec::new())
            && reason != UNKNOWN_HERE
        {
            findings.push(Diagnostic::new(Code::BAD_VALUE, span, "this never has a value").label(reason));
        }
    }
}
