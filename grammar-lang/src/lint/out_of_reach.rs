//! Rules that no derivation gets to: what they match is only made by rules that
//! need the same thing first, or has no free port.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::bounds::{Abstract, Kinds, Repeated};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, ExprKind, Group, Matched, Rule};

use super::known::{Known, Locals, groups_of};

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // A lattice is bounded, and begins with cells of the one kind that it has.
    if known.ruleset.lattice.is_some() {
        return;
    }
    let reach = Reach::of(known);
    for (rule, blocked) in known.ruleset.rules.iter().zip(&reach.blocked) {
        if let Some(blocked) = blocked {
            findings.push(
                Diagnostic::new(
                    Code::OUT_OF_REACH,
                    rule.span,
                    format!("no derivation can ever apply the rule `{}`", rule.name),
                )
                .label(reach.why(blocked))
                .help("add a rule that leads from the initial design to this rule"),
            );
        }
    }
}

/// What a rule waits for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Need {
    /// A part of a group.
    Part(Group),
    /// One that has a free port.
    Port(Group),
    /// A step that can be taken back.
    Step,
}

/// The needs that would each do, all of the same sort.
struct Blocked {
    kinds: Kinds,
    needs: Vec<Need>,
}

/// What derivations can get to.
struct Reach<'k, 'r> {
    known: &'k Known<'r>,
    /// What there is in some design.
    there: BTreeSet<Need>,
    /// The rules that wait for something, by number.
    waiting: BTreeMap<Need, Vec<usize>>,
    /// The groups that rules within reach make parts of.
    made: BTreeSet<Group>,
    /// What each rule waits for, if it is not within reach.
    blocked: Vec<Option<Blocked>>,
}

impl<'k, 'r> Reach<'k, 'r> {
    /// Goes on from the initial design for as long as more comes within reach.
    fn of(known: &'k Known<'r>) -> Self {
        let rules: Vec<(&Rule, &Locals)> = known.rules().collect();
        let mut reach = Self {
            known,
            there: BTreeSet::new(),
            waiting: BTreeMap::new(),
            made: BTreeSet::new(),
            blocked: rules.iter().map(|_| None).collect(),
        };
        reach.begin();
        let mut open: VecDeque<usize> = (0..rules.len()).collect();
        let mut reached = vec![false; rules.len()];
        while let Some(number) = open.pop_front() {
            let (Some((rule, locals)), Some(reached)) = (rules.get(number), reached.get_mut(number)) else {
                continue;
            };
            if *reached {
                continue;
            }
            let blocked = reach.blocked(rule, locals);
            *reached = blocked.is_none();
            match &blocked {
                Some(blocked) => reach.wait(number, blocked),
                None => open.extend(reach.after(rule, locals)),
            }
            if let Some(place) = reach.blocked.get_mut(number) {
                *place = blocked;
            }
        }
        reach
    }

    /// What there is in the initial design. Every part but the core is held by one.
    fn begin(&mut self) {
        let begin = &self.known.ruleset.begin;
        let mut held: BTreeMap<String, usize> = BTreeMap::new();
        // What is alone takes a port of one image.
        for on in begin.iter().filter_map(|p| p.on.as_ref()).filter(|on| !on.alone) {
            let mut holders = BTreeSet::new();
            on.port.any(&mut |e| {
                if let ExprKind::Placed(name) = &e.kind {
                    holders.insert(name.clone());
                }
                false
            });
            for holder in holders {
                *held.entry(holder).or_default() += 1;
            }
        }
        for part in begin {
            if let ExprKind::Kind(kind, _) = &part.what.kind {
                let taken = held.get(&part.name).copied().unwrap_or(0) + usize::from(part.on.is_some());
                self.comes(kind, self.known.facts.port_count(kind) > taken);
            }
        }
    }

    /// A part of a kind comes within reach; gives the rules that waited for it.
    fn comes(&mut self, kind: &str, port: bool) -> Vec<usize> {
        let mut woken = Vec::new();
        for group in groups_of(&self.known.facts, kind) {
            if port {
                woken.extend(self.meets(Need::Port(group.clone())));
            }
            woken.extend(self.meets(Need::Part(group)));
        }
        woken
    }

    /// A need is met from now on; gives the rules that waited for it.
    fn meets(&mut self, need: Need) -> Vec<usize> {
        let woken = self.waiting.remove(&need).unwrap_or_default();
        self.there.insert(need);
        woken
    }

    fn wait(&mut self, number: usize, blocked: &Blocked) {
        for need in &blocked.needs {
            self.waiting.entry(need.clone()).or_default().push(number);
        }
    }

    /// A rule comes within reach; gives the rules that waited for what it makes.
    fn after(&mut self, rule: &Rule, locals: &Locals) -> Vec<usize> {
        let known = self.known;
        let mut made = Vec::new();
        known.reasoning(&locals.narrowed).through_effects(
            &rule.effects,
            Repeated::Together,
            &mut |reasoning, effect| {
                made.extend(reasoning.made_by(effect));
            },
        );
        let mut woken = Vec::new();
        for made in made {
            for group in made.groups() {
                if self.made.insert(group.clone()) {
                    for kind in known.facts.names(&Kinds::of(group.clone())) {
                        woken.extend(self.comes(kind, known.facts.port_count(kind) > 1));
                    }
                }
            }
        }
        if !rule.effects.iter().any(|e| matches!(e, Effect::Revert(_))) {
            woken.extend(self.meets(Need::Step));
        }
        woken
    }

    /// What a rule needs that is not within reach.
    fn blocked(&self, rule: &Rule, locals: &Locals) -> Option<Blocked> {
        let mut slot = 0;
        for matched in &rule.matches {
            let blocked = match (&matched.what, locals.narrowed.get(slot)) {
                (Matched::Part { port, .. }, Some(Abstract::Part(kinds))) => {
                    let port = Some(Need::Port as fn(Group) -> Need).filter(|_| *port);
                    let sorts = [Some(Need::Part as fn(Group) -> Need), port].into_iter().flatten();
                    let all = sorts.map(|sort| kinds.groups().cloned().map(sort).collect());
                    all.map(|needs| Blocked { kinds: kinds.clone(), needs }).find(|b| self.lacks(b))
                }
                (Matched::Step, _) => Some(Blocked { kinds: Kinds::default(), needs: vec![Need::Step] })
                    .filter(|b| self.lacks(b)),
                _ => None,
            };
            if blocked.is_some() {
                return blocked;
            }
            slot += matched.slots();
        }
        None
    }

    fn lacks(&self, blocked: &Blocked) -> bool {
        !blocked.needs.iter().any(|need| self.there.contains(need))
    }

    /// What a rule lacks, in words.
    fn why(&self, blocked: &Blocked) -> String {
        let names = self.known.facts.names(&blocked.kinds);
        let listed = |names: &[&str]| names.join("` or `");
        match blocked.needs.first() {
            Some(Need::Step) => "there is never a step that this rule can match".to_owned(),
            Some(Need::Port(_)) => {
                let there = |kind: &&str| self.there.contains(&Need::Part(Group::Kind((*kind).to_owned())));
                let names: Vec<&str> = names.into_iter().filter(there).collect();
                format!("a `{}` never has a free port", listed(&names))
            }
            _ => {
                format!(
                    "no design ever has a `{}` to start from",
                    listed(&names.into_iter().collect::<Vec<_>>())
                )
            }
        }
    }
}
