//! What is known of the locals of a rule.

use std::collections::BTreeSet;

use super::{Abstract, Facts, Interval, Kinds, Reasoning, Truth};
use crate::ir::{
    ActionSpace, Actuation, Binder, BodyState, Effect, Expr, ExprKind, Group, Matched, Operator, Rule, Ty,
    Variable,
};

/// What is known of everything that a rule matches and chooses, by slot.
#[must_use]
pub fn locals_of(facts: &Facts<'_>, rule: &Rule) -> Vec<Abstract> {
    let mut reasoning = Reasoning::new(facts, Vec::new());
    for matched in &rule.matches {
        let owner = |slot: &usize| match reasoning.locals.get(*slot) {
            Some(Abstract::Part(kinds)) => kinds.clone(),
            _ => Kinds::all(),
        };
        match &matched.what {
            Matched::Part { kind, port, .. } => {
                let kinds = Kinds::of(kind.clone());
                reasoning.locals.push(Abstract::Part(kinds.clone()));
                if *port {
                    reasoning.locals.push(Abstract::Port(kinds));
                }
            }
            Matched::Port { of } => {
                let kinds = of.as_ref().map_or_else(Kinds::all, owner);
                reasoning.locals.push(Abstract::Port(kinds));
            }
            Matched::Joint | Matched::Step => reasoning.locals.push(Abstract::Any),
        }
    }
    for choice in &rule.choices {
        let item = reasoning.value(&choice.domain).item();
        reasoning.locals.push(item);
    }
    reasoning.locals
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
    let actuators = Abstract::Part(Kinds::of(Group::Actuator));
    let mut reasoning = Reasoning::new(facts, vec![actuators]);
    reasoning.locals.extend(actuation.variables.iter().map(varied));
    for state in &actuation.states {
        reasoning.locals.push(match state.ty {
            Ty::Bool => Abstract::Bool(Truth::Sometimes),
            _ => Abstract::Any,
        });
    }
    for action in &actuation.actions {
        reasoning.locals.push(match (&action.ty, &action.space) {
            (Ty::Bool, _) => Abstract::Bool(Truth::Sometimes),
            (_, ActionSpace::Continuous(low, high)) => Abstract::Number(Interval::new(*low, *high)),
            (_, ActionSpace::Discrete(values)) => {
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                Abstract::Number(Interval::new(low, values.iter().copied().fold(low, f64::max)))
            }
        });
    }
    for (_, value) in actuation.lets.iter().chain(&actuation.moving) {
        let value = reasoning.value(value);
        reasoning.locals.push(value);
    }
    reasoning.locals
}

/// What is known of the locals of a state of the robot or of parts: the part, the shared variables, the values.
#[must_use]
pub fn state_locals(facts: &Facts<'_>, state: &BodyState) -> Vec<Abstract> {
    let part = state.of.iter().map(|of| Abstract::Part(Kinds::of(of.clone())));
    let mut reasoning = Reasoning::new(facts, part.collect());
    reasoning.locals.extend(state.variables.iter().map(varied));
    for (_, value) in state.lets.iter().chain(&state.moving) {
        let value = reasoning.value(value);
        reasoning.locals.push(value);
    }
    reasoning.locals
}

/// What is known of a quantity that the search varies.
fn varied(variable: &Variable) -> Abstract {
    let one = match variable.ty {
        Ty::Bool => Abstract::Bool(Truth::Sometimes),
        _ => Abstract::Number(Interval::new(variable.domain.0, variable.domain.1)),
    };
    match variable.size {
        Some(size) => Abstract::Many(Box::new(one), Interval::point(size as f64)),
        None => one,
    }
}

