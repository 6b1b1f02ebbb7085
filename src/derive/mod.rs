//! Derivation: rules applied to designs, step by step.
//!
//! A move draws a rule by weight, one of its matches, then its choices, and
//! applies it once, with its mirror image, as one step. If the result breaks a
//! requirement, or is the same body as before, the whole step is taken back,
//! that rule is out for this move, and another is drawn.

mod apply;
mod broken;
mod candidate;
mod choosing;
mod divisors;
mod every;
mod example;
mod idle;
mod matching;
pub mod random;
mod record;
mod refused;
mod repeated;
mod scope;
mod start;
mod unrepeatable;

use std::borrow::Borrow;
use std::sync::Arc;

use grammar_lang::bounds::{Facts, locals_of};
use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::eval::{EvalError, Reference, Value, evaluate};
use grammar_lang::ir::{Matched, Rule, RuleSet, Ty};

pub use apply::Blocked;
pub use candidate::Candidate;
pub use every::{Applications, Extent};
pub use example::{failing_examples, run_example};
pub use idle::{Walks, walk};
pub use record::{Recorded, Step, Steps};
pub use scope::DesignScope;
pub use start::{check_begun, check_start, overwritten};
pub use unrepeatable::{BadStep, Unrepeatable};

use crate::design::Design;
pub use random::Stream;

/// A design with the steps that made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivation {
    /// The design.
    pub design: Design,
    /// The steps that made it, in order. Designs that come from one share its steps.
    pub steps: Vec<Arc<Step>>,
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
    /// The initial design. What of it cannot be placed is left out: [`check_start`] reports it.
    #[must_use]
    pub fn begin(rules: &RuleSet) -> Self {
        start::begin(rules).0
    }

    /// Where the search starts: the initial design, or an example.
    ///
    /// # Errors
    ///
    /// What does not hold in the example.
    pub fn start(rules: &RuleSet, from: Option<&str>) -> Result<Self, Box<Diagnostic>> {
        match from.and_then(|name| rules.examples.get_key_value(name)) {
            Some((name, example)) => run_example(rules, name, example),
            None => Ok(Self::begin(rules)),
        }
    }

    /// Makes one move at a temperature. A rule of which an expression has no value is refused, as one
    /// whose result breaks a requirement is.
    #[must_use]
    pub fn advance(&self, rules: &RuleSet, random: &mut Stream, temperature: f64) -> Move {
        let mut blocked = Vec::new();
        let mut weights = Vec::with_capacity(rules.rules.len());
        for (index, rule) in rules.rules.iter().enumerate() {
            weights.push(self.weight(rules, rule, temperature).unwrap_or_else(|error| {
                blocked.push((index, Blocked::NoValue(error)));
                0.0
            }));
        }
        let before = self.design.canonical_hash();
        loop {
            let total: f64 = weights.iter().sum();
            if total <= 0.0 {
                return Move { result: None, rule: None, blocked };
            }
            let index = random.weighted(&weights);
            let Some(rule) = rules.rules.get(index) else {
                return Move { result: None, rule: None, blocked };
            };
            match self.attempt(rules, rule, temperature, random) {
                Ok(result) if result.design.canonical_hash() == before => {
                    blocked.push((index, Blocked::NoChange));
                }
                Ok(result) => return Move { result: Some(result), rule: Some(index), blocked },
                Err(reason) => blocked.push((index, reason)),
            }
            if let Some(weight) = weights.get_mut(index) {
                *weight = 0.0;
            }
        }
    }

    /// Draws a match and the choices of a rule, and applies it.
    fn attempt(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        temperature: f64,
        random: &mut Stream,
    ) -> Result<Self, Blocked> {
        match self.draw(rules, rule, temperature, random)? {
            Some(locals) => self.apply(rules, rule, &locals),
            None => Err(Blocked::NoMatch),
        }
    }

    /// Draws a match and the choices of a rule; `None` if there is none.
    fn draw(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        temperature: f64,
        random: &mut Stream,
    ) -> Result<Option<Vec<Value>>, EvalError> {
        let mut matches = self.matches(rules, rule)?;
        while !matches.is_empty() {
            let bound = matches.swap_remove(random.below(matches.len()));
            if let Some(locals) = self.choose(rules, rule, bound, temperature, random)? {
                return Ok(Some(locals));
            }
        }
        Ok(None)
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

    /// What is kept of it.
    #[must_use]
    pub fn kept(&self) -> Steps {
        Steps { steps: self.recorded(), next: self.next }
    }

    /// Its steps, by themselves.
    #[must_use]
    pub fn recorded(&self) -> Vec<Step> {
        self.steps.iter().map(|step| Step::clone(step)).collect()
    }

    /// The derivation of which this was kept; it goes on as that one would have.
    ///
    /// # Errors
    ///
    /// Which step cannot be applied, and why.
    pub fn restore(rules: &RuleSet, kept: &Steps) -> Result<Self, BadStep> {
        let mut derivation = Self::replay(rules, &kept.steps)?;
        derivation.next = derivation.next.max(kept.next);
        Ok(derivation)
    }

    /// Makes its steps again; `see` gets each with the designs before and after it: what a step
    /// names may be gone later.
    pub fn retrace(&self, rules: &RuleSet, mut see: impl FnMut(&Step, &Design, &Design)) {
        let mut now = Self::begin(rules);
        for step in &self.steps {
            let before = now.design.clone();
            // Its steps have been applied before: they can be again.
            let _ = now.repeat(rules, step);
            see(step, &before, &now.design);
        }
    }

    /// Makes recorded steps by these rules, as moves would: each rule must match there. A design that these rules have made need not pass
    /// this: what a step relied on may have been taken back since.
    ///
    /// # Errors
    ///
    /// Which step cannot be made, and why.
    pub fn follow_all<S: Borrow<Step>>(rules: &RuleSet, steps: &[S]) -> Result<Self, BadStep> {
        let follow = |derivation: Self, (i, step): (usize, &S)| {
            derivation.follow(rules, step.borrow(), 0.0).map_err(|why| BadStep { number: i + 1, why })
        };
        steps.iter().enumerate().try_fold(Self::begin(rules), follow)
    }

    /// Makes the design that recorded steps lead to.
    ///
    /// # Errors
    ///
    /// Which step cannot be applied, and why.
    pub fn replay<S: Borrow<Step>>(rules: &RuleSet, steps: &[S]) -> Result<Self, BadStep> {
        let mut derivation = Self::begin(rules);
        let facts = Facts::from(rules, None);
        for (i, step) in steps.iter().enumerate() {
            let step = step.borrow();
            within(&facts, rules, step)
                .and_then(|()| derivation.repeat(rules, step))
                .map_err(|why| BadStep { number: i + 1, why })?;
        }
        let last = |why| BadStep { number: steps.len(), why };
        match derivation.broken(rules).map_err(|error| last(error.into()))? {
            None => Ok(derivation),
            Some(i) => {
                let name = rules.requirements.get(i).map_or("", |r| r.name.as_str());
                Err(last(Unrepeatable::Breaks(name.to_owned())))
            }
        }
    }
}

