//! Where expressions stand in a rule set, with what is known of their locals.

use crate::bounds::{Abstract, Facts, actuation_locals, narrowed_locals_of};
use crate::ir::{Effect, Expr, Kernel, Rule, RuleSet, Schedule, Spread};

/// An expression with what is known of the locals that it may read.
pub(super) struct Place<'r> {
    pub(super) expr: &'r Expr,
    pub(super) locals: Vec<Abstract>,
}

/// The conditions of a rule: those of its matches, then its guards.
pub(super) fn conditions(rule: &Rule) -> impl Iterator<Item = &Expr> {
    let matched = rule.matches.iter().filter_map(|m| m.condition.as_ref());
    matched.chain(rule.guards.iter().map(|g| &g.condition))
}

/// The schedules of the search.
pub(super) fn schedules(ruleset: &RuleSet) -> impl Iterator<Item = &Schedule> {
    [Some(&ruleset.search.outer), ruleset.search.inner.as_ref()].into_iter().flatten()
}

/// Every expression that is evaluated while designs are made, driven, scored and searched.
pub(super) fn places<'r>(facts: &Facts<'r>) -> Vec<Place<'r>> {
    let ruleset = facts.rules;
    let mut all = Vec::new();
    let mut add = |expr: &'r Expr, locals: &[Abstract]| all.push(Place { expr, locals: locals.to_vec() });
    for rule in &ruleset.rules {
        let locals = narrowed_locals_of(facts, rule);
        in_rule(rule).into_iter().for_each(|expr| add(expr, &locals));
        add(&rule.weight, &[]);
    }
    for requirement in &ruleset.requirements {
        add(&requirement.condition, &[]);
    }
    for preference in &ruleset.preferences {
        add(&preference.condition, &[]);
        add(&preference.weight, &[]);
    }
    for actuation in ruleset.actuations.values() {
        let locals = actuation_locals(facts, actuation);
        let values = actuation.lets.iter().chain(&actuation.moving).map(|(_, e)| e);
        values.chain([&actuation.drive]).for_each(|expr| add(expr, &locals));
        for variable in &actuation.variables {
            add(&variable.mutation.probability, &[]);
            if let Kernel::Normal(a, b) | Kernel::Uniform(a, b) = &variable.mutation.kernel {
                add(a, &[]);
                add(b, &[]);
            }
        }
    }
    ruleset.terms.values().for_each(|term| add(&term.value, &[]));
    ruleset.tasks.values().for_each(|task| add(&task.objective.value, &[]));
    add(&ruleset.objective.value, &[]);
    for schedule in schedules(ruleset) {
        let parts = [&schedule.iterations, &schedule.moves, &schedule.temperature, &schedule.stop];
        parts.into_iter().for_each(|expr| add(expr, &[]));
    }
    all
}

/// What a rule asks, chooses from and does.
fn in_rule(rule: &Rule) -> Vec<&Expr> {
    let mut exprs: Vec<&Expr> = conditions(rule).collect();
    for choice in &rule.choices {
        exprs.push(&choice.domain);
        match &choice.spread {
            Spread::Normal(a, b) | Spread::Uniform(a, b) => exprs.extend([a, b]),
            Spread::Weights(weights) => exprs.push(weights),
            Spread::Even | Spread::Fixed => {}
        }
    }
    for effect in &rule.effects {
        match effect {
            Effect::Attach { what, on } => exprs.extend([what, &on.port].into_iter().chain(&on.turned)),
            Effect::Replace { part, with, .. } => exprs.extend([part, with]),
            Effect::Set { part, value, .. } => exprs.extend([part, value]),
            Effect::Revert(e) | Effect::Remove(e) => exprs.push(e),
        }
    }
    exprs
}
