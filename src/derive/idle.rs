//! Rules that random walks draw and never apply, and walks that make no actuator.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::{Value, evaluate};
use grammar_lang::ir::{
    Effect, ExampleClause, Expr, ExprKind, Fallback, Function, Group, Guard, Operator, Painting, Requirement,
    Rule, RuleSet,
};
use grammar_lang::units::{Dimension, shown};

use super::random::Stream;
use super::{Blocked, Derivation, DesignScope};

/// How many walks are made, and how many moves each has.
const WALKS: u64 = 8;
const MOVES: usize = 25;
/// How much all of them may take: the sum over all moves of the squared number of parts, since requirements look at pairs.
const EFFORT: usize = 300_000;
/// What a cell counts in this sum, and what a rule does in each move: it is weighed, and may be tried.
const CELL: usize = 20;
const RULE: usize = 6;
/// How often a rule must have been drawn before it counts as one that is never applied.
const DRAWN: usize = 12;
/// The same where nothing but a place is missing: it may wait for designs that walks reach only late.
const SOUGHT: usize = 24;
/// How many operations the requirements may take in all walks together, each as often as there are rules that may be tried in a move.
const ASKED: u64 = 20_000_000;
/// An expression of a rule that runs over more combinations than this may take too long.
const LONG: f64 = 1e6;
/// How many moves must have been made before designs without an actuator count, and those that do not grow.
const MADE: usize = 100;
/// The limit of a requirement is far away if it is so many times what any design has.
const FAR: f64 = 100.0;
/// Designs do not grow if a rule that takes parts away has more than this share of all weights.
const NEARLY: f64 = 0.8;

/// What became of a rule.
#[derive(Clone, Default)]
struct Tried {
    applied: usize,
    /// What stopped it, each time.
    stopped: Vec<Blocked>,
}

/// What random walks from the first design come to.
#[derive(Debug, Default)]
pub struct Walks {
    /// A warning for each rule that is drawn often and never applied, unless an example applies it; one if no design has an actuator to
    /// drive, and one if a rule takes away whatever others attach.
    pub found: Vec<Diagnostic>,
    /// The last design of each walk.
    pub ends: Vec<Derivation>,
}

