//! What is known of a grammar whatever the design.

use std::cell::RefCell;
use std::collections::BTreeMap;

use indexmap::IndexSet;

use super::kinds::{Begun, Declared};
use super::{Abstract, Interval, Kinds, Reasoning, Truth};
use crate::ir::{
    DesignWord, Group, Lattice, MotionWord, PartAttribute, RuleSet, SearchWord, Symmetry, Ty, Word,
};

/// What is known of a grammar whatever the design and the values of its parameters.
#[derive(Clone, Debug)]
pub struct Facts<'r> {
    /// The grammar.
    pub rules: &'r RuleSet,
    declared: Declared<'r>,
    /// Words of which more is known than their meaning says.
    words: Vec<(Word, Interval)>,
    /// What terms may be, once that was asked.
    terms: RefCell<BTreeMap<String, Abstract>>,
}

impl<'r> Facts<'r> {
    /// The facts of a grammar.
    #[must_use]
    pub fn new(rules: &'r RuleSet) -> Self {
        Self::from(rules, None)
    }

    /// The same; the parts of the initial design count with their images where that is known.
    #[must_use]
    pub fn from(rules: &'r RuleSet, begun: Option<&Begun>) -> Self {
        let terms = RefCell::new(BTreeMap::new());
        Self { rules, declared: Declared::new(rules, begun), words: Vec::new(), terms }
    }

    /// Knows more of a word.
    #[must_use]
    pub fn with(mut self, word: Word, interval: Interval) -> Self {
        self.words.push((word, interval));
        self.terms.take();
        self
    }