/// Leaves out kinds of matched parts that the rule's own conditions leave out.
fn narrow(facts: &Facts<'_>, rule: &Rule, locals: &mut [Abstract]) {
    // The slots that are filled by a part together with one of its ports.
    let mut with_port = BTreeSet::new();
    let mut slot = 0;
    for matched in &rule.matches {
        if matches!(matched.what, Matched::Part { port: true, .. }) {
            with_port.insert(slot);
        }
        slot += matched.slots();
    }
    let conditions = rule.matches.iter().filter_map(|m| m.condition.as_ref());
    for condition in conditions.chain(rule.guards.iter().map(|g| &g.condition)) {
        for (slot, group) in asked(condition) {
            let port = with_port.get(&slot).map(|slot| slot + 1);
            for slot in [Some(slot), port].into_iter().flatten() {
                if let Some(Abstract::Part(kinds) | Abstract::Port(kinds)) = locals.get_mut(slot) {
                    let left = facts.within(kinds, group);
                    // What never holds is told elsewhere.
                    if !facts.is_empty(&left) {
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
    let (mut open, mut found) = (vec![condition], Vec::new());
    while let Some(expr) = open.pop() {
        match &expr.kind {
            ExprKind::Binary(a, Operator::And, b) => open.extend([&**b, &**a]),
            _ => found.push(expr),
        }
    }
    found
}

/// How what a rule repeats is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeated {
    /// Once, for all repetitions together.
    Together,
    /// Of a range whose ends are known, for its first number and for its last one: as both are taken, what fails for one of them fails for the
    /// whole rule.
    FirstAndLast,
}

impl Reasoning<'_> {
    /// Looks at effects in their order, each with what is known of the locals that it reads: those of the rule, what earlier effects
    /// have made, and what it is repeated for.
    pub fn through_effects<'e>(
        &mut self,
        effects: &'e [Effect],
        seen: Repeated,
        look: &mut dyn FnMut(&mut Self, &'e Effect),
    ) {
        for effect in effects {
            look(self, effect);
            match effect {
                Effect::Repeat { over, effects, lists } => {
                    let depth = self.locals.len();
                    self.through_repeated(over, effects, seen, look);
                    self.locals.truncate(depth);
                    let some = Interval::NOT_NEGATIVE;
                    let list = || Abstract::Many(Box::new(Abstract::Part(Kinds::all())), some);
                    self.locals.extend(lists.iter().map(|_| list()));
                }
                Effect::Let(value) => {
                    let value = self.value(value);
                    self.locals.push(value);
                }
                _ => {}
            }
            let made = self.made_by(effect).map(Abstract::Part);
            self.locals.extend(made);
        }
    }

    /// The same for what is repeated.
    fn through_repeated<'e>(
        &mut self,
        over: &'e [Binder],
        effects: &'e [Effect],
        seen: Repeated,
        look: &mut dyn FnMut(&mut Self, &'e Effect),
    ) {
        let Some((binder, rest)) = over.split_first() else {
            return self.through_effects(effects, seen, look);
        };
        let taken = match &binder.over.kind {
            ExprKind::Range(low, high) if seen == Repeated::FirstAndLast => {
                let ends = self.numbers(low).single().zip(self.numbers(high).single());
                ends.filter(|(low, high)| low <= high)
            }
            _ => None,
        };
        let Some((first, last)) = taken else {
            self.run_over(std::slice::from_ref(binder));
            return self.through_repeated(rest, effects, seen, look);
        };
        let last = Some(last).filter(|last| *last > first);
        for number in [Some(first), last].into_iter().flatten() {
            self.locals.truncate(binder.slot);
            self.locals.push(Abstract::Number(Interval::point(number)));
            self.through_repeated(rest, effects, seen, look);
        }
    }

    /// The kinds of parts that an effect may make; `None` if it makes nothing.
    pub fn made_by(&mut self, effect: &Effect) -> Option<Kinds> {
        let (Effect::Attach { what, .. } | Effect::Replace { with: what, .. }) = effect else { return None };
        Some(match self.value(what) {
            Abstract::Kind(kinds) => kinds,
            _ => Kinds::all(),
        })
    }

    /// Whether a domain has nothing to choose from, whatever the design.
    pub fn is_empty_domain(&mut self, domain: &Expr) -> bool {
        match &domain.kind {
            ExprKind::Range(low, high) => self.numbers(low).low > self.numbers(high).high,
            _ => self.value(domain).length() == Interval::point(0.0),
        }
    }
}
