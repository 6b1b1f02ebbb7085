//! Applies rules, takes steps back, repeats recorded steps.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{EvalError, MOST_OPERATIONS, Reference, Scope, Value, evaluate};
use grammar_lang::ir::{
    Cells, Effect, Expr, ExprKind, Holding, Match, Method, Painting, Rule, RuleSet, Spread, Symmetry, Word,
};

use super::choosing::domain_of;
use super::record::{Recorded, Step};
use super::repeated::{self, UnderWay};
use super::scope::DesignScope;
use super::{Derivation, Unrepeatable};
use crate::design::step_of;
use crate::design::{Attachment, Design, MOST_BALLS, PartId, Refusal, balls};

/// How often the rules with `always` are carried out after a step until they settle. What passes from part to part settles after as many times as
/// the body is deep.
const MOST_PASSES: usize = 256;

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
    /// What is carried out after each step never comes to an end.
    Unsettled,
    /// An expression of the rule, or a requirement on what it makes, has no value.
    NoValue(EvalError),
}

impl From<Refusal> for Blocked {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl From<EvalError> for Blocked {
    fn from(error: EvalError) -> Self {
        Self::NoValue(error)
    }
}

impl Blocked {
    /// In words, for tables.
    #[must_use]
    pub fn text(&self, rules: &RuleSet) -> String {
        match self {
            Self::NoMatch => "no match".to_owned(),
            Self::Refused(Refusal::Gone) => "not there".to_owned(),
            Self::Refused(Refusal::PortTaken { .. }) => "port taken".to_owned(),
            Self::Refused(Refusal::Asymmetric(kind)) => format!("symmetry of {kind}"),
            Self::Refused(Refusal::NoImage { kind, port }) => format!("no image of {kind}.{port}"),
            Self::Refused(Refusal::Askew(kind)) => format!("{kind} out of the mirror's plane"),
            Self::Refused(Refusal::BadParameter { name, .. }) => format!("parameter {name}"),
            Self::Refused(Refusal::NoSuchPart(unmade)) => format!("no {}", unmade.field),
            Self::Refused(Refusal::NoPort(name)) => format!("no port {name}"),
            Self::Refused(Refusal::Fixed) => "part of the beginning".to_owned(),
            Self::Refused(Refusal::NotJoined) => "not joined".to_owned(),
            Self::Refused(Refusal::Empty) => "nothing left".to_owned(),
            Self::Refused(Refusal::NoCell) => "no cell there".to_owned(),
            Self::Refused(Refusal::TooMany) => "too many parts".to_owned(),
            Self::Refused(Refusal::TooManyBalls) => "too many balls".to_owned(),
            Self::Requirement(i) => rules.requirements.get(*i).map_or_else(String::new, |r| r.name.clone()),
            Self::Needed => "needed by a later step".to_owned(),
            Self::NoChange => "no change".to_owned(),
            Self::Unsettled => "not settled".to_owned(),
            Self::NoValue(_) => "no value".to_owned(),
        }
    }
}

impl Blocked {
    /// In a sentence, for messages.
    #[must_use]
    pub fn sentence(&self, rules: &RuleSet) -> String {
        match self {
            Self::NoMatch => "the rule does not match there".to_owned(),
            Self::Refused(Refusal::Gone) => "what it names is not in the design (any more)".to_owned(),
            Self::Refused(Refusal::PortTaken { kind, port }) => {
                let image = match rules.symmetry {
                    Symmetry::None => "",
                    _ => ", perhaps by the image of another part",
                };
                format!("the port `{port}` of `{kind}` is taken{image}")
            }
            Self::Refused(Refusal::Asymmetric(kind)) => {
                format!(
                    "the symmetry would be lost: at this place, {} `{kind}` is not its own image, and has no other image",
                    article(kind)
                )
            }
            Self::Refused(Refusal::Askew(kind)) => {
                format!(
                    "on the plane of the mirror, {} `{kind}` that is turned out of the plane, or whose springs rest to one side, is not its own image",
                    article(kind)
                )
            }
            Self::Refused(Refusal::NoImage { kind, port }) => format!(
                "the symmetry would be lost: it maps the port `{port}` of {} `{kind}` to a place that has no port (declare one there, too, or attach it `alone`, without an image)",
                article(kind)
            ),
            Self::Refused(Refusal::BadParameter { name, why }) => {
                format!("`{name}` is outside its domain: {why}")
            }
            Self::Refused(Refusal::NoSuchPart(unmade)) => {
                format!("with its parameters the part has no `{}`: {}", unmade.field, unmade.reason)
            }
            Self::Refused(Refusal::NoPort(name)) => format!("the part has no port `{name}`"),
            Self::Refused(Refusal::Fixed) => {
                "a part of the initial design cannot be removed or replaced".to_owned()
            }
            Self::Refused(Refusal::NotJoined) => "the parts are not joined".to_owned(),
            Self::Refused(Refusal::Empty) => "nothing would be left of the lattice".to_owned(),
            Self::Refused(Refusal::NoCell) => "there is no cell at that place".to_owned(),
            Self::Refused(Refusal::TooMany) => {
                "one step can make at most 256 parts, including images".to_owned()
            }
            Self::Refused(Refusal::TooManyBalls) => {
                format!("the filling would make more than {MOST_BALLS} balls of the design")
            }
            Self::Requirement(i) => rules.requirements.get(*i).map_or_else(String::new, |r| {
                let because = r.because.as_ref().map_or(String::new(), |b| format!(": {b}"));
                format!("`{}` would be broken{because}", r.name)
            }),
            Self::Needed => "a later step needs it".to_owned(),
            Self::NoChange => "it changes nothing".to_owned(),
            Self::Unsettled => format!(
                "the rules with `always` do not settle: after {MOST_PASSES} rounds they still change the design"
            ),
            Self::NoValue(error) => format!("an expression has no value: {}", error.reason),
        }
    }
}

impl Derivation {
    /// Applies a rule with values for all its locals; the design before stays as it is.
    ///
    /// # Errors
    ///
    /// What blocks it.
    pub fn apply(&self, rules: &RuleSet, rule: &Rule, locals: &[Value]) -> Result<Self, Blocked> {
        self.apply_and_tell(rules, rule, locals).map(|(next, _)| next)
    }

