//! What many checks need to know of a rule set, worked out once.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use crate::bounds::{Abstract, Begun, Facts, Interval, Reasoning, locals_of, narrowed_locals_of};
use crate::eval::{Allowance, Budget, EvalError, Scope, Value};
use crate::ir::{Actuation, Actuator, Cells, Effect, Expr, ExprKind, Group, Rule, RuleSet, Task};

/// A rule set, and what holds of it whatever the design.
pub(super) struct Known<'r> {
    pub(super) ruleset: &'r RuleSet,
    pub(super) facts: Facts<'r>,
    /// The groups that a part of a design can ever be of.
    pub(super) possible: BTreeSet<Group>,
    /// Those of parts that rules make.
    pub(super) made: BTreeSet<Group>,
    /// What is known of the locals of each rule.
    locals: Vec<Locals>,
    allowance: Allowance,
    /// How many operations parts may still take that are tried with other parameters.
    pub(super) tried: Arc<AtomicU64>,
}

/// A kind of actuator that a task drives, and the actuation that drives it.
pub(super) struct Actuated<'r> {
    pub(super) task: &'r Task,
    pub(super) kind: &'r str,
    pub(super) actuator: &'r Actuator,
    pub(super) actuation: &'r Actuation,
}

/// How many operations all parts may take together that are tried with other parameters.
const TRIED: u64 = 200_000_000;

/// What is known of the locals of a rule.
pub(super) struct Locals {
    /// Whatever its conditions say.
    pub(super) all: Vec<Abstract>,
    /// Where its conditions hold.
    pub(super) narrowed: Vec<Abstract>,
}

impl<'r> Known<'r> {
    pub(super) fn new(ruleset: &'r RuleSet, begun: Option<&Begun>, budget: &Budget) -> Self {
        let facts = Facts::from(ruleset, begun);
        let locals =
            |rule| Locals { all: locals_of(&facts, rule), narrowed: narrowed_locals_of(&facts, rule) };
        let locals = ruleset.rules.iter().map(locals).collect();
        let made = made(&facts);
        let possible = placed(&facts).union(&made).cloned().collect();
        let (allowance, tried) = (Allowance::of_check(budget), Arc::new(AtomicU64::new(TRIED)));
        Self { ruleset, possible, made, locals, facts, allowance, tried }
    }

    /// The rules, with what is known of their locals.
    pub(super) fn rules(&self) -> impl Iterator<Item = (&'r Rule, &Locals)> {
        self.ruleset.rules.iter().zip(&self.locals)
    }

    /// The same, and those that are carried out always, which match and choose nothing.
    pub(super) fn all_rules(&self) -> impl Iterator<Item = (&'r Rule, &[Abstract])> {
        let drawn = self.rules().map(|(rule, locals)| (rule, locals.narrowed.as_slice()));
        drawn.chain(self.ruleset.always.iter().map(|rule| (rule, &[][..])))
    }

    /// The kinds of actuators that tasks drive.
    pub(super) fn actuated(&self) -> impl Iterator<Item = Actuated<'r>> {
        let ruleset = self.ruleset;
        let pairs =
            ruleset.tasks.values().flat_map(|task| task.actuated.iter().map(move |pair| (task, pair)));
        pairs.filter_map(|(task, (kind, name))| {
            let (actuator, actuation) = (ruleset.actuators.get(kind)?, ruleset.actuations.get(name)?);
            Some(Actuated { task, kind, actuator, actuation })
        })
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

    /// What an expression is, whatever the parameters are set to; none if it reads one.
    pub(super) fn fixed(&self, expr: &Expr) -> Option<Value> {
        let reads = expr.any(&mut |e| matches!(e.kind, ExprKind::Param(_)));
        if reads { None } else { self.value(expr).ok() }
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

/// The groups of all kinds that an expression names.
fn gather(facts: &Facts<'_>, expr: &Expr, groups: &mut BTreeSet<Group>) {
    expr.any(&mut |e| {
        if let ExprKind::Kind(name, _) = &e.kind {
            groups.extend(groups_of(facts, name));
        }
        false
    });
}

fn cells_of(effect: &Effect) -> Option<&Cells> {
    if let Effect::Cells(cells) = effect { Some(cells) } else { None }
}

/// The groups of parts that the initial design has.
fn placed(facts: &Facts<'_>) -> BTreeSet<Group> {
    let mut placed = BTreeSet::new();
    facts.rules.begin.iter().for_each(|p| gather(facts, &p.what, &mut placed));
    let begun = facts.rules.lattice.iter().flat_map(|lattice| Effect::single(&lattice.begin));
    for cells in begun.filter_map(cells_of) {
        cells.with.iter().for_each(|with| gather(facts, with, &mut placed));
    }
    placed
}

/// The groups of parts that rules make.
fn made(facts: &Facts<'_>) -> BTreeSet<Group> {
    let mut made = BTreeSet::new();
    for rule in &facts.rules.rules {
        for cells in Effect::single(&rule.effects).filter_map(cells_of) {
            cells.with.iter().for_each(|with| gather(facts, with, &mut made));
        }
        let mut makes = false;
        for effect in Effect::single(&rule.effects) {
            if let Effect::Attach { what, .. } | Effect::Replace { with: what, .. } = effect {
                makes = true;
                gather(facts, what, &mut made);
            }
        }
        if makes {
            rule.choices.iter().for_each(|c| gather(facts, &c.domain, &mut made));
        }
    }
    made
}

/// The groups that parts of a kind are of.
pub(super) fn groups_of(facts: &Facts<'_>, kind: &str) -> impl Iterator<Item = Group> {
    let all = [Group::Part, Group::Block, Group::Actuator, Group::Cell, Group::Kind(kind.to_owned())];
    all.into_iter().filter(|group| facts.belongs(kind, group))
}