/// Makes a number of random walks from the first design.
///
/// The walks are always the same. A rule that matches nowhere may wait for a design that they do not reach: it counts as one that is
/// never applied only if something else stops it, too.
#[must_use]
pub fn walk(rules: &RuleSet) -> Walks {
    let Ok(first) = Derivation::start(rules, rules.from.as_deref()) else { return Walks::default() };
    let most = (first.design.parts.len() + MOVES) as f64;
    if rules.rules.iter().chain(&rules.always).any(|rule| takes_long(rule, most)) {
        return Walks::default();
    }
    let mut ends = Vec::new();
    let asked = AtomicU64::new(ASKED);
    let mut tried = vec![Tried::default(); rules.rules.len()];
    let (mut left, mut made, mut has_actuators) = (EFFORT, 0, has_actuators(rules, &first));
    'walks: for walk in 0..WALKS {
        let mut random = Stream::named(walk, "check");
        let mut derivation = first.clone();
        for _ in 0..MOVES {
            // Cells are many, and few requirements look at pairs of them.
            let size = derivation.design.parts.len();
            let of_parts = if rules.lattice.is_some() { CELL * size } else { size * size };
            let effort = of_parts + RULE * rules.rules.len();
            match left.checked_sub(effort) {
                Some(rest) => left = rest,
                None => break 'walks,
            }
            // A move may try every rule, and each asks for all requirements.
            let before = asked.load(Ordering::Relaxed);
            let scope = DesignScope::new(rules, &derivation).within(&asked);
            for requirement in &rules.requirements {
                let _ = evaluate(&requirement.condition, &scope, &mut Vec::new());
            }
            let took = before - asked.load(Ordering::Relaxed);
            let all = took.saturating_mul(rules.rules.len() as u64);
            match before.checked_sub(all.max(took)) {
                Some(rest) => asked.store(rest, Ordering::Relaxed),
                None => break 'walks,
            }
            let step = derivation.advance(rules, &mut random, 0.0);
            for (rule, blocked) in step.blocked {
                tried[rule].stopped.push(blocked);
            }
            if let Some(rule) = step.rule {
                tried[rule].applied += 1;
            }
            let Some(next) = step.result else { break };
            made += 1;
            derivation = next;
            has_actuators |= self::has_actuators(rules, &derivation);
        }
        ends.push(derivation);
    }
    let mut found = never_applied(rules, &tried, made);
    found.extend(never_drawn(rules, &tried, &first, &ends));
    found.extend(limits_far_away(rules, &first, &ends));
    found.extend(begins_at_a_fallback(rules, &first));
    found.extend(rules.fallbacks.iter().filter_map(|fallback| only_adds(rules, fallback)));
    let wants_actuators = rules.lattice.is_none()
        && rules.search.bodies.is_some()
        && rules.tasks.values().all(|task| !task.actuated.is_empty());
    if let (true, false, Some(core)) = (wants_actuators && made >= MADE, has_actuators, rules.begin.first()) {
        found.push(
            Diagnostic::new(Code::NOTHING_TO_SEARCH, core.span, "no design of random walks has an actuator")
                .label(format!("after {made} moves from here, there is still nothing to drive"))
                .help("add a rule that attaches an actuator; `sgc audit` shows what stops each rule"),
        );
    }
    let shrinking = shrinking(rules, &first);
    // Where nothing grows, rules for what has grown find no place.
    if shrinking.is_none() {
        let waits = waits_for_itself(rules, &tried, &first, &ends);
        found.extend(if waits.is_empty() { never_matched(rules, &tried) } else { waits });
    }
    found.extend(shrinking);
    Walks { found, ends }
}

/// A warning for a rule that takes parts away and is drawn nearly always, where others attach some.
fn shrinking(rules: &RuleSet, first: &Derivation) -> Option<Diagnostic> {
    let has = |rule: &Rule, is_it: fn(&Effect) -> bool| rule.effects.iter().any(is_it);
    let scope = DesignScope::new(rules, first);
    let weight = |rule: &Rule| evaluate(&rule.weight, &scope, &mut Vec::new()).ok()?.as_number();
    let weights: Vec<f64> = rules.rules.iter().map(weight).collect::<Option<_>>()?;
    let all: f64 = weights.iter().sum();
    let (rule, weight) = rules.rules.iter().zip(weights).find(|(rule, weight)| {
        has(rule, |effect| matches!(effect, Effect::Remove(_) | Effect::Revert(_))) && *weight > NEARLY * all
    })?;
    rules.rules.iter().find(|rule| has(rule, |effect| matches!(effect, Effect::Attach { .. })))?;
    Some(
        Diagnostic::new(
            Code::NO_ROOM,
            rule.weight.span,
            format!("`{}` takes away what other rules attach", rule.name),
        )
        .label(format!("drawn in {:.1} % of all moves", 100.0 * weight / all))
        .help("give this rule a lower weight, as in `weight 0.3`"),
    )
}

