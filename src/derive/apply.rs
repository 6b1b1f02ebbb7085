//! Applies rules, takes steps back, repeats recorded steps.

use grammar_lang::eval::{EvalError, Reference, Value, evaluate};
use grammar_lang::ir::{Effect, Rule, RuleSet};

use super::Derivation;
use super::record::{Recorded, Step};
use super::scope::DesignScope;
use crate::design::{Attachment, Refusal};

/// Why a rule could not be applied.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Blocked {
    /// It matches nowhere, or its guards leave nothing to choose.
    NoMatch,
    /// The design itself refuses.
    Refused(Refusal),
    /// The result breaks the requirement with this index.
    Requirement(usize),
    /// What it takes back is needed by a later step.
    Needed,
    /// The body is the same as before, as after turning a ball.
    NoChange,
}

impl Blocked {
    /// In words, for tables.
    #[must_use]
    pub fn text(&self, rules: &RuleSet) -> String {
        match self {
            Self::NoMatch => "no match".to_owned(),
            Self::Refused(Refusal::Gone) => "not there".to_owned(),
            Self::Refused(Refusal::PortTaken) => "port taken".to_owned(),
            Self::Refused(Refusal::Asymmetric) => "symmetry".to_owned(),
            Self::Refused(Refusal::BadParameter(name)) => format!("parameter {name}"),
            Self::Requirement(i) => rules.requirements.get(*i).map_or_else(String::new, |r| r.name.clone()),
            Self::Needed => "needed by a later step".to_owned(),
            Self::NoChange => "no change".to_owned(),
        }
    }
}

/// A description of an effect with its values, from the design before the rule.
enum Deed {
    Attach(Attachment),
    Set(u64, String, Value),
    Revert(u64),
}

impl Derivation {
    /// Applies a rule with values for all its locals; the design before stays as it is.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression has no value.
    pub fn apply(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        locals: &[Value],
    ) -> Result<Result<Self, Blocked>, EvalError> {
        let deeds = self.deeds(rules, rule, locals)?;
        let mut next = self.clone();
        let mut reverts = false;
        for deed in deeds {
            let done = match deed {
                Deed::Attach(attachment) => {
                    next.design.attach(rules, &attachment, next.next).map_err(Blocked::Refused)
                }
                Deed::Set(part, attribute, value) => {
                    next.design.set(rules, part, &attribute, &value).map_err(Blocked::Refused)
                }
                Deed::Revert(step) => {
                    reverts = true;
                    next.revert(rules, step)
                }
            };
            if let Err(blocked) = done {
                return Ok(Err(blocked));
            }
        }
        if let Some(broken) = next.broken(rules)? {
            return Ok(Err(Blocked::Requirement(broken)));
        }
        if !reverts {
            let locals = locals.iter().filter_map(Recorded::new).collect();
            next.steps.push(Step { id: next.next, rule: rule.name.clone(), locals });
        }
        next.next += 1;
        Ok(Ok(next))
    }

    /// The effects of a rule with their values: all read the design before the rule.
    fn deeds(&self, rules: &RuleSet, rule: &Rule, locals: &[Value]) -> Result<Vec<Deed>, EvalError> {
        let scope = DesignScope::new(rules, self);
        let mut locals = locals.to_vec();
        let mut deeds = Vec::new();
        for effect in &rule.effects {
            let missing = |span| EvalError { span, reason: "this names nothing in the design".to_owned() };
            deeds.push(match effect {
                Effect::Attach { what, port, turned } => {
                    let Value::Kind(kind) = evaluate(what, &scope, &mut locals)? else {
                        return Err(missing(what.span));
                    };
                    let Value::Reference(Reference::Port(part, place)) = evaluate(port, &scope, &mut locals)?
                    else {
                        return Err(missing(port.span));
                    };
                    let turn = match turned {
                        Some(turned) => evaluate(turned, &scope, &mut locals)?.as_number().unwrap_or(0.0),
                        None => 0.0,
                    };
                    Deed::Attach(Attachment {
                        kind: kind.name.clone(),
                        params: kind.params.clone(),
                        part,
                        port: place,
                        turn,
                    })
                }
                Effect::Set { part, attribute, value } => {
                    let Value::Reference(Reference::Part(id)) = evaluate(part, &scope, &mut locals)? else {
                        return Err(missing(part.span));
                    };
                    Deed::Set(id, attribute.clone(), evaluate(value, &scope, &mut locals)?)
                }
                Effect::Revert(step) => {
                    let Value::Reference(Reference::Step(id)) = evaluate(step, &scope, &mut locals)? else {
                        return Err(missing(step.span));
                    };
                    Deed::Revert(id)
                }
            });
        }
        Ok(deeds)
    }

    /// Takes a step back: all others are repeated with their recorded choices.
    ///
    /// Steps that only changed a part which is gone go with it; a step that built
    /// on such a part forbids the reversion.
    fn revert(&mut self, rules: &RuleSet, step: u64) -> Result<(), Blocked> {
        let mut again = Self::begin(rules);
        for old in self.steps.iter().filter(|s| s.id != step) {
            let gone = old.locals.iter().any(|local| match local {
                Recorded::Reference(Reference::Part(id) | Reference::Port(id, _)) => {
                    id >> 8 == step && !again.design.parts.contains_key(id)
                }
                _ => false,
            });
            if gone {
                let attaches = rules
                    .rules
                    .iter()
                    .find(|r| r.name == old.rule)
                    .is_none_or(|r| r.effects.iter().any(|e| matches!(e, Effect::Attach { .. })));
                if attaches {
                    return Err(Blocked::Needed);
                }
                continue;
            }
            again.repeat(rules, old).map_err(|_| Blocked::Needed)?;
        }
        again.next = self.next;
        *self = again;
        Ok(())
    }

    /// Repeats a recorded step with its own number.
    pub(super) fn repeat(&mut self, rules: &RuleSet, step: &Step) -> Result<(), String> {
        let rule = rules
            .rules
            .iter()
            .find(|r| r.name == step.rule)
            .ok_or_else(|| format!("there is no rule `{}`", step.rule))?;
        let locals: Vec<Value> = step.locals.iter().map(Recorded::value).collect();
        if locals.len() != rule.locals.len() {
            return Err(format!("the rule `{}` now matches and chooses other things", rule.name));
        }
        let deeds = self.deeds(rules, rule, &locals).map_err(|e| e.reason)?;
        for deed in deeds {
            match deed {
                Deed::Attach(attachment) => {
                    if !rules.parts.contains_key(&attachment.kind) && !rules.is_actuator(&attachment.kind) {
                        return Err(format!("there is no part `{}`", attachment.kind));
                    }
                    self.design.attach(rules, &attachment, step.id)
                }
                Deed::Set(part, attribute, value) => self.design.set(rules, part, &attribute, &value),
                Deed::Revert(_) => return Err("a reversion is no step".to_owned()),
            }
            .map_err(|refusal| Blocked::Refused(refusal).text(rules))?;
        }
        self.steps.push(step.clone());
        self.next = self.next.max(step.id + 1);
        Ok(())
    }
}
