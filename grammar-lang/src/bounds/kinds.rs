//! Sets of kinds of parts. `part` is one group however many kinds are declared, so that what is
//! asked of a set takes no longer in a large grammar than in a small one.

use std::collections::BTreeMap;

use indexmap::{IndexMap, IndexSet};

use super::{Abstract, Interval, Truth};
use crate::ir::{ACTUATOR_PORTS, BLOCK_PORTS, ExprKind, Group, InstanceParam, Kind, RuleSet, Ty};

/// Kinds of parts: those of some groups, in this order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kinds {
    pub(super) groups: IndexSet<Group>,
}

impl Kinds {
    /// Every kind.
    #[must_use]
    pub fn all() -> Self {
        Self::of(Group::Part)
    }

    /// The kinds of one group.
    #[must_use]
    pub fn of(group: Group) -> Self {
        Self { groups: IndexSet::from([group]) }
    }

    /// The groups that they are the kinds of.
    pub fn groups(&self) -> impl Iterator<Item = &Group> {
        self.groups.iter()
    }

    /// Those of both.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.groups.extend(other.groups);
        self
    }
}

/// What the kinds of a group have in common, and what some of them have.
#[derive(Clone, Debug, Default)]
struct Common<'r> {
    /// How many kinds there are.
    kinds: usize,
    /// How many parts of them the initial design has.
    placed: usize,
    /// The names of their ports, in the order of declaration.
    ports: IndexSet<&'r str>,
    /// What the parameters of their instances may be.
    params: IndexMap<&'r str, Abstract>,
}

/// How many parts of each kind an initial design has.
pub type Begun = BTreeMap<String, usize>;

/// What is known of the declared kinds.
#[derive(Clone, Debug)]
pub(super) struct Declared<'r> {
    rules: &'r RuleSet,
    part: Common<'r>,
    block: Common<'r>,
    actuator: Common<'r>,
    /// The parts of the initial design by name, and the kinds that they are of.
    placed: IndexMap<&'r str, Option<&'r str>>,
    /// How many parts of a kind the initial design has.
    counts: IndexMap<&'r str, usize>,
}

impl<'r> Declared<'r> {
    pub(super) fn new(rules: &'r RuleSet, begun: Option<&Begun>) -> Self {
        let mut placed: IndexMap<&str, Option<&str>> = IndexMap::new();
        let mut counts: IndexMap<&str, usize> = IndexMap::new();
        for part in &rules.begin {
            let kind = match &part.what.kind {
                ExprKind::Kind(name, _) => Some(name.as_str()),
                _ => None,
            };
            placed.entry(&part.name).or_insert(kind);
            if let Some(kind) = kind {
                *counts.entry(kind).or_default() += 1;
            }
        }
        for (kind, count) in begun.into_iter().flatten() {
            if let Some(known) = counts.get_mut(kind.as_str()) {
                *known = *count;
            }
        }
        let [part, block, actuator] = [Common::default(), Common::default(), Common::default()];
        let mut declared = Self { rules, part, block, actuator, placed, counts };
        for kind in rules.parts.keys().chain(rules.actuators.keys()) {
            let one = declared.one(kind);
            let class = if rules.is_actuator(kind) { &mut declared.actuator } else { &mut declared.block };
            for common in [class, &mut declared.part] {
                common.add(&one);
            }
        }
        declared
    }