/// A warning for each rule whose weight is zero in all designs of the walks.
fn never_drawn(rules: &RuleSet, tried: &[Tried], first: &Derivation, ends: &[Derivation]) -> Vec<Diagnostic> {
    let is_zero = |rule: &Rule, derivation: &Derivation| {
        evaluate(&rule.weight, &DesignScope::new(rules, derivation), &mut Vec::new())
            .is_ok_and(|weight| weight.as_number().is_some_and(|weight| weight <= 0.0))
    };
    let never = |(rule, tried): &(&Rule, &Tried)| {
        let was_drawn = tried.applied > 0 || !tried.stopped.is_empty();
        // What is written as zero is switched off.
        let is_switched_off = matches!(rule.weight.kind, ExprKind::Number(_));
        !was_drawn && !is_switched_off && std::iter::once(first).chain(ends).all(|one| is_zero(rule, one))
    };
    let told = |(rule, _): (&Rule, &Tried)| {
        Diagnostic::new(
            Code::NEVER_DRAWN,
            rule.weight.span,
            format!("random walks never draw the rule `{}`", rule.name),
        )
        .label("0 or less in all their designs")
        .help("a rule of weight 0 is never tried: give it a weight above 0 in the first design, too")
    };
    rules.rules.iter().zip(tried).filter(never).map(told).collect()
}

/// A warning for each requirement whose limit is far above what any design of the walks has: mostly the wrong unit.
fn limits_far_away(rules: &RuleSet, first: &Derivation, ends: &[Derivation]) -> Vec<Diagnostic> {
    let far = |requirement: &Requirement| {
        let ExprKind::Binary(less, Operator::Less | Operator::LessEqual, limit) = &requirement.condition.kind
        else {
            return None;
        };
        let dimension = limit.ty.dimension().filter(|dimension| *dimension != Dimension::NUMBER)?;
        let number = |value: &Expr, derivation: &Derivation| {
            evaluate(value, &DesignScope::new(rules, derivation), &mut Vec::new()).ok()?.as_number()
        };
        let limit_of_first = number(limit, first)?;
        let designs = std::iter::once(first).chain(ends);
        let pairs: Vec<(f64, f64)> =
            designs.map(|one| Some((number(less, one)?, number(limit, one)?))).collect::<Option<_>>()?;
        let most = pairs.iter().fold(0.0_f64, |most, (value, _)| most.max(*value));
        let is_far = most > 0.0 && pairs.iter().all(|(_, limit)| *limit > FAR * most);
        is_far.then(|| {
            Diagnostic::new(
                Code::EXCLUDES_NOTHING,
                limit.span,
                format!("`{}` allows far more than any design of random walks has", requirement.name),
            )
            .label(format!(
                "{}, and the designs have up to {}",
                shown(limit_of_first, dimension),
                shown(most, dimension)
            ))
            .help("is the unit right?")
        })
    };
    if ends.is_empty() { Vec::new() } else { rules.requirements.iter().filter_map(far).collect() }
}

/// Whether an expression of a rule may run over too many combinations, in a design with so many parts. All its aggregates count as if one
/// stood in the other.
fn takes_long(rule: &Rule, parts: f64) -> bool {
    let width = |over: &Expr| match &over.kind {
        ExprKind::Range(low, high) => match (&low.kind, &high.kind) {
            (ExprKind::Number(low), ExprKind::Number(high)) => high - low + 1.0,
            _ => f64::INFINITY,
        },
        _ => parts,
    };
    let is_long = |expr: &Expr| {
        let mut combinations = 1.0;
        expr.any(&mut |e| {
            if let ExprKind::Aggregate { binders, .. } = &e.kind {
                combinations *= binders.iter().map(|binder| width(&binder.over)).product::<f64>();
            }
            combinations > LONG
        })
    };
    let conditions = rule.matches.iter().filter_map(|matched| matched.condition.as_ref());
    let guards = rule.guards.iter().map(|guard| &guard.condition);
    let drawn = rule.choices.iter().map(|choice| &choice.domain).chain([&rule.weight]);
    let effects = rule.effects.iter().flat_map(Effect::exprs);
    conditions.chain(guards).chain(drawn).chain(effects).any(is_long)
}

