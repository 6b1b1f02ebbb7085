//! Whether a grammar can make a body that is asked for.
//!
//! First the steps that made the body are repeated as they are. Otherwise it is
//! searched for, depth first, through designs that are contained in it. That is all
//! there is where rules only attach parts: then not to find it means that it cannot
//! be made. Elsewhere the way may lead through other designs, and the search may
//! have to leave it open.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use grammar_lang::eval::{EvalError, Value, evaluate};
use grammar_lang::ir::{Effect, Expr, ExprKind, Kind, Matched, Rule, RuleSet, SearchWord, Spread, Word};

use super::{Observer, Settings};
use crate::derive::random::Stream;
use crate::derive::{BadStep, Blocked, Derivation, DesignScope, Extent, Step, Unrepeatable};
use crate::design::Design;

/// Whether a body can be made.
#[derive(Clone, Debug)]
pub enum Answer {
    /// It can, like this.
    Yes(Box<Made>),
    /// It cannot.
    No(Vec<String>),
    /// The search gave up.
    Open(Vec<String>),
}

/// How a body can be made.
#[derive(Clone, Debug)]
pub struct Made {
    /// A derivation of it.
    pub derivation: Derivation,
    /// Whether its own steps lead there as they are.
    pub own_steps: bool,
}

/// Whether a grammar can make the body of a derivation of this or another grammar.
///
/// # Errors
///
/// [`EvalError`] when an expression of a rule or requirement has no value.
pub fn can_make(
    rules: &RuleSet,
    start: &Derivation,
    wanted: &Derivation,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Answer, EvalError> {
    if let Some(kind) = wanted.design.parts.values().map(|p| &p.kind).find(|kind| !declared(rules, kind)) {
        return Ok(Answer::No(vec![format!("this grammar has no part `{kind}`")]));
    }
    let body = wanted.design.canonical_hash();
    let unfollowed = match follow(rules, start, &wanted.steps, settings) {
        Ok(derivation) if derivation.design.canonical_hash() == body => {
            return Ok(Answer::Yes(Box::new(Made { derivation, own_steps: true })));
        }
        Ok(_) => None,
        Err(BadStep { why: Unrepeatable::NoValue(error), .. }) => return Err(error),
        Err(bad) => Some(format!("step {} of its own derivation cannot be applied: {}", bad.number, bad.why)),
    };
    let broken = broken(rules, wanted);
    if !broken.is_empty() {
        return Ok(Answer::No(broken));
    }
    let mut search = Search {
        rules,
        settings,
        target: pieces(&wanted.design),
        body,
        hints: hints(&wanted.design),
        random: Stream::named(settings.seed, "audit reach"),
        known: BTreeSet::new(),
        tried: 0,
        sampled: false,
        furthest: None,
    };
    if !contained(&pieces(&start.design), &search.target) {
        let reason = "the design that it starts from is not contained in that body".to_owned();
        return Ok(if only_attaches(rules) { Answer::No(vec![reason]) } else { Answer::Open(vec![reason]) });
    }
    let found = search.run(start, observer);
    if let Some(derivation) = found {
        return Ok(Answer::Yes(Box::new(Made { derivation, own_steps: false })));
    }
    let mut reasons: Vec<String> = unfollowed.into_iter().collect();
    reasons.extend(search.story());
    let cold = !rules.rules.iter().any(|r| warm_weight(r) || warm_choice(r));
    let complete = search.tried < settings.budget && !search.sampled && cold && only_attaches(rules);
    if !complete {
        reasons.push(search.why_open());
    }
    Ok(if complete { Answer::No(reasons) } else { Answer::Open(reasons) })
}

fn declared(rules: &RuleSet, kind: &str) -> bool {
    rules.is_cell(kind) || matches!(rules.kind(kind), Some(Kind::Block(_) | Kind::Actuator(_)))
}

/// The requirements that the body breaks. One that names what only this grammar places
/// has no value for the body of another, and is left to the search.
fn broken(rules: &RuleSet, wanted: &Derivation) -> Vec<String> {
    let scope = DesignScope::new(rules, wanted);
    let breaks = |i: &usize| {
        let condition = rules.requirements.get(*i).map(|r| &r.condition);
        condition.is_some_and(|c| evaluate(c, &scope, &mut Vec::new()) == Ok(Value::Bool(false)))
    };
    let all = (0..rules.requirements.len()).filter(breaks);
    all.map(|i| Blocked::Requirement(i).sentence(rules)).collect()
}

/// Repeats steps as they are.
fn follow(
    rules: &RuleSet,
    start: &Derivation,
    steps: &[Arc<Step>],
    settings: &Settings,
) -> Result<Derivation, BadStep> {
    let mut derivation = start.clone();
    for (i, step) in steps.iter().enumerate() {
        derivation = derivation
            .follow(rules, step, settings.temperature)
            .map_err(|why| BadStep { number: i + 1, why })?;
    }
    Ok(derivation)
}

/// Whether rules only ever attach parts: then every design on the way is contained in the result.
fn only_attaches(rules: &RuleSet) -> bool {
    let attaches = |e: &Effect| matches!(e, Effect::Attach { .. } | Effect::Let(_) | Effect::Then);
    let no_step = |m: &grammar_lang::ir::Match| !matches!(m.what, Matched::Step);
    rules.always.is_empty()
        && rules
            .rules
            .iter()
            .all(|r| Effect::single(&r.effects).all(attaches) && r.matches.iter().all(no_step))
}

fn reads_temperature(expr: &Expr) -> bool {
    expr.any(&mut |e| matches!(e.kind, ExprKind::Word(Word::Search(SearchWord::Temperature))))
}

/// Whether a rule may be drawn at one temperature and not at another.
fn warm_weight(rule: &Rule) -> bool {
    reads_temperature(&rule.weight)
}

/// Whether a choice has other values at another temperature.
fn warm_choice(rule: &Rule) -> bool {
    rule.choices.iter().any(|choice| {
        let spread = match &choice.spread {
            Spread::Even | Spread::Fixed => false,
            Spread::Normal(a, b) | Spread::Uniform(a, b) => reads_temperature(a) || reads_temperature(b),
            Spread::Weights(weights) => reads_temperature(weights),
        };
        spread || reads_temperature(&choice.domain)
    })
}

type Pieces = BTreeMap<String, usize>;

/// How often a rule was stopped by what.
type Stops = BTreeMap<(String, String), usize>;

/// The pieces of a design and how often it has each.
fn pieces(design: &Design) -> Pieces {
    let mut counted = Pieces::new();
    for piece in design.pieces() {
        *counted.entry(piece).or_default() += 1;
    }
    counted
}

fn contained(some: &Pieces, all: &Pieces) -> bool {
    some.iter().all(|(piece, n)| all.get(piece).is_some_and(|most| n <= most))
}

/// The numbers that a continuous choice may have to hit: turns and parameters of the body.
fn hints(design: &Design) -> Vec<f64> {
    let mut hints: Vec<f64> = Vec::new();
    for part in design.parts.values() {
        let params = part.params.values().filter_map(Value::as_number);
        for x in std::iter::once(part.turn).chain(params) {
            if !hints.contains(&x) {
                hints.push(x);
            }
        }
    }
    hints
}

struct Search<'a> {
    rules: &'a RuleSet,
    settings: &'a Settings,
    target: Pieces,
    body: String,
    hints: Vec<f64>,
    random: Stream,
    /// The designs that were reached, by hash.
    known: BTreeSet<String>,
    tried: usize,
    sampled: bool,
    /// The largest design that was reached, and what stopped which rule there how often.
    furthest: Option<(usize, Stops)>,
}