    /// The names of some kinds, each once.
    #[must_use]
    pub fn names<'k>(&self, kinds: &'k Kinds) -> IndexSet<&'k str>
    where
        'r: 'k,
    {
        kinds.groups().flat_map(|group| self.declared.kinds_in(group)).collect()
    }

    /// Whether there is no such kind.
    #[must_use]
    pub fn is_empty(&self, kinds: &Kinds) -> bool {
        kinds.groups().all(|group| self.declared.size(group) == 0)
    }

    /// Whether parts of a kind are of a group.
    #[must_use]
    pub fn belongs(&self, kind: &str, group: &Group) -> bool {
        match group {
            Group::Part => true,
            Group::Block => !self.rules.is_actuator(kind),
            Group::Actuator => self.rules.is_actuator(kind),
            Group::Cell => self.rules.is_cell(kind),
            Group::Kind(name) => name == kind,
        }
    }

    /// Whether a part of one of these kinds is of a group.
    #[must_use]
    pub fn member(&self, kinds: &Kinds, group: &Group) -> Truth {
        let (mut inside, mut outside) = (false, false);
        for some in kinds.groups() {
            let shared = self.declared.shared(some, group);
            inside |= shared > 0;
            outside |= shared < self.declared.size(some);
        }
        Truth::of(inside && !outside, outside && !inside)
    }

    /// Those of these kinds that are of a group.
    #[must_use]
    pub fn within(&self, kinds: &Kinds, group: &Group) -> Kinds {
        let both = kinds.groups().filter_map(|some| self.declared.both(some, group));
        Kinds { groups: both.cloned().collect() }
    }

    /// How many parts of a group the initial design has: they stay.
    #[must_use]
    pub fn placed(&self, group: &Group) -> usize {
        self.declared.placed(group)
    }

    /// The kinds that a part of the initial design may be of.
    #[must_use]
    pub fn kinds_of_placed(&self, name: &str) -> Kinds {
        self.declared.kinds_of_placed(name)
    }

    /// How many parts of a group there are.
    #[must_use]
    pub fn count(&self, group: &Group) -> Interval {
        if self.declared.size(group) == 0 {
            return Interval::point(0.0);
        }
        let lattice = self.rules.lattice.as_ref();
        let of_cells =
            |lattice: &&Lattice| *group == Group::Cell || *group == Group::Kind(lattice.kind.clone());
        if let Some(lattice) = lattice.filter(of_cells) {
            return Interval::new(0.0, lattice.sides.iter().product::<usize>() as f64);
        }
        Interval::new(self.placed(group) as f64, f64::INFINITY)
    }

    /// The names of all ports of some kinds.
    #[must_use]
    pub fn ports(&self, kinds: &Kinds) -> IndexSet<&'r str> {
        self.declared.ports(kinds)
    }

    /// The least and the greatest number of the ports of this name that parts of some kinds have.
    #[must_use]
    pub fn port_numbers(&self, kinds: &Kinds, name: &str) -> Option<Interval> {
        let parts = self.names(kinds).into_iter().filter_map(|kind| self.rules.parts.get(kind));
        let named = parts.flat_map(|part| &part.ports).filter(|port| port.name == name);
        named.map(|port| Interval::point(port.index)).reduce(Interval::hull)
    }

    /// How many ports a part of a kind has.
    #[must_use]
    pub fn port_count(&self, kind: &str) -> usize {
        self.declared.port_count(kind)
    }

    /// Whether a port of a part of these kinds has a name.
    #[must_use]
    pub fn are_ports(&self, kinds: &Kinds, name: &str) -> Truth {
        self.declared.are_ports(kinds, name)
    }

    /// What a term may be. It is worked out once, or terms of terms would take long.
    #[must_use]
    pub fn term(&self, name: &str) -> Abstract {
        let Some(term) = self.rules.terms.get(name) else { return Abstract::Any };
        let known = self.terms.borrow().get(name).cloned();
        known.unwrap_or_else(|| {
            let value = Reasoning::new(self, Vec::new()).value(&term.value);
            self.terms.borrow_mut().insert(name.to_owned(), value.clone());
            value
        })
    }

    /// How often a part off the axis of symmetry is there.
    #[must_use]
    pub fn images(&self) -> usize {
        match self.rules.symmetry {
            Symmetry::None => 1,
            Symmetry::Mirror(_) => 2,
            Symmetry::Radial(count, _) => count.max(1),
        }
    }

    /// The value of a word.
    #[must_use]
    pub fn word(&self, word: Word) -> Abstract {
        if let Some((_, known)) = self.words.iter().rev().find(|(w, _)| *w == word) {
            return Abstract::Number(*known);
        }
        match word {
            Word::Pi => Abstract::Number(Interval::point(std::f64::consts::PI)),
            Word::Cycle | Word::Search(SearchWord::Spent) => Abstract::Number(Interval::new(0.0, 1.0)),
            Word::Motion(MotionWord::Start) => Abstract::Number(Interval::point(0.0)),
            Word::Time
            | Word::Now
            | Word::Before
            | Word::ControlInterval
            | Word::Motion(MotionWord::End | MotionWord::Duration | MotionWord::FrameInterval)
            | Word::Search(
                SearchWord::Temperature
                | SearchWord::Iteration
                | SearchWord::Idle
                | SearchWord::Refused
                | SearchWord::Stagnant
                | SearchWord::Deviation
                | SearchWord::Chain
                | SearchWord::Spread
                | SearchWord::Tuned,
            ) => Abstract::Number(Interval::NOT_NEGATIVE),
            Word::Motion(MotionWord::Elements) => {
                Abstract::Many(Box::new(Abstract::Any), Interval::new(1.0, f64::INFINITY))
            }
            Word::Closed | Word::Inflate | Word::Vent | Word::Design(DesignWord::Middle) => Abstract::Any,
            Word::Design(DesignWord::Connected | DesignWord::NoOverlap) => Abstract::Bool(Truth::Sometimes),
            Word::Motion(MotionWord::Period) | Word::Search(SearchWord::Best | SearchWord::Parent) => {
                Abstract::Number(Interval::ALL)
            }
        }
    }

    /// The values that a parameter may be set to.
    #[must_use]
    pub fn param(&self, name: &str) -> Abstract {
        match self.rules.params.get(name) {
            Some(param) if param.ty == Ty::Bool => Abstract::Bool(Truth::Sometimes),
            Some(param) => match param.domain {
                Some((low, high)) => Abstract::Number(Interval::new(low, high)),
                None => Abstract::Any,
            },
            None => Abstract::Any,
        }
    }

    /// The name of the part that nothing holds.
    pub(super) fn core(&self) -> Option<&str> {
        self.rules.begin.first().filter(|placed| placed.on.is_none()).map(|placed| placed.name.as_str())
    }

    /// An attribute of a part of one of these kinds.
    pub(super) fn part_attribute(&self, kinds: &Kinds, attribute: PartAttribute) -> Abstract {
        let full = 2.0 * std::f64::consts::PI;
        match attribute {
            PartAttribute::Turn => Abstract::Number(Interval::new(0.0, full)),
            PartAttribute::Image => Abstract::Number(Interval::new(0.0, self.images() as f64 - 1.0)),
            PartAttribute::Depth | PartAttribute::Mass => Abstract::Number(Interval::NOT_NEGATIVE),
            PartAttribute::OwnImage
            | PartAttribute::Place
            | PartAttribute::Centre
            | PartAttribute::LeastCorner
            | PartAttribute::GreatestCorner
            | PartAttribute::Facing
            | PartAttribute::Upward
            | PartAttribute::Sideways
            | PartAttribute::PlaceAtRest
            | PartAttribute::CentreAtRest
            | PartAttribute::FacingAtRest
            | PartAttribute::UpwardAtRest
            | PartAttribute::SidewaysAtRest
            | PartAttribute::LowestPoint => Abstract::Any,
            PartAttribute::Holder => Abstract::Part(Kinds::all()),
            PartAttribute::Port => Abstract::Port(Kinds::all()),
            PartAttribute::Twin => Abstract::Part(kinds.clone()),
            // A parameter of that name is what the actuator itself says.
            PartAttribute::LeastBend
            | PartAttribute::GreatestBend
            | PartAttribute::LeastDistance
            | PartAttribute::GreatestDistance
            | PartAttribute::NeutralBend
            | PartAttribute::NeutralDistance
            | PartAttribute::GreatestSpeed
            | PartAttribute::Work => self.param_of(kinds, attribute.text()).unwrap_or(Abstract::Any),
        }
    }

    /// A parameter of a part of one of these kinds; none if no such part has it.
    pub(super) fn param_of(&self, kinds: &Kinds, name: &str) -> Option<Abstract> {
        self.declared.instance_param(kinds, name)
    }
}