    /// The same, with what its effects made: each part with the number of the effect among those that make parts
    /// ([`Effect::makers`]).
    ///
    /// # Errors
    ///
    /// What blocks it.
    pub(super) fn apply_and_tell(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        locals: &[Value],
    ) -> Result<(Self, Vec<(usize, PartId)>), Blocked> {
        let mut next = self.clone();
        let made = self.carry_out(&mut next, rules, &rule.effects, locals, self.next)?;
        next.carry_out_always(rules)?;
        if let Method::Balls(Some(filling)) = rules.method() {
            let balls = balls(&next.design, &filling);
            // Also where the sizes of parts are beyond all numbers.
            if !balls.is_finite() || balls > MOST_BALLS {
                return Err(Refusal::TooManyBalls.into());
            }
        }
        if let Some(broken) = next.broken(rules)? {
            return Err(Blocked::Requirement(broken));
        }
        if !rule.effects.iter().any(|e| matches!(e, Effect::Revert(_))) {
            let locals = locals.iter().map(Recorded::new).collect();
            next.steps.push(Arc::new(Step { id: next.next, rule: rule.name.clone(), locals }));
        }
        next.next += 1;
        Ok((next, made))
    }

    /// Carries out the rules that are carried out after each step, until they change nothing any more: so the design does not depend on how
    /// often they were. Each reads the design as those before it have left it.
    pub(super) fn carry_out_always(&mut self, rules: &RuleSet) -> Result<(), Blocked> {
        if rules.always.is_empty() {
            return Ok(());
        }
        let left = AtomicU64::new(MOST_OPERATIONS);
        for _ in 0..MOST_PASSES {
            let start = self.design.clone();
            for rule in &rules.always {
                let before = self.clone();
                let scope = DesignScope::new(rules, &before).within(&left);
                let mut holds = true;
                for guard in &rule.guards {
                    holds &= evaluate(&guard.condition, &scope, &mut Vec::new())? == Value::Bool(true);
                }
                if holds {
                    let under_way = UnderWay::new(self.next, &rule.effects, &left);
                    before.carry_out_as(under_way, self, rules, &rule.effects, &[])?;
                }
            }
            if self.design == start {
                return Ok(());
            }
        }
        Err(Blocked::Unsettled)
    }