/// A design with the applications that are still to be tried.
struct Open {
    derivation: Derivation,
    ways: Vec<(usize, Vec<Value>)>,
    stopped: Stops,
}

impl Search<'_> {
    fn run(&mut self, start: &Derivation, observer: &mut dyn Observer) -> Option<Derivation> {
        if start.design.canonical_hash() == self.body {
            return Some(start.clone());
        }
        let mut path = vec![self.open(start.clone())];
        while let Some(open) = path.last_mut() {
            let Some((rule, locals)) = open.ways.pop() else {
                if let Some(done) = path.pop() {
                    self.note(done);
                }
                continue;
            };
            if self.tried >= self.settings.budget {
                path.into_iter().rev().for_each(|open| self.note(open));
                return None;
            }
            self.tried += 1;
            if self.tried.is_multiple_of(1000) {
                observer.progress("applications tried", self.tried, self.settings.budget);
            }
            let Some(rule) = self.rules.rules.get(rule) else { continue };
            // A rule of which an expression has no value is not applied, as in a search.
            let next = match open.derivation.apply(self.rules, rule, &locals) {
                Ok(next) => next,
                Err(blocked) => {
                    let why = (rule.name.clone(), blocked.text(self.rules));
                    *open.stopped.entry(why).or_default() += 1;
                    continue;
                }
            };
            if next.design.canonical_hash() == self.body {
                return Some(next);
            }
            // Of two that look alike, rules may go on differently.
            if self.known.insert(next.design.turned_hash()) && contained(&pieces(&next.design), &self.target)
            {
                let open = self.open(next);
                path.push(open);
            }
        }
        None
    }

    fn open(&mut self, derivation: Derivation) -> Open {
        let mut ways = Vec::new();
        for (i, rule) in self.rules.rules.iter().enumerate() {
            let temperature = self.settings.temperature;
            // What only takes away leads nowhere from a design that is contained.
            let builds = Effect::single(&rule.effects)
                .any(|e| !matches!(e, Effect::Revert(_) | Effect::Remove(_) | Effect::Let(_) | Effect::Then));
            let drawn =
                warm_weight(rule) || derivation.weight(self.rules, rule, temperature).is_ok_and(|w| w > 0.0);
            if !builds || !drawn {
                continue;
            }
            let most = self.settings.budget.saturating_sub(self.tried).saturating_add(1);
            let found = derivation.applications(
                self.rules,
                rule,
                temperature,
                Extent { most, hints: &self.hints },
                &mut self.random,
            );
            let Ok(found) = found else { continue };
            self.sampled |= found.sampled;
            ways.extend(found.all.into_iter().map(|locals| (i, locals)));
        }
        // The last is tried first: the rules in their order.
        ways.reverse();
        Open { derivation, ways, stopped: Stops::new() }
    }

    fn note(&mut self, open: Open) {
        let parts = open.derivation.design.parts.len();
        if self.furthest.as_ref().is_none_or(|(most, _)| *most < parts) {
            self.furthest = Some((parts, open.stopped));
        }
    }

    /// How far it got, and what stopped it there.
    fn story(&self) -> Vec<String> {
        let Some((parts, stopped)) = &self.furthest else { return Vec::new() };
        let all: usize = self.target.values().sum();
        let mut story = vec![format!("the largest piece of it that was made has {parts} of its {all} parts")];
        let mut by: Vec<_> = stopped.iter().collect();
        by.sort_by_key(|(_, times)| std::cmp::Reverse(**times));
        for ((rule, reason), times) in by.into_iter().take(3) {
            story.push(format!("from there, `{rule}` was stopped {times} times: {reason}"));
        }
        story
    }

    fn why_open(&self) -> String {
        if self.tried >= self.settings.budget {
            format!("stopped after {} applications: a larger --budget may give an answer", self.tried)
        } else if self.sampled {
            "not every value of a continuous choice was tried".to_owned()
        } else if only_attaches(self.rules) {
            "at another --temperature, rules may have other effects".to_owned()
        } else {
            "only derivations through designs that this body contains were tried".to_owned()
        }
    }
}
