//! What is known of the locals of a rule.

use super::{Abstract, Facts, Interval, Reasoning, Truth};
use crate::ir::{Actuation, Effect, Expr, ExprKind, Group, Matched, Operator, Rule, Ty};

/// What is known of everything that a rule matches, chooses and makes, by slot.
#[must_use]
pub fn locals_of(facts: &Facts<'_>, rule: &Rule) -> Vec<Abstract> {
    let mut locals: Vec<Abstract> = Vec::new();
    for matched in &rule.matches {
        let owner = |slot: &usize| match locals.get(*slot) {
            Some(Abstract::Part(kinds)) => kinds.clone(),
            _ => facts.kinds(),
        };
        match &matched.what {
            Matched::Part { kind, port, .. } => {
                let kinds = facts.kinds_in(kind);
                locals.push(Abstract::Part(kinds.clone()));
                if *port {
                    locals.push(Abstract::Port(kinds));
                }
            }
            Matched::Port { of } => {
                let kinds = of.as_ref().map_or_else(|| facts.kinds(), owner);
                locals.push(Abstract::Port(kinds));
            }
            Matched::Joint | Matched::Step => locals.push(Abstract::Any),
        }
    }
    for choice in &rule.choices {
        let item = Reasoning::new(facts, locals.clone()).value(&choice.domain).item();
        locals.push(item);
    }
    for effect in &rule.effects {
        if let Effect::Attach { what, .. } | Effect::Replace { with: what, .. } = effect {
            let made = match Reasoning::new(facts, locals.clone()).value(what) {
                Abstract::Kind(kinds) => Abstract::Part(kinds),
                _ => Abstract::Part(facts.kinds()),
            };
            locals.push(made);
        }
    }
    locals
}

/// The same, without the kinds of parts that the rule's own conditions leave out.
/// Not for asking whether one of these conditions says anything.
#[must_use]
pub fn narrowed_locals_of(facts: &Facts<'_>, rule: &Rule) -> Vec<Abstract> {
    let mut locals = locals_of(facts, rule);
    narrow(facts, rule, &mut locals);
    locals
}

/// What is known of the locals of an actuation: the actuator, its variables, its values.
#[must_use]
pub fn actuation_locals(facts: &Facts<'_>, actuation: &Actuation) -> Vec<Abstract> {
    let mut locals = vec![Abstract::Part(facts.kinds_in(&Group::Actuator))];
    for variable in &actuation.variables {
        let one = match variable.ty {
            Ty::Bool => Abstract::Bool(Truth::Sometimes),
            _ => Abstract::Number(Interval::new(variable.domain.0, variable.domain.1)),
        };
        locals.push(match variable.size {
            Some(size) => Abstract::Many(Box::new(one), Interval::point(size as f64)),
            None => one,
        });
    }
    for (_, value) in actuation.lets.iter().chain(&actuation.moving) {
        let value = Reasoning::new(facts, locals.clone()).value(value);
        locals.push(value);
    }
    locals
}

/// Leaves out kinds of matched parts that the rule's own conditions leave out.
fn narrow(facts: &Facts<'_>, rule: &Rule, locals: &mut [Abstract]) {
    let conditions = rule.matches.iter().filter_map(|m| m.condition.as_ref());
    for condition in conditions.chain(rule.guards.iter().map(|g| &g.condition)) {
        for (slot, group) in asked(condition) {
            let port = rule.matches.iter().scan(0, |next, m| {
                let mine = *next;
                *next += m.slots();
                Some((mine, matches!(m.what, Matched::Part { port: true, .. })))
            });
            let port = port.filter(|(mine, port)| *mine == slot && *port).map(|(mine, _)| mine + 1).next();
            for slot in [Some(slot), port].into_iter().flatten() {
                if let Some(Abstract::Part(kinds) | Abstract::Port(kinds)) = locals.get_mut(slot) {
                    let left: Vec<String> =
                        kinds.iter().filter(|kind| facts.belongs(kind, group)).cloned().collect();
                    // What never holds is told elsewhere.
                    if !left.is_empty() {
                        *kinds = left;
                    }
                }
            }
        }
    }
}

/// The locals that a condition asks to be of a group, alone or joined by `and`.
fn asked(condition: &Expr) -> Vec<(usize, &Group)> {
    conjuncts(condition)
        .into_iter()
        .filter_map(|expr| match &expr.kind {
            ExprKind::Binary(a, Operator::Is, b) => match (&a.kind, &b.kind) {
                (ExprKind::Local(slot), ExprKind::Group(group)) => Some((*slot, group)),
                _ => None,
            },
            _ => None,
        })
        .collect()
}

/// The conditions that are joined by `and`.
#[must_use]
pub fn conjuncts(condition: &Expr) -> Vec<&Expr> {
    match &condition.kind {
        ExprKind::Binary(a, Operator::And, b) => [conjuncts(a), conjuncts(b)].concat(),
        _ => vec![condition],
    }
}

/// The kinds of parts that an effect may make.
#[must_use]
pub fn made_by(facts: &Facts<'_>, rule: &Rule, effect: &Effect) -> Vec<String> {
    let (Effect::Attach { what, .. } | Effect::Replace { with: what, .. }) = effect else {
        return Vec::new();
    };
    match Reasoning::new(facts, narrowed_locals_of(facts, rule)).value(what) {
        Abstract::Kind(kinds) => kinds,
        _ => facts.kinds(),
    }
}

impl Facts<'_> {
    /// Whether a domain has nothing to choose from, whatever the design.
    #[must_use]
    pub fn is_empty_domain(&self, domain: &Expr, locals: &[Abstract]) -> bool {
        let mut reasoning = Reasoning::new(self, locals.to_vec());
        match &domain.kind {
            ExprKind::Range(low, high) => reasoning.numbers(low).low > reasoning.numbers(high).high,
            _ => reasoning.value(domain).length() == Interval::point(0.0),
        }
    }
}