    /// Carries out effects on `next`, as step number `step`. They read the design before the step, or as it is at the last `then` above
    /// them, and what earlier effects have made. Gives what they made, each part with the number of its effect among those that make parts.
    pub(super) fn carry_out(
        &self,
        next: &mut Self,
        rules: &RuleSet,
        effects: &[Effect],
        locals: &[Value],
        step: u64,
    ) -> Result<Vec<(usize, PartId)>, Blocked> {
        let left = AtomicU64::new(MOST_OPERATIONS);
        let under_way = UnderWay::new(step, effects, &left);
        self.carry_out_as(under_way, next, rules, effects, locals)
    }

    fn carry_out_as<'e>(
        &self,
        mut under_way: UnderWay<'e>,
        next: &mut Self,
        rules: &RuleSet,
        effects: &'e [Effect],
        locals: &[Value],
    ) -> Result<Vec<(usize, PartId)>, Blocked> {
        let mut locals = locals.to_vec();
        let mut before = Cow::Borrowed(self);
        for effect in effects {
            if matches!(effect, Effect::Then) {
                before = Cow::Owned(next.clone());
                under_way.begun = false;
                continue;
            }
            // Each has its own.
            under_way.room = repeated::MOST;
            before.carry_out_each(next, rules, std::slice::from_ref(effect), &mut locals, &mut under_way)?;
        }
        Ok(under_way.made)
    }

    /// The same; the parts that effects make follow the locals.
    fn carry_out_each(
        &self,
        next: &mut Self,
        rules: &RuleSet,
        effects: &[Effect],
        locals: &mut Vec<Value>,
        under_way: &mut UnderWay<'_>,
    ) -> Result<(), Blocked> {
        for effect in effects {
            // What was made so far can be read while more is made.
            let made = under_way.begun.then(|| next.design.clone());
            under_way.begun = true;
            let scope = DesignScope::new(rules, self)
                .with_made(made.as_ref().unwrap_or(&self.design))
                .within(under_way.left);
            let values = self.carry_out_one(next, effect, &scope, locals, under_way)?;
            locals.extend(values);
        }
        Ok(())
    }

    /// Carries out an effect that reads what `scope` shows; gives what later ones can read of it: the part that it makes, the lists of
    /// what a block has made, or a value.
    fn carry_out_one(
        &self,
        next: &mut Self,
        effect: &Effect,
        scope: &DesignScope<'_>,
        locals: &mut Vec<Value>,
        under_way: &mut UnderWay<'_>,
    ) -> Result<Vec<Value>, Blocked> {
        let rules = scope.rules();
        let step = under_way.step;
        let made = match effect {
            Effect::Attach { what, on } => {
                if let Some(refusal) = no_such_port(&on.port, scope, locals)? {
                    return Err(refusal.into());
                }
                let attachment = attachment(what, on, scope, locals)?;
                Some(next.design.attach(rules, &attachment, step)?)
            }
            Effect::Replace { part, with, between } => {
                let id = part_in(part, scope, locals)?;
                let Value::Kind(kind) = evaluate(with, scope, locals)? else {
                    return Err(missing(with).into());
                };
                let between = match between {
                    Some((a, b)) => Some((part_in(a, scope, locals)?, part_in(b, scope, locals)?)),
                    None => None,
                };
                Some(next.design.replace(rules, id, &kind, between, step)?)
            }
            Effect::Set { part, attribute, value } => {
                let id = part_in(part, scope, locals)?;
                let value = evaluate(value, scope, locals)?;
                next.design.set(rules, id, attribute, &value)?;
                None
            }
            Effect::SetOfBody { name, value } => {
                let value = evaluate(value, scope, locals)?;
                next.design.set_of_body(rules, name, &value)?;
                None
            }
            Effect::Remove(part) => {
                let id = part_in(part, scope, locals)?;
                next.design.remove(id)?;
                None
            }
            Effect::Revert(reverted) => {
                let Value::Reference(Reference::Step(id)) = evaluate(reverted, scope, locals)? else {
                    return Err(missing(reverted).into());
                };
                next.revert(rules, id)?;
                None
            }
            Effect::Cells(cells) => {
                Painter { rules, scope, cells, step }.paint(&mut next.design, locals)?;
                None
            }
            Effect::Let(value) => return Ok(vec![evaluate(value, scope, locals)?]),
            // It stands between the effects of a rule only.
            Effect::Then => None,
            Effect::Repeat { over, effects, lists } => {
                let before = under_way.made.len();
                repeated::each(over, scope, locals, under_way, &mut |locals, under_way| {
                    // One that stands alone reads nothing that its repetitions make.
                    if let [effect] = effects.as_slice() {
                        return self.carry_out_one(next, effect, scope, locals, under_way).map(drop);
                    }
                    self.carry_out_each(next, rules, effects, locals, under_way)
                })?;
                return Ok(under_way.lists(effects, lists, before, locals));
            }
        };
        let maker = under_way.makers.iter().position(|maker| std::ptr::eq(*maker, effect));
        under_way.made.extend(maker.zip(made));
        Ok(made.map(|made| Value::Reference(Reference::Part(made))).into_iter().collect())
    }

