//! Every way in which a rule can be applied, instead of one that is drawn.

use grammar_lang::eval::{Domain, EvalError, Value, evaluate};
use grammar_lang::ir::{Effect, Match, Rule, RuleSet, Spread};

use super::choosing::{Drawing, domain_of};
use super::random::Stream;
use super::record::{Recorded, Step};
use super::{Blocked, Derivation, DesignScope, Unrepeatable};

/// How many values of a domain are tried at most.
const VALUES: usize = 1000;
/// How many values of a continuous domain are drawn.
const SAMPLES: usize = 4;
/// How many values are looked at for each application that may be listed: conditions may leave few.
const LOOKED_AT: usize = 20;

/// The ways in which a rule can be applied.
#[derive(Clone, Debug, Default)]
pub struct Applications {
    /// The values of the rule's locals: what it matches, then what it chooses.
    pub all: Vec<Vec<Value>>,
    /// Whether there are more: a continuous domain was sampled, or a large one cut.
    pub sampled: bool,
}

/// How far applications are listed.
#[derive(Clone, Copy, Debug)]
pub struct Extent<'h> {
    /// How many at most.
    pub most: usize,
    /// Values of continuous domains that are tried beside those that are drawn, in SI units.
    pub hints: &'h [f64],
}

impl Derivation {
    /// The weight of a rule at a temperature.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when the weight has no value.
    pub fn weight(&self, rules: &RuleSet, rule: &Rule, temperature: f64) -> Result<f64, EvalError> {
        let scope = DesignScope::new(rules, self).at_temperature(temperature);
        let mut alone = false;
        for fallback in &rules.fallbacks {
            if evaluate(&fallback.condition, &scope, &mut Vec::new())? == Value::Bool(true) {
                if fallback.rule == rule.name {
                    alone = false;
                    break;
                }
                alone = true;
            }
        }
        if alone {
            return Ok(0.0);
        }
        Ok(evaluate(&rule.weight, &scope, &mut Vec::new())?.as_number().unwrap_or(0.0).max(0.0))
    }

    /// Every match of a rule with every choice that can be drawn for it, but at most so many. Of a continuous
    /// domain the numbers of `hints` are tried that lie in it, and some drawn ones. A choice with which an expression of the rule has no
    /// value is left out, as no move can make it.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when what the rule matches has no value.
    pub fn applications(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        temperature: f64,
        extent: Extent<'_>,
        random: &mut Stream,
    ) -> Result<Applications, EvalError> {
        let scope = DesignScope::new(rules, self).at_temperature(temperature);
        let drawing = Drawing { scope, rule };
        let mut every = Every { drawing, extent, looked: 0, random, found: Applications::default() };
        for mut bound in self.matches(rules, rule)? {
            every.choose(0, &mut bound);
        }
        Ok(every.found)
    }

    /// Whether a rule could draw these values for its locals.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the rule has no value.
    pub fn allows(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        locals: &[Value],
        temperature: f64,
    ) -> Result<bool, EvalError> {
        let matched: usize = rule.matches.iter().map(Match::slots).sum();
        let (Some(bound), Some(chosen)) = (locals.get(..matched), locals.get(matched..)) else {
            return Ok(false);
        };
        if chosen.len() != rule.choices.len() || !self.matches(rules, rule)?.iter().any(|m| m == bound) {
            return Ok(false);
        }
        let scope = DesignScope::new(rules, self).at_temperature(temperature);
        let drawing = Drawing { scope, rule };
        let mut bound = bound.to_vec();
        for (choice, value) in rule.choices.iter().zip(chosen) {
            let domain = domain_of(evaluate(&choice.domain, &drawing.scope, &mut bound)?);
            let fixed = choice.spread == Spread::Fixed;
            let inside = if fixed { domain.item(0).as_ref() == Some(value) } else { domain.holds(value) };
            if !inside || !drawing.fits(value.clone(), &mut bound)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Makes a recorded step under these rules, as a move would: it must match, its choices
    /// must be possible, and the result must fulfil the requirements.
    ///
    /// # Errors
    ///
    /// Why it cannot be made.
    pub fn follow(&self, rules: &RuleSet, step: &Step, temperature: f64) -> Result<Self, Unrepeatable> {
        let rule = rules.rule(&step.rule);
        let rule = rule.ok_or_else(|| Unrepeatable::NoRule(step.rule.clone()))?;
        let locals: Vec<Value> = step.locals.iter().map(Recorded::value).collect();
        let reverts = rule.effects.iter().any(|e| matches!(e, Effect::Revert(_)));
        if reverts || locals.len() != rule.locals.len() {
            return Err(Unrepeatable::OtherLocals(rule.name.clone()));
        }
        if !self.allows(rules, rule, &locals, temperature)? {
            return Err(Unrepeatable::NotDrawn(rule.name.clone()));
        }
        // Parts are named after the steps that made them: the number of the step stays.
        let here = Self { next: step.id.max(self.next), ..self.clone() };
        here.apply(rules, rule, &locals).map_err(|blocked| match blocked {
            Blocked::NoValue(error) => Unrepeatable::NoValue(error),
            blocked => Unrepeatable::Refused(blocked.sentence(rules)),
        })
    }
}

struct Every<'a> {
    drawing: Drawing<'a>,
    extent: Extent<'a>,
    /// How many values were looked at.
    looked: usize,
    random: &'a mut Stream,
    found: Applications,
}

impl Every<'_> {
    /// Goes through the choices from number `index` on.
    fn choose(&mut self, index: usize, locals: &mut Vec<Value>) {
        let rule = self.drawing.rule;
        let Some(choice) = rule.choices.get(index) else {
            self.found.all.push(locals.clone());
            return;
        };
        let depth = locals.len();
        let domain = evaluate(&choice.domain, &self.drawing.scope, locals).map(domain_of);
        let weighed = domain.and_then(|domain| Ok((self.drawing.weighing(choice, &domain, locals)?, domain)));
        // An evaluation that fails may leave locals behind.
        locals.truncate(depth);
        let Ok((weighing, domain)) = weighed else { return };
        let values: Vec<Value> = match &*domain {
            Domain::Range { low, high, whole: false } => {
                self.found.sampled = true;
                let drawn: Vec<f64> = (0..SAMPLES).map(|_| weighing.draw(*low, *high, self.random)).collect();
                let tried = self.extent.hints.iter().chain(&drawn).filter(|x| low <= *x && *x <= high);
                tried.map(|x| Value::Number(*x)).collect()
            }
            domain => {
                self.found.sampled |= domain.count() > VALUES;
                let drawable = domain.items().take(VALUES).enumerate();
                drawable.filter(|(i, value)| weighing.weight(*i, value) > 0.0).map(|(_, v)| v).collect()
            }
        };
        for value in values {
            self.looked += 1;
            if self.found.all.len() >= self.extent.most || self.looked / LOOKED_AT > self.extent.most {
                self.found.sampled = true;
                break;
            }
            if self.drawing.fits(value, locals) == Ok(true) {
                self.choose(index + 1, locals);
            }
            locals.truncate(depth);
        }
    }
}
