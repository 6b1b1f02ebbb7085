//! Where expressions stand in a rule set, with what is known of their locals.

use std::collections::BTreeSet;

use crate::bounds::{Abstract, Reasoning, Repeated, actuation_locals, state_locals};
use crate::diagnostics::Diagnostic;
use crate::ir::{Effect, Expr, Kernel, Rule, SearchMethod, Spread};

use super::known::Known;

/// Expressions that stand together, with what is known of the locals that they may read.
pub(super) struct Scoped<'r> {
    pub(super) exprs: Vec<&'r Expr>,
    pub(super) locals: Vec<Abstract>,
}

/// The conditions of a rule: those of its matches, then its guards.
pub(super) fn conditions(rule: &Rule) -> impl Iterator<Item = &Expr> {
    let matched = rule.matches.iter().filter_map(|m| m.condition.as_ref());
    matched.chain(rule.guards.iter().map(|g| &g.condition))
}

/// What is found in all that is worked out, once at each place; `found` looks at what was met there.
pub(super) fn wherever(
    known: &Known<'_>,
    findings: &mut Vec<Diagnostic>,
    found: impl Fn(&Reasoning<'_>) -> Vec<Diagnostic>,
) {
    let place_of = |found: &Diagnostic| (found.span().file, found.span().start, found.span().end);
    let mut told: BTreeSet<_> = findings.iter().map(place_of).collect();
    for place in places(known) {
        let mut reasoning = known.reasoning(&place.locals);
        for expr in place.exprs {
            reasoning.value(expr);
        }
        findings.extend(found(&reasoning).into_iter().filter(|found| told.insert(place_of(found))));
    }
}

/// Every expression that is evaluated while designs are made, driven, scored and searched.
pub(super) fn places<'r>(known: &Known<'r>) -> Vec<Scoped<'r>> {
    let ruleset = known.ruleset;
    let mut all = Vec::new();
    let mut add = |exprs: Vec<&'r Expr>, locals: Vec<Abstract>| all.push(Scoped { exprs, locals });
    for (rule, locals) in known.all_rules() {
        add(before_effects(rule), locals.to_vec());
        known.reasoning(locals).through_effects(
            &rule.effects,
            Repeated::Together,
            &mut |reasoning, effect| {
                let exprs = match effect {
                    // What is repeated comes next, with what is known of it.
                    Effect::Repeat { over, .. } => over.iter().map(|binder| &binder.over).collect(),
                    one => one.exprs(),
                };
                add(exprs, reasoning.locals.clone());
            },
        );
        add(vec![&rule.weight], Vec::new());
    }
    add(ruleset.requirements.iter().map(|r| &r.condition).collect(), Vec::new());
    add(ruleset.preferences.iter().flat_map(|p| [&p.condition, &p.weight]).collect(), Vec::new());
    for actuation in ruleset.actuations.values() {
        add(actuation.values().collect(), actuation_locals(&known.facts, actuation));
        for mutation in actuation.variables.iter().map(|v| &v.mutation) {
            let kernel = match &mutation.kernel {
                Kernel::Normal(a, b) | Kernel::Uniform(a, b) => vec![a, b],
                Kernel::Flip => Vec::new(),
            };
            add([vec![&mutation.probability], kernel].concat(), Vec::new());
        }
    }
    for state in ruleset.states.values() {
        let values = state.values().chain([&state.state.from]).collect();
        add(values, state_locals(&known.facts, state));
    }
    add(ruleset.sensors.values().map(|sensor| &sensor.value).collect(), Vec::new());
    add(
        ruleset.policies.values().flat_map(|policy| policy.known().chain(&policy.reward)).collect(),
        Vec::new(),
    );
    add(ruleset.terms.values().map(|term| &term.value).collect(), Vec::new());
    let of_tasks = ruleset.tasks.values().flat_map(|task| task.objectives());
    add(of_tasks.chain(ruleset.objectives()).map(|objective| &objective.value).collect(), Vec::new());
    for (schedule, method) in ruleset.search.loops() {
        let mut exprs: Vec<&Expr> = schedule.exprs().into_iter().chain(method.scheduled()).collect();
        if let SearchMethod::Archive(archive) = method {
            exprs.extend(archive.descriptors.values().map(|kind| &kind.value));
        }
        add(exprs, Vec::new());
    }
    all
}

/// What a rule asks and chooses from.
fn before_effects(rule: &Rule) -> Vec<&Expr> {
    let mut exprs: Vec<&Expr> = conditions(rule).collect();
    for choice in &rule.choices {
        exprs.push(&choice.domain);
        match &choice.spread {
            Spread::Normal(a, b) | Spread::Uniform(a, b) => exprs.extend([a, b]),
            Spread::Weights(weights) => exprs.push(weights),
            Spread::Even | Spread::Fixed => {}
        }
    }
    exprs
}
