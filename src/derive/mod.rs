//! Derivation: rules applied to designs, step by step.
//!
//! A move draws a rule by weight, one of its matches, then its choices, and
//! applies it once, with its mirror image, as one step. If the result breaks a
//! requirement, or is the same body as before, the whole step is taken back,
//! that rule is out for this move, and another is drawn.

mod apply;
pub mod random;
mod record;
mod scope;
mod start;

use std::sync::Arc;

use grammar_lang::eval::{Domain, EvalError, Reference, Value, evaluate};
use grammar_lang::ir::{Pattern, Rule, RuleSet};

pub use apply::Blocked;
pub use record::{Recorded, Step};
pub use scope::DesignScope;
pub use start::check_start;

use crate::design::Design;
use random::Stream;

/// How many values of a domain that cannot be listed are tried against the guards.
const TRIES: usize = 10_000;

/// A design with the steps that made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivation {
    /// The design.
    pub design: Design,
    /// The steps that made it, in order.
    pub steps: Vec<Step>,
    /// The number of the next step.
    next: u64,
}

/// What a move did.
#[derive(Clone, Debug)]
pub struct Move {
    /// The design after it; `None` if nothing could be applied.
    pub result: Option<Derivation>,
    /// The rule that was applied.
    pub rule: Option<usize>,
    /// The rules that were drawn before it, and what blocked each.
    pub blocked: Vec<(usize, Blocked)>,
}

impl Derivation {
    /// The initial design.
    #[must_use]
    pub fn begin(rules: &RuleSet) -> Self {
        Self { design: Design::begin(rules), steps: Vec::new(), next: 1 }
    }

    /// Makes one move at a temperature.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of a rule has no value.
    pub fn advance(&self, rules: &RuleSet, random: &mut Stream, temperature: f64) -> Result<Move, EvalError> {
        let mut weights = Vec::with_capacity(rules.rules.len());
        for rule in &rules.rules {
            let scope = DesignScope::new(rules, self).at_temperature(temperature);
            let weight = evaluate(&rule.weight, &scope, &mut Vec::new())?.as_number().unwrap_or(0.0);
            weights.push(weight.max(0.0));
        }
        let before = self.design.canonical_hash(rules);
        let mut blocked = Vec::new();
        loop {
            let total: f64 = weights.iter().sum();
            if total <= 0.0 {
                return Ok(Move { result: None, rule: None, blocked });
            }
            let index = random.weighted(&weights);
            let Some(rule) = rules.rules.get(index) else {
                return Ok(Move { result: None, rule: None, blocked });
            };
            match self.draw(rules, rule, random)? {
                Some(locals) => match self.apply(rules, rule, &locals)? {
                    Ok(result) if result.design.canonical_hash(rules) == before => {
                        blocked.push((index, Blocked::NoChange));
                    }
                    Ok(result) => return Ok(Move { result: Some(result), rule: Some(index), blocked }),
                    Err(reason) => blocked.push((index, reason)),
                },
                None => blocked.push((index, Blocked::NoMatch)),
            }
            if let Some(weight) = weights.get_mut(index) {
                *weight = 0.0;
            }
        }
    }

    /// Everything that a rule's pattern matches, as values of its first locals.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when a condition has no value.
    pub fn matches(&self, rules: &RuleSet, rule: &Rule) -> Result<Vec<Vec<Value>>, EvalError> {
        let reference = |r| Value::Reference(r);
        let (candidates, condition): (Vec<Vec<Value>>, _) = match &rule.pattern {
            Pattern::Nothing => (vec![Vec::new()], None),
            Pattern::Step { condition } => (
                self.steps.iter().map(|s| vec![reference(Reference::Step(s.id))]).collect(),
                condition.as_ref(),
            ),
            Pattern::Part { kind, port, condition } => {
                let parts =
                    self.design.parts.keys().copied().filter(|id| self.design.belongs(rules, *id, kind));
                let bound = if *port {
                    parts
                        .flat_map(|id| self.design.free_ports(rules, id).into_iter().map(move |p| (id, p)))
                        .map(|(id, p)| {
                            vec![reference(Reference::Part(id)), reference(Reference::Port(id, p))]
                        })
                        .collect()
                } else {
                    parts.map(|id| vec![reference(Reference::Part(id))]).collect()
                };
                (bound, condition.as_ref())
            }
        };
        let mut out = Vec::new();
        for bound in candidates {
            let scope = DesignScope::new(rules, self);
            let mut fits = match condition {
                Some(condition) => evaluate(condition, &scope, &mut bound.clone())? == Value::Bool(true),
                None => true,
            };
            for guard in rule.guards.iter().filter(|g| g.needs <= bound.len()) {
                fits = fits && evaluate(&guard.condition, &scope, &mut bound.clone())? == Value::Bool(true);
            }
            if fits {
                out.push(bound);
            }
        }
        Ok(out)
    }