    /// Takes a step back: all others are repeated with their recorded choices.
    ///
    /// Steps that only changed a part which is gone go with it; a step that built
    /// on such a part forbids the reversion.
    fn revert(&mut self, rules: &RuleSet, step: u64) -> Result<(), Blocked> {
        let mut again = Self::begin(rules);
        for old in self.steps.iter().filter(|s| s.id != step) {
            let there_no_more = |reference: &Reference| match reference {
                Reference::Part(id) | Reference::Port(id, _) | Reference::Joint(id) => {
                    step_of(*id) == step && !again.design.parts.contains_key(id)
                }
                _ => false,
            };
            let gone = old.locals.iter().any(|local| local.refers(&there_no_more));
            if gone {
                let builds = |e: &Effect| matches!(e, Effect::Attach { .. } | Effect::Replace { .. });
                let attaches = rules.rule(&old.rule).is_none_or(|r| Effect::single(&r.effects).any(builds));
                if attaches {
                    return Err(Blocked::Needed);
                }
                continue;
            }
            again.repeat(rules, old).map_err(|_| Blocked::Needed)?;
            if self.others_in_their_place(&again, rules, old, step) {
                return Err(Blocked::Needed);
            }
        }
        again.next = self.next;
        *self = again;
        Ok(())
    }

    /// Whether later steps name parts of a step that have become others, as it was repeated for other things: parts are known by their
    /// number within the step.
    fn others_in_their_place(&self, again: &Self, rules: &RuleSet, step: &Step, reverted: u64) -> bool {
        let repeats = |e: &Effect| matches!(e, Effect::Repeat { .. });
        if !rules.rule(&step.rule).is_some_and(|rule| rule.effects.iter().any(repeats)) {
            return false;
        }
        let held = |derivation: &Self, id: PartId| {
            let part = derivation.design.parts.get(&id)?;
            Some((part.kind.clone(), part.held_by))
        };
        let is_another = |reference: &Reference| match reference {
            Reference::Part(id) | Reference::Port(id, _) | Reference::Joint(id)
                if step_of(*id) == step.id =>
            {
                // What a reverted step took away comes back.
                self.design.parts.contains_key(id) && held(self, *id) != held(again, *id)
            }
            _ => false,
        };
        let later = self.steps.iter().filter(|other| other.id > step.id && other.id != reverted);
        later.flat_map(|other| &other.locals).any(|local| local.refers(&is_another))
    }

    /// Works out what a rule says by `let`: it follows from the design as it is now, and from the choices. What reads the temperature
    /// stays as it was recorded.
    fn let_anew(&self, rules: &RuleSet, rule: &Rule, locals: &mut [Value]) -> Result<(), EvalError> {
        let scope = DesignScope::new(rules, self);
        let matched: usize = rule.matches.iter().map(Match::slots).sum();
        let mut cools = |e: &Expr| matches!(e.kind, ExprKind::Word(Word::Search(_)));
        for (place, choice) in rule.choices.iter().enumerate() {
            if choice.spread != Spread::Fixed || choice.domain.any(&mut cools) {
                continue;
            }
            let mut before = locals.get(..matched + place).unwrap_or_default().to_vec();
            let value = domain_of(evaluate(&choice.domain, &scope, &mut before)?).item(0);
            if let (Some(value), Some(local)) = (value, locals.get_mut(matched + place)) {
                *local = value;
            }
        }
        Ok(())
    }

