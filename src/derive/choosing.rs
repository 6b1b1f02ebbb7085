//! How a rule draws its choices.

use std::sync::Arc;

use grammar_lang::eval::{Domain, EvalError, Value, evaluate};
use grammar_lang::ir::{Choice, Expr, Guard, Rule, RuleSet, Spread};

use super::random::Stream;
use super::{Derivation, DesignScope};

/// How many values of a domain that cannot be listed are tried against the guards.
const TRIES: usize = 10_000;

/// A spread whose numbers are known.
pub(super) enum Weighing {
    Even,
    Normal(f64, f64),
    Uniform(f64, f64),
    Weights(Vec<f64>),
}

impl Weighing {
    /// The weight of the value number `index`.
    pub(super) fn weight(&self, index: usize, value: &Value) -> f64 {
        let x = value.as_number().unwrap_or(0.0);
        match self {
            Self::Even => 1.0,
            Self::Normal(mean, deviation) if *deviation <= 0.0 => f64::from(u8::from(x == *mean)),
            Self::Normal(mean, deviation) => {
                let z = (x - mean) / deviation;
                libm::exp(-0.5 * z * z)
            }
            Self::Uniform(low, high) => f64::from(u8::from((*low..=*high).contains(&x))),
            Self::Weights(weights) => weights.get(index).copied().unwrap_or(0.0).max(0.0),
        }
    }

    /// A value between two ends; it may lie beyond them.
    pub(super) fn draw(&self, low: f64, high: f64, random: &mut Stream) -> f64 {
        match self {
            Self::Normal(mean, deviation) => random.normal(*mean, *deviation),
            Self::Uniform(least, most) => {
                let (low, high) = (low.max(*least), high.min(*most));
                low + (high - low) * random.unit()
            }
            _ => low + (high - low) * random.unit(),
        }
    }
}

/// The domain of a choice: what is listed in a list or group counts, too.
pub(super) fn domain_of(value: Value) -> Arc<Domain> {
    match value {
        Value::Domain(domain) => domain,
        list => Arc::new(Domain::Items(list.items().to_vec())),
    }
}

/// Draws for one derivation at one temperature.
pub(super) struct Drawing<'a> {
    pub(super) scope: DesignScope<'a>,
    pub(super) rule: &'a Rule,
}

impl Derivation {
    /// Draws the choices of a rule from top to bottom; `None` where a guard leaves nothing.
    pub(super) fn choose(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        mut locals: Vec<Value>,
        temperature: f64,
        random: &mut Stream,
    ) -> Result<Option<Vec<Value>>, EvalError> {
        let drawing = Drawing { scope: DesignScope::new(rules, self).at_temperature(temperature), rule };
        for choice in &rule.choices {
            if !drawing.draw(choice, &mut locals, random)? {
                return Ok(None);
            }
        }
        Ok(Some(locals))
    }
}

impl Drawing<'_> {
    /// Draws one choice onto the locals; false if nothing fits.
    fn draw(&self, choice: &Choice, locals: &mut Vec<Value>, random: &mut Stream) -> Result<bool, EvalError> {
        let domain = domain_of(evaluate(&choice.domain, &self.scope, locals)?);
        let weighing = self.weighing(choice, &domain, locals)?;
        match &*domain {
            Domain::Range { low, high, whole: false } => {
                for _ in 0..TRIES {
                    let x = weighing.draw(*low, *high, random);
                    if low <= high && (*low..=*high).contains(&x) && self.fits(Value::Number(x), locals)? {
                        return Ok(true);
                    }
                }
                Ok(false)
            }
            domain if domain.count() > TRIES => {
                for _ in 0..TRIES {
                    let Some(value) = domain.item(random.below(domain.count())) else { continue };
                    let kept =
                        matches!(weighing, Weighing::Even) || random.unit() < weighing.weight(0, &value);
                    if kept && self.fits(value, locals)? {
                        return Ok(true);
                    }
                }
                Ok(false)
            }
            domain => {
                let mut options: Vec<(f64, Value)> =
                    domain.items().enumerate().map(|(i, v)| (weighing.weight(i, &v), v)).collect();
                while !options.is_empty() {
                    let index = match weighing {
                        Weighing::Even => random.below(options.len()),
                        _ => {
                            let weights: Vec<f64> = options.iter().map(|(w, _)| *w).collect();
                            if weights.iter().sum::<f64>() <= 0.0 {
                                return Ok(false);
                            }
                            random.weighted(&weights)
                        }
                    };
                    let (_, value) = options.swap_remove(index);
                    if self.fits(value, locals)? {
                        return Ok(true);
                    }
                }
                Ok(false)
            }
        }
    }

    /// Adds a value to the locals if the guards that it completes hold.
    pub(super) fn fits(&self, value: Value, locals: &mut Vec<Value>) -> Result<bool, EvalError> {
        locals.push(value);
        let slots = locals.len();
        let complete = |g: &&Guard| g.needs == slots;
        for guard in self.rule.guards.iter().filter(complete) {
            if evaluate(&guard.condition, &self.scope, locals)? != Value::Bool(true) {
                locals.pop();
                return Ok(false);
            }
        }
        Ok(true)
    }

    pub(super) fn weighing(
        &self,
        choice: &Choice,
        domain: &Domain,
        locals: &mut Vec<Value>,
    ) -> Result<Weighing, EvalError> {
        let mut number = |e: &Expr| evaluate(e, &self.scope, locals).map(|v| v.as_number().unwrap_or(0.0));
        Ok(match &choice.spread {
            Spread::Even | Spread::Fixed => Weighing::Even,
            Spread::Normal(mean, deviation) => Weighing::Normal(number(mean)?, number(deviation)?),
            Spread::Uniform(low, high) => Weighing::Uniform(number(low)?, number(high)?),
            Spread::Weights(list) => {
                let weights = evaluate(list, &self.scope, locals)?;
                let weights: Vec<f64> = weights.items().iter().filter_map(Value::as_number).collect();
                if weights.len() != domain.count() {
                    let reason = format!(
                        "{} weights for {} values of `{}`",
                        weights.len(),
                        domain.count(),
                        choice.name
                    );
                    return Err(EvalError { span: list.span, reason });
                }
                Weighing::Weights(weights)
            }
        })
    }
}