/// A warning for a fallback for large designs whose rule makes them larger.
fn only_adds(rules: &RuleSet, fallback: &Fallback) -> Option<Diagnostic> {
    let is_count = |e: &Expr| {
        e.any(&mut |e| {
            matches!(e.kind, ExprKind::Aggregate { body: None, .. } | ExprKind::Call(Function::Count, _))
        })
    };
    let is_for_large = match &fallback.condition.kind {
        ExprKind::Binary(many, Operator::Greater | Operator::GreaterEqual, limit) => {
            is_count(many) && !is_count(limit)
        }
        _ => false,
    };
    let rule = rules.rules.iter().find(|rule| rule.name == fallback.rule)?;
    let effects: Vec<&Effect> = Effect::single(&rule.effects).collect();
    let adds = |effect: &&Effect| match effect {
        Effect::Attach { .. } => true,
        Effect::Cells(cells) => cells.how == Painting::Fill,
        _ => false,
    };
    let takes = |effect: &&Effect| match effect {
        Effect::Remove(_) | Effect::Revert(_) | Effect::Replace { .. } => true,
        Effect::Cells(cells) => cells.how == Painting::Clear,
        _ => false,
    };
    (is_for_large && effects.iter().any(adds) && !effects.iter().any(takes)).then(|| {
        Diagnostic::new(
            Code::NEVER_APPLIED,
            fallback.span,
            format!("this fallback is for large designs, but `{}` only adds", rule.name),
        )
        .label("once it is drawn, no other rule is")
        .help("name a rule that takes something away: with `remove`, `revert` or `clear`")
    })
}

/// A warning for a fallback whose condition holds of the first design: until it no longer does, no other rule is drawn.
fn begins_at_a_fallback(rules: &RuleSet, first: &Derivation) -> Option<Diagnostic> {
    let scope = DesignScope::new(rules, first);
    let holds = |fallback: &&Fallback| {
        evaluate(&fallback.condition, &scope, &mut Vec::new()) == Ok(Value::Bool(true))
    };
    let fallback = rules.fallbacks.iter().find(holds)?;
    Some(
        Diagnostic::new(
            Code::NEVER_APPLIED,
            fallback.condition.span,
            "this holds of the first design already, so the search draws only this fallback",
        )
        .label("true before the first move")
        .help("a fallback is for designs that have gone too far: is the comparison the wrong way round?"),
    )
}

/// A warning for each rule with a condition that was drawn often and found no place.
fn never_matched(rules: &RuleSet, tried: &[Tried]) -> Vec<Diagnostic> {
    let in_examples = in_examples(rules);
    let never = |(rule, tried): &(&Rule, &Tried)| {
        tried.applied == 0
            && tried.stopped.len() >= SOUGHT
            && tried.stopped.iter().all(|cause| *cause == Blocked::NoMatch)
            && rule.matches.iter().any(|matched| matched.condition.is_some())
            && !in_examples.contains(rule.name.as_str())
    };
    let told = |(rule, tried): (&Rule, &Tried)| {
        Diagnostic::new(
            Code::NEVER_APPLIED,
            rule.span,
            format!("random walks never find a place for the rule `{}`", rule.name),
        )
        .label(format!("drawn {} times, and nothing fulfils what follows its `where`", tried.stopped.len()))
        .help("is the condition right? If it waits for designs that other rules make, an example with this step shows that it can be applied")
    };
    rules.rules.iter().zip(tried).filter(never).map(told).collect()
}