    /// Repeats a recorded step with its own number.
    pub(super) fn repeat(&mut self, rules: &RuleSet, step: &Step) -> Result<(), Unrepeatable> {
        let rule = rules.rule(&step.rule);
        let rule = rule.ok_or_else(|| Unrepeatable::NoRule(step.rule.clone()))?;
        let mut locals: Vec<Value> = step.locals.iter().map(Recorded::value).collect();
        if locals.len() != rule.locals.len() {
            return Err(Unrepeatable::OtherLocals(rule.name.clone()));
        }
        self.let_anew(rules, rule, &mut locals)?;
        if rule.effects.iter().any(|e| matches!(e, Effect::Revert(_))) {
            return Err(Unrepeatable::Reversion);
        }
        let kinds = locals.iter().filter_map(|l| match l {
            Value::Kind(kind) => Some(&kind.name),
            _ => None,
        });
        for kind in kinds {
            if rules.kind(kind).is_none() {
                return Err(Unrepeatable::NoPart(kind.clone()));
            }
        }
        let before = self.clone();
        let done = before.carry_out(self, rules, &rule.effects, &locals, step.id).map(drop);
        done.and_then(|()| self.carry_out_always(rules)).map_err(|blocked| match blocked {
            Blocked::NoValue(error) => Unrepeatable::NoValue(error),
            blocked => Unrepeatable::Refused(blocked.text(rules)),
        })?;
        let kept = locals.iter().map(Recorded::new).collect();
        self.steps.push(Arc::new(Step { locals: kept, ..step.clone() }));
        self.next = self.next.max(step.id + 1);
        Ok(())
    }
}

/// Fills, paints or clears places.
struct Painter<'a> {
    rules: &'a RuleSet,
    scope: &'a DesignScope<'a>,
    cells: &'a Cells,
    step: u64,
}

impl Painter<'_> {
    fn paint(&self, design: &mut Design, locals: &mut Vec<Value>) -> Result<(), Blocked> {
        let Self { rules, scope, cells, step } = *self;
        let lattice = rules.lattice.as_ref().ok_or(Refusal::NoCell)?;
        let region = evaluate(&cells.region, scope, locals)?;
        let places = region.items().iter().filter_map(|place| match place {
            Value::Reference(Reference::Part(id)) => Some(*id),
            _ => None,
        });
        let places: Vec<PartId> = places.collect();
        let with = match &cells.with {
            Some(with) => match evaluate(with, scope, locals)? {
                Value::Kind(kind) => Some(kind),
                _ => return Err(missing(with).into()),
            },
            None => None,
        };
        match (cells.how, with) {
            (Painting::Fill, Some(with)) => design.fill(rules, lattice, &places, &with, step)?,
            (Painting::Paint, Some(with)) => design.paint(rules, lattice, &places, &with)?,
            _ => design.clear(lattice, rules.symmetry, &places)?,
        }
        Ok(())
    }
}

fn missing(expr: &Expr) -> EvalError {
    EvalError { span: expr.span, reason: "this names nothing in the design".to_owned() }
}

fn part_in(expr: &Expr, scope: &DesignScope<'_>, locals: &mut Vec<Value>) -> Result<PartId, EvalError> {
    match evaluate(expr, scope, locals)? {
        Value::Reference(Reference::Part(id)) => Ok(id),
        _ => Err(missing(expr)),
    }
}

/// Why a port that is asked for by its name is not there: not every part has it.
fn no_such_port(
    port: &Expr,
    scope: &DesignScope<'_>,
    locals: &mut Vec<Value>,
) -> Result<Option<Refusal>, EvalError> {
    let ExprKind::Port(of, name, number) = &port.kind else { return Ok(None) };
    let part = evaluate(of, scope, locals)?;
    let number = match number {
        Some(number) => evaluate(number, scope, locals)?.as_number(),
        None => None,
    };
    let found = scope.port(&part, name, number);
    let called = number.map_or_else(|| name.clone(), |number| format!("{name}[{number}]"));
    Ok(found.is_none().then_some(Refusal::NoPort(called)))
}

/// What is attached, where and how, with values.
pub(super) fn attachment(
    what: &Expr,
    on: &Holding,
    scope: &DesignScope<'_>,
    locals: &mut Vec<Value>,
) -> Result<Attachment, EvalError> {
    let Value::Kind(kind) = evaluate(what, scope, locals)? else { return Err(missing(what)) };
    let Value::Reference(Reference::Port(part, port)) = evaluate(&on.port, scope, locals)? else {
        return Err(missing(&on.port));
    };
    let turn = match &on.turned {
        Some(turned) => evaluate(turned, scope, locals)?.as_number().unwrap_or(0.0),
        None => 0.0,
    };
    Ok(Attachment {
        kind: kind.name.clone(),
        params: kind.params.clone(),
        part,
        port,
        turn,
        by: on.by.clone(),
        alone: on.alone,
    })
}

/// The article before the name of a kind.
fn article(kind: &str) -> &'static str {
    if kind.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" }
}