    /// Draws a match and the choices of a rule; `None` if there is none.
    fn draw(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        random: &mut Stream,
    ) -> Result<Option<Vec<Value>>, EvalError> {
        let mut matches = self.matches(rules, rule)?;
        while !matches.is_empty() {
            let bound = matches.swap_remove(random.below(matches.len()));
            if let Some(locals) = self.choose(rules, rule, bound, random)? {
                return Ok(Some(locals));
            }
        }
        Ok(None)
    }

    /// Draws the choices from top to bottom; `None` where a guard leaves nothing.
    fn choose(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        mut locals: Vec<Value>,
        random: &mut Stream,
    ) -> Result<Option<Vec<Value>>, EvalError> {
        let scope = DesignScope::new(rules, self);
        for choice in &rule.choices {
            let domain = evaluate(&choice.domain, &scope, &mut locals)?;
            let slots = locals.len() + 1;
            let guards: Vec<_> = rule.guards.iter().filter(|g| g.needs == slots).collect();
            let fits = |value: Value, locals: &mut Vec<Value>| -> Result<bool, EvalError> {
                locals.push(value);
                for guard in &guards {
                    if evaluate(&guard.condition, &scope, locals)? != Value::Bool(true) {
                        locals.pop();
                        return Ok(false);
                    }
                }
                Ok(true)
            };
            let domain = match domain {
                Value::Domain(domain) => domain,
                list => Arc::new(Domain::Items(list.items().to_vec())),
            };
            let mut chosen = false;
            match &*domain {
                Domain::Range { low, high, whole: false } => {
                    for _ in 0..TRIES {
                        let value = Value::Number(low + (high - low) * random.unit());
                        if low > high || fits(value, &mut locals)? {
                            chosen = low <= high;
                            break;
                        }
                    }
                }
                domain if domain.count() > TRIES => {
                    for _ in 0..TRIES {
                        let value = domain.item(random.below(domain.count()));
                        if let Some(value) = value
                            && fits(value, &mut locals)?
                        {
                            chosen = true;
                            break;
                        }
                    }
                }
                domain => {
                    let mut options: Vec<Value> = domain.items().collect();
                    while !chosen && !options.is_empty() {
                        chosen = fits(options.swap_remove(random.below(options.len())), &mut locals)?;
                    }
                }
            }
            if !chosen {
                return Ok(None);
            }
        }
        Ok(Some(locals))
    }

    /// The first requirement that the design breaks.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when a requirement has no value.
    pub fn broken(&self, rules: &RuleSet) -> Result<Option<usize>, EvalError> {
        let scope = DesignScope::new(rules, self);
        for (i, requirement) in rules.requirements.iter().enumerate() {
            if evaluate(&requirement.condition, &scope, &mut Vec::new())? != Value::Bool(true) {
                return Ok(Some(i));
            }
        }
        Ok(None)
    }

    /// Makes the design that recorded steps lead to.
    ///
    /// # Errors
    ///
    /// The number of the step (from 1) that cannot be applied, and why.
    pub fn replay(rules: &RuleSet, steps: &[Step]) -> Result<Self, (usize, String)> {
        let mut derivation = Self::begin(rules);
        for (i, step) in steps.iter().enumerate() {
            derivation.repeat(rules, step).map_err(|reason| (i + 1, reason))?;
        }
        match derivation.broken(rules) {
            Ok(None) => Ok(derivation),
            Ok(Some(i)) => {
                let name = rules.requirements.get(i).map_or("", |r| r.name.as_str());
                Err((steps.len(), format!("the design breaks `{name}`")))
            }
            Err(error) => Err((steps.len(), error.reason)),
        }
    }
}