/// A warning for each rule that was drawn often, and waits until there is more of something which in all designs of the walks stays the same.
fn waits_for_itself(
    rules: &RuleSet,
    tried: &[Tried],
    first: &Derivation,
    ends: &[Derivation],
) -> Vec<Diagnostic> {
    let in_examples = in_examples(rules);
    let number = |value: &Expr, derivation: &Derivation| {
        evaluate(value, &DesignScope::new(rules, derivation), &mut Vec::new()).ok()?.as_number()
    };
    let waits = |guard: &Guard| {
        let (many, limit) = match &guard.condition.kind {
            ExprKind::Binary(a, Operator::Greater | Operator::GreaterEqual, b) => (a, b),
            ExprKind::Binary(a, Operator::Less | Operator::LessEqual, b) => (b, a),
            _ => return None,
        };
        let (here, limit) = (number(many, first)?, number(limit, first)?);
        let is_same = ends.iter().all(|end| number(many, end) == Some(here));
        (is_same && here <= limit).then_some((here, limit))
    };
    let told = |(rule, tried): (&Rule, &Tried)| {
        let never = tried.applied == 0
            && tried.stopped.len() >= DRAWN
            && tried.stopped.iter().all(|cause| *cause == Blocked::NoMatch)
            && !in_examples.contains(rule.name.as_str());
        let guard = rule.guards.iter().find(|guard| never && guard.needs == 0 && waits(guard).is_some())?;
        let (here, limit) = waits(guard)?;
        let dimension = match &guard.condition.kind {
            ExprKind::Binary(a, ..) => a.ty.dimension().unwrap_or_default(),
            _ => Dimension::NUMBER,
        };
        Some(
            Diagnostic::new(
                Code::NEVER_APPLIED,
                guard.condition.span,
                format!("the rule `{}` waits for what no other rule brings about", rule.name),
            )
            .label(format!(
                "{} in all designs of random walks, and the limit is {}",
                shown(here, dimension),
                shown(limit, dimension)
            ))
            .help("is the comparison the wrong way round? An example with this step shows that the rule can be applied"),
        )
    };
    rules.rules.iter().zip(tried).filter_map(told).collect()
}

/// The rules that examples apply.
fn in_examples(rules: &RuleSet) -> BTreeSet<&str> {
    let steps = rules.examples.values().flat_map(|example| &example.clauses);
    steps
        .filter_map(|clause| match clause {
            ExampleClause::Step { application, .. } => Some(application.rule.as_str()),
            _ => None,
        })
        .collect()
}

fn has_actuators(rules: &RuleSet, derivation: &Derivation) -> bool {
    derivation.design.parts.keys().any(|id| derivation.design.belongs(rules, *id, &Group::Actuator))
}

fn never_applied(rules: &RuleSet, tried: &[Tried], made: usize) -> Vec<Diagnostic> {
    let in_examples = in_examples(rules);
    let never = |(rule, tried): (&Rule, &Tried)| {
        let drawn = tried.stopped.len();
        // Where not even a first move is made, each walk draws every rule once.
        let enough = if made == 0 { 1 } else { DRAWN };
        if tried.applied > 0 || drawn < enough || in_examples.contains(rule.name.as_str()) {
            return None;
        }
        // The most frequent cause; of several, the first that was met.
        let times = |cause: &Blocked| tried.stopped.iter().filter(|other| *other == cause).count();
        let known = tried.stopped.iter().filter(|cause| is_final(cause));
        let (cause, often) =
            known.map(|cause| (cause, times(cause))).reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        // What mostly waits for another design says nothing.
        if 2 * tried.stopped.iter().filter(|cause| is_final(cause)).count() < drawn {
            return None;
        }
        Some(
            Diagnostic::new(
                Code::NEVER_APPLIED,
                rule.span,
                format!("random walks never apply the rule `{}`", rule.name),
            )
            .label(format!("refused {drawn} times of {drawn}, {often} times because: {}", cause.sentence(rules)))
            .help("change the rule or what stops it; `sgc audit` counts what stops each rule, and an example with this step shows that it can be applied"),
        )
    };
    rules.rules.iter().zip(tried).filter_map(never).collect()
}

/// Whether what stopped a rule is more than that it waits for another design, or that an expression has no value, which other checks report.
fn is_final(blocked: &Blocked) -> bool {
    match blocked {
        Blocked::Refused(_) | Blocked::Requirement(_) | Blocked::NoChange => true,
        Blocked::NoMatch | Blocked::Needed | Blocked::Unsettled | Blocked::NoValue(_) => false,
    }
}
