//! Random walks from the start: every valid move is accepted.

use std::collections::BTreeMap;

use grammar_lang::eval::{EvalError, Value, evaluate};
use grammar_lang::ir::{Group, RuleSet};
use rayon::prelude::*;
use serde::Serialize;

use super::{Observer, Settings};
use crate::derive::random::Stream;
use crate::derive::{Blocked, Derivation, DesignScope};

/// How many walks are made between two reports of progress.
const TOGETHER: usize = 32;

/// What became of a rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rules {
    /// Its name.
    pub name: String,
    /// How often it was drawn.
    pub drawn: usize,
    /// How often it was applied.
    pub applied: usize,
    /// What stopped it how often, the most frequent first.
    pub stopped: Vec<Stopped>,
}

/// What stopped a rule how often.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stopped {
    /// The requirement, if it was one.
    pub requirement: Option<String>,
    /// What stopped it, in a few words.
    pub by: String,
    /// How often.
    pub times: usize,
}

/// What became of a requirement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Requirements {
    /// Its name.
    pub name: String,
    /// How often it was the first that a result broke.
    pub stopped: usize,
}

/// What all walks together gave.
pub(super) struct Walked {
    pub(super) rules: Vec<Rules>,
    pub(super) requirements: Vec<Requirements>,
    pub(super) preferences: Vec<(String, usize, usize)>,
    pub(super) parts: Vec<usize>,
    pub(super) actuators: Vec<usize>,
    /// The designs that were seen, by hash, and after how many moves at the earliest.
    pub(super) seen: BTreeMap<String, usize>,
    /// Expressions of rules that had no value, and how often.
    pub(super) failing: Vec<(EvalError, usize)>,
}

/// What one walk gave.
#[derive(Default)]
struct Walk {
    /// Rules that were applied.
    applied: Vec<usize>,
    /// Rules that were stopped, and by what.
    blocked: Vec<(usize, Blocked)>,
    /// Which preferences each design fulfilled.
    fulfilled: Vec<Vec<bool>>,
    parts: usize,
    actuators: usize,
    /// The hash of the design after each move.
    hashes: Vec<String>,
}

/// Makes all walks. Each has random numbers of its own: the order makes no difference.
pub(super) fn walk(
    rules: &RuleSet,
    start: &Derivation,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Walked, EvalError> {
    let mut walks: Vec<Walk> = Vec::with_capacity(settings.walks);
    while walks.len() < settings.walks {
        let next = walks.len()..settings.walks.min(walks.len() + TOGETHER);
        let some: Result<Vec<Walk>, EvalError> =
            next.into_par_iter().map(|i| one(rules, start, settings, i)).collect();
        walks.extend(some?);
        observer.progress("walks", walks.len(), settings.walks);
    }
    Ok(together(rules, start, &walks))
}

fn one(rules: &RuleSet, start: &Derivation, settings: &Settings, number: usize) -> Result<Walk, EvalError> {
    let mut random = Stream::named(settings.seed, &format!("audit walk {number}"));
    let mut derivation = start.clone();
    let mut walk = Walk::default();
    for _ in 0..settings.steps {
        let step = derivation.advance(rules, &mut random, settings.temperature);
        walk.blocked.extend(step.blocked);
        walk.applied.extend(step.rule);
        if let Some(next) = step.result {
            derivation = next;
        }
        walk.hashes.push(derivation.design.canonical_hash());
        walk.fulfilled.push(fulfilled(rules, &derivation)?);
    }
    let count = |group: &Group| {
        derivation.design.parts.keys().filter(|id| derivation.design.belongs(rules, **id, group)).count()
    };
    walk.parts = count(&Group::Part);
    walk.actuators = count(&Group::Actuator);
    Ok(walk)
}

fn fulfilled(rules: &RuleSet, derivation: &Derivation) -> Result<Vec<bool>, EvalError> {
    let scope = DesignScope::new(rules, derivation);
    let holds = |p: &grammar_lang::ir::Preference| {
        Ok(evaluate(&p.condition, &scope, &mut Vec::new())? == Value::Bool(true))
    };
    rules.preferences.iter().map(holds).collect()
}

fn together(rules: &RuleSet, start: &Derivation, walks: &[Walk]) -> Walked {
    let mut stopped: BTreeMap<(usize, Blocked), usize> = BTreeMap::new();
    for blocked in walks.iter().flat_map(|w| &w.blocked) {
        *stopped.entry(blocked.clone()).or_default() += 1;
    }
    let mut seen = BTreeMap::from([(start.design.canonical_hash(), 0)]);
    for (i, hash) in walks.iter().flat_map(|w| w.hashes.iter().enumerate()) {
        let earliest = seen.entry(hash.clone()).or_insert(i + 1);
        *earliest = (*earliest).min(i + 1);
    }
    let of_rule = |i: usize| -> Rules {
        let applied = walks.iter().flat_map(|w| &w.applied).filter(|r| **r == i).count();
        // What differs by its numbers alone is one cause.
        let mut by: Vec<Stopped> = Vec::new();
        for ((_, blocked), times) in stopped.iter().filter(|((rule, _), _)| *rule == i) {
            let (text, is_requirement) = (blocked.text(rules), matches!(blocked, Blocked::Requirement(_)));
            let same =
                |other: &&mut Stopped| other.by == text && other.requirement.is_some() == is_requirement;
            match by.iter_mut().find(same) {
                Some(same) => same.times += times,
                None => by.push(Stopped {
                    requirement: is_requirement.then(|| text.clone()),
                    by: text,
                    times: *times,
                }),
            }
        }
        by.sort_by_key(|s| std::cmp::Reverse(s.times));
        let name = rules.rules.get(i).map_or(String::new(), |r| r.name.clone());
        let drawn = applied + by.iter().map(|s| s.times).sum::<usize>();
        Rules { name, drawn, applied, stopped: by }
    };
    // A requirement that has no value refuses, too.
    let is_by = |blocked: &Blocked, i: usize, requirement: &grammar_lang::ir::Requirement| match blocked {
        Blocked::NoValue(error) => {
            let (inner, whole) = (error.span, requirement.condition.span);
            inner.file == whole.file && whole.start <= inner.start && inner.end <= whole.end
        }
        blocked => *blocked == Blocked::Requirement(i),
    };
    let of_requirement = |(i, r): (usize, &grammar_lang::ir::Requirement)| Requirements {
        name: r.name.clone(),
        stopped: stopped.iter().filter(|((_, b), _)| is_by(b, i, r)).map(|(_, n)| n).sum(),
    };
    let of_preference = |(i, p): (usize, &grammar_lang::ir::Preference)| {
        let all = walks.iter().flat_map(|w| &w.fulfilled);
        let yes = all.clone().filter(|f| f.get(i) == Some(&true)).count();
        (p.name.clone(), yes, all.count())
    };
    let mut failing: BTreeMap<EvalError, usize> = BTreeMap::new();
    for ((_, blocked), times) in &stopped {
        if let Blocked::NoValue(error) = blocked {
            *failing.entry(error.clone()).or_default() += times;
        }
    }
    Walked {
        failing: failing.into_iter().collect(),
        rules: (0..rules.rules.len()).map(of_rule).collect(),
        requirements: rules.requirements.iter().enumerate().map(of_requirement).collect(),
        preferences: rules.preferences.iter().enumerate().map(of_preference).collect(),
        parts: walks.iter().map(|w| w.parts).collect(),
        actuators: walks.iter().map(|w| w.actuators).collect(),
        seen,
    }
}
