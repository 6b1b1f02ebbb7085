//! How many different designs there are, by the number of moves that it takes to get there.

use std::collections::{BTreeMap, BTreeSet};

use std::sync::Arc;

use grammar_lang::eval::Value;
use grammar_lang::ir::{Effect, Matched, RuleSet};
use serde::Serialize;

use super::{Observer, Settings};
use crate::derive::random::Stream;
use crate::derive::{Derivation, Extent};

/// How a number of designs was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Counted {
    /// Every match and every choice was tried.
    All,
    /// Every match was tried, but there are more choices, or other derivations of the same
    /// bodies may lead further.
    AtLeast,
    /// Seen in random walks.
    Walks,
}

/// The designs that a number of moves leads to, and no smaller number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Depth {
    /// The number of moves.
    pub moves: usize,
    /// How many different designs.
    pub designs: usize,
    /// How they were counted.
    pub counted: Counted,
}

/// Enumerates the first depths for as long as the budget lasts; the others are what walks have seen.
pub(super) fn depths(
    rules: &RuleSet,
    start: &Derivation,
    settings: &Settings,
    seen: &BTreeMap<String, usize>,
    observer: &mut dyn Observer,
) -> Vec<Depth> {
    let mut all = vec![Depth { moves: 0, designs: 1, counted: Counted::All }];
    let mut breadth = Breadth {
        rules,
        settings,
        known: BTreeSet::from([start.design.canonical_hash()]),
        tried_from: BTreeSet::from([start.design.turned_hash()]),
        random: Stream::named(settings.seed, "audit depths"),
        tried: 0,
        counted: Counted::All,
    };
    let mut front = vec![Reached::Start(Arc::new(start.clone()))];
    for moves in 1..=settings.steps {
        if moves > 2 && history_counts(rules) {
            breadth.counted = breadth.counted.max(Counted::AtLeast);
        }
        let before = breadth.known.clone();
        let Some(next) = breadth.next(&front, observer) else {
            // What was found of a depth that is not complete is no number.
            breadth.known = before;
            break;
        };
        let designs = breadth.known.len() - before.len();
        all.push(Depth { moves, designs, counted: breadth.counted });
        if next.is_empty() {
            return all;
        }
        front = next;
    }
    for moves in all.len()..=settings.steps {
        let new = seen.iter().filter(|(hash, at)| **at == moves && !breadth.known.contains(*hash));
        all.push(Depth { moves, designs: new.count(), counted: Counted::Walks });
    }
    all
}

/// Whether what can be done to a body depends on how it came to be.
fn history_counts(rules: &RuleSet) -> bool {
    rules.rules.iter().any(|rule| {
        rule.matches.iter().any(|m| matches!(m.what, Matched::Step))
            || rule.effects.iter().any(|e| matches!(e, Effect::Revert(_)))
    })
}

/// A design as the move that leads there. Designs are large, and most of the last depth are never gone on from: so each is made when it is.
enum Reached {
    Start(Arc<Derivation>),
    By { parent: Arc<Derivation>, rule: usize, locals: Vec<Value> },
}

impl Reached {
    fn derivation(&self, rules: &RuleSet) -> Option<Arc<Derivation>> {
        match self {
            Self::Start(start) => Some(Arc::clone(start)),
            // What could be applied once can be applied again.
            Self::By { parent, rule, locals } => {
                Some(Arc::new(parent.apply(rules, rules.rules.get(*rule)?, locals).ok()?))
            }
        }
    }
}

struct Breadth<'a> {
    rules: &'a RuleSet,
    settings: &'a Settings,
    /// The bodies that were reached, by hash.
    known: BTreeSet<String>,
    /// The designs that were gone on from: several may look alike.
    tried_from: BTreeSet<String>,
    random: Stream,
    tried: usize,
    counted: Counted,
}

impl Breadth<'_> {
    /// The designs that are one move further and new, also those that look like others; `None` if the budget is spent.
    fn next(&mut self, front: &[Reached], observer: &mut dyn Observer) -> Option<Vec<Reached>> {
        let mut found = Vec::new();
        for derivation in front.iter().filter_map(|reached| reached.derivation(self.rules)) {
            for (number, rule) in self.rules.rules.iter().enumerate() {
                let temperature = self.settings.temperature;
                // A rule of which an expression has no value is not applied, as in a search; walks tell of it.
                if derivation.weight(self.rules, rule, temperature).is_ok_and(|weight| weight <= 0.0) {
                    continue;
                }
                // One more than is left: then it is seen that the budget is spent.
                let most = (self.settings.budget - self.tried).saturating_add(1);
                let ways = derivation.applications(
                    self.rules,
                    rule,
                    temperature,
                    Extent { most, hints: &[] },
                    &mut self.random,
                );
                let Ok(ways) = ways else { continue };
                if ways.sampled {
                    self.counted = self.counted.max(Counted::AtLeast);
                }
                for locals in ways.all {
                    if self.tried >= self.settings.budget {
                        return None;
                    }
                    self.tried += 1;
                    if self.tried.is_multiple_of(1000) {
                        observer.progress("applications tried", self.tried, self.settings.budget);
                    }
                    if let Ok(next) = derivation.apply(self.rules, rule, &locals)
                        && self.tried_from.insert(next.design.turned_hash())
                    {
                        self.known.insert(next.design.canonical_hash());
                        found.push(Reached::By { parent: Arc::clone(&derivation), rule: number, locals });
                    }
                }
            }
        }
        Some(found)
    }
}
