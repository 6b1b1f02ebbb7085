//! What many checks need to know of a rule set, worked out once.

use std::collections::BTreeSet;

use crate::bounds::{Abstract, Begun, Facts, Interval, Reasoning, locals_of, narrowed_locals_of};
use crate::eval::{Allowance, EvalError, Scope, Value};
use crate::ir::{Effect, Expr, ExprKind, Group, Rule, RuleSet};

/// A rule set, and what holds of it whatever the design.
pub(super) struct Known<'r> {
    pub(super) ruleset: &'r RuleSet,
    pub(super) facts: Facts<'r>,
    /// The groups that a part of a design can ever be of.
    pub(super) possible: BTreeSet<Group>,
    /// What is known of the locals of each rule.
    locals: Vec<Locals>,
    allowance: Allowance,
}

/// What is known of the locals of a rule.
pub(super) struct Locals {
    /// Whatever its conditions say.
    pub(super) all: Vec<Abstract>,
    /// Where its conditions hold.
    pub(super) narrowed: Vec<Abstract>,
}

impl<'r> Known<'r> {
    pub(super) fn new(ruleset: &'r RuleSet, begun: Option<&Begun>) -> Self {
        let facts = Facts::from(ruleset, begun);
        let locals =
            |rule| Locals { all: locals_of(&facts, rule), narrowed: narrowed_locals_of(&facts, rule) };
        let locals = ruleset.rules.iter().map(locals).collect();
        Self { ruleset, possible: possible(&facts), locals, facts, allowance: Allowance::of_check() }
    }

    /// The rules, with what is known of their locals.
    pub(super) fn rules(&self) -> impl Iterator<Item = (&'r Rule, &Locals)> {
        self.ruleset.rules.iter().zip(&self.locals)
    }

    /// Reasons about several expressions that read the same locals.
    pub(super) fn reasoning(&self, locals: &[Abstract]) -> Reasoning<'_> {
        Reasoning::new(&self.facts, locals.to_vec())
    }

    /// The value of an expression that needs no design.
    pub(super) fn value(&self, expr: &Expr) -> Result<Value, EvalError> {
        self.value_in(expr, self.ruleset)
    }

    /// The same where more is known.
    pub(super) fn value_in(&self, expr: &Expr, scope: &dyn Scope) -> Result<Value, EvalError> {
        self.allowance.evaluate(expr, scope, &mut Vec::new())
    }

    /// The error of the value that was too much, if one was.
    pub(super) fn spent(&self) -> Option<EvalError> {
        self.allowance.spent()
    }

    /// The numbers that an expression without locals may have.
    pub(super) fn numbers(&self, expr: &Expr) -> Interval {
        self.reasoning(&[]).numbers(expr)
    }
}

/// The groups that a part of a design can ever be of.
fn possible(facts: &Facts<'_>) -> BTreeSet<Group> {
    let mut possible = BTreeSet::new();
    let mut gather = |expr: &Expr| {
        expr.any(&mut |e| {
            if let ExprKind::Kind(name, _) = &e.kind {
                possible.extend(groups_of(facts, name));
            }
            false
        });
    };
    facts.rules.begin.iter().for_each(|p| gather(&p.what));
    let begun = facts.rules.lattice.iter().flat_map(|lattice| &lattice.begin);
    for effect in begun.chain(facts.rules.rules.iter().flat_map(|rule| &rule.effects)) {
        if let Effect::Cells(cells) = effect {
            cells.with.iter().for_each(&mut gather);
        }
    }
    for rule in &facts.rules.rules {
        let mut makes = false;
        for effect in &rule.effects {
            if let Effect::Attach { what, .. } | Effect::Replace { with: what, .. } = effect {
                makes = true;
                gather(what);
            }
        }
        if makes {
            rule.choices.iter().for_each(|c| gather(&c.domain));
        }
    }
    possible
}

/// The groups that parts of a kind are of.
pub(super) fn groups_of(facts: &Facts<'_>, kind: &str) -> impl Iterator<Item = Group> {
    let all = [Group::Part, Group::Block, Group::Actuator, Group::Cell, Group::Kind(kind.to_owned())];
    all.into_iter().filter(|group| facts.belongs(kind, group))
}