/// Fails where a step has chosen what its rule cannot choose in any design: somebody changed it.
fn within(facts: &Facts<'_>, rules: &RuleSet, step: &Step) -> Result<(), Unrepeatable> {
    let Some(rule) = rules.rule(&step.rule) else { return Ok(()) };
    let first = rule.locals.len().saturating_sub(rule.choices.len());
    let mut slot = 0;
    for matched in &rule.matches {
        let own = |slot: usize| step.locals.get(slot).map(Recorded::value);
        if let Matched::Part { port: true, .. } = matched.what
            && let (
                Some(Value::Reference(Reference::Part(part))),
                Some(Value::Reference(Reference::Port(of, _))),
            ) = (own(slot), own(slot + 1))
            && part != of
        {
            return Err(Unrepeatable::NotDrawn(rule.name.clone()));
        }
        slot += matched.slots();
    }
    let known = locals_of(facts, rule);
    let chosen = rule.choices.iter().zip(step.locals.iter().skip(first)).zip(known.iter().skip(first));
    for ((choice, recorded), known) in chosen {
        let (Value::Number(value), within) = (recorded.value(), known.numbers()) else { continue };
        let slack = 1e-9 * (1.0 + value.abs().min(1e9));
        let is_part_of_one =
            choice.domain.ty == Ty::Domain(Box::new(Ty::Count)) && libm::floor(value) != value;
        if is_part_of_one || !(value >= within.low - slack && value <= within.high + slack) {
            let (choice, rule) = (choice.name.clone(), rule.name.clone());
            return Err(Unrepeatable::Beyond { choice, value, rule });
        }
    }
    Ok(())
}