    /// What is known of one kind.
    fn one(&self, kind: &str) -> Common<'r> {
        let rules = self.rules;
        let params = rules.params_of(kind);
        Common {
            kinds: 1,
            placed: self.counts.get(kind).copied().unwrap_or(0),
            ports: self.ports_of(kind).collect(),
            params: params.into_iter().flatten().map(|(name, p)| (name.as_str(), allowed(p))).collect(),
        }
    }

    /// The ports of a kind, each as often as it is declared.
    fn ports_of(&self, kind: &str) -> impl Iterator<Item = &'r str> + use<'r> {
        let (own, built_in): (&[_], &[_]) = match self.rules.kind(kind) {
            Some(Kind::Block(block)) if !block.ports.is_empty() => (&block.ports, &[]),
            Some(Kind::Actuator(_)) => (&[], ACTUATOR_PORTS),
            Some(Kind::Block(_) | Kind::Cell(_)) | None => (&[], BLOCK_PORTS),
        };
        own.iter().map(|p| p.name.as_str()).chain(built_in.iter().copied())
    }

    /// How many ports a part of a kind has.
    pub(super) fn port_count(&self, kind: &str) -> usize {
        self.ports_of(kind).count()
    }

    /// The declared kinds of a group.
    pub(super) fn kinds_in<'g>(&self, group: &'g Group) -> impl Iterator<Item = &'g str> + use<'r, 'g>
    where
        'r: 'g,
    {
        let rules = self.rules;
        let (blocks, actuators) = (rules.parts.keys(), rules.actuators.keys());
        let (blocks, actuators, one) = match group {
            Group::Part => (Some(blocks), Some(actuators), None),
            Group::Block => (Some(blocks), None, None),
            Group::Actuator => (None, Some(actuators), None),
            Group::Cell => (None, None, self.rules.lattice.as_ref().map(|lattice| lattice.kind.as_str())),
            Group::Kind(name) => (None, None, Some(name.as_str())),
        };
        let several = blocks.into_iter().flatten().chain(actuators.into_iter().flatten());
        several.map(String::as_str).chain(one)
    }

    fn common<T>(&self, group: &Group, get: impl FnOnce(&Common<'r>) -> T) -> T {
        match group {
            Group::Part => get(&self.part),
            Group::Block => get(&self.block),
            Group::Actuator => get(&self.actuator),
            Group::Cell => match &self.rules.lattice {
                Some(lattice) => get(&self.one(&lattice.kind)),
                None => get(&Common::default()),
            },
            Group::Kind(name) => get(&self.one(name)),
        }
    }

    /// How many kinds a group has.
    pub(super) fn size(&self, group: &Group) -> usize {
        match group {
            Group::Kind(_) => 1,
            group => self.common(group, |c| c.kinds),
        }
    }

    /// How many parts of a group the initial design has.
    pub(super) fn placed(&self, group: &Group) -> usize {
        match group {
            Group::Kind(name) => self.counts.get(name.as_str()).copied().unwrap_or(0),
            group => self.common(group, |c| c.placed),
        }
    }

    /// The kinds that a part of the initial design may be of.
    pub(super) fn kinds_of_placed(&self, name: &str) -> Kinds {
        match self.placed.get(name) {
            Some(Some(kind)) => Kinds::of(Group::Kind((*kind).to_owned())),
            _ => Kinds::all(),
        }
    }

    /// How many kinds both groups have.
    pub(super) fn shared(&self, a: &Group, b: &Group) -> usize {
        self.both(a, b).map_or(0, |group| self.size(group))
    }

    /// The group of the kinds that both groups have: it is one of them.
    pub(super) fn both<'g>(&self, a: &'g Group, b: &'g Group) -> Option<&'g Group> {
        let within = |inner: &Group, outer: &Group| match (inner, outer) {
            (_, Group::Part) => true,
            (Group::Kind(kind), Group::Block) => !self.rules.is_actuator(kind),
            (Group::Kind(kind), Group::Actuator) => self.rules.is_actuator(kind),
            (Group::Kind(kind), Group::Cell) => self.rules.is_cell(kind),
            (inner, outer) => inner == outer,
        };
        let both = if within(a, b) { Some(a) } else { Some(b).filter(|_| within(b, a)) };
        both.filter(|group| self.size(group) > 0)
    }

    /// The names of all ports of some kinds, in the order of declaration.
    pub(super) fn ports(&self, kinds: &Kinds) -> IndexSet<&'r str> {
        kinds.groups().flat_map(|group| self.common(group, |c| c.ports.clone())).collect()
    }

    /// Whether each port of these kinds has this name, or none has it.
    pub(super) fn are_ports(&self, kinds: &Kinds, name: &str) -> Truth {
        let (mut yes, mut no) = (false, false);
        for group in kinds.groups() {
            let (has, all) = self.common(group, |c| (c.ports.contains(name), c.ports.len()));
            yes |= has;
            no |= all > usize::from(has);
        }
        Truth::of(yes && !no, no && !yes)
    }

    /// What a parameter of a part of these kinds may be; none if no such part has it.
    pub(super) fn instance_param(&self, kinds: &Kinds, name: &str) -> Option<Abstract> {
        let known = kinds.groups().filter_map(|group| self.common(group, |c| c.params.get(name).cloned()));
        known.reduce(Abstract::hull)
    }
}

impl<'r> Common<'r> {
    fn add(&mut self, one: &Self) {
        self.kinds += one.kinds;
        self.placed += one.placed;
        self.ports.extend(&one.ports);
        for (name, param) in &one.params {
            let known = self.params.entry(name).or_insert_with(|| param.clone());
            *known = known.clone().hull(param.clone());
        }
    }
}

/// The values that a parameter of an instance may have.
fn allowed(param: &InstanceParam) -> Abstract {
    match (&param.ty, param.domain) {
        (Ty::Bool, _) => Abstract::Bool(Truth::Sometimes),
        (_, Some((low, high))) => Abstract::Number(Interval::new(low, high)),
        _ => Abstract::Any,
    }
}
