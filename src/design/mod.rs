//! The design: what a rule set makes and a model simulates.
//!
//! A [`Design`] is a tree of parts with the history of steps that made it. It is
//! the contract between derivation and simulation: any rule set makes designs,
//! any model lowers their [`assembly::Assembly`].

pub mod assembly;
mod body;
mod canonical;
mod change;
mod filled;
pub mod lattice;
mod overlap;
mod places;
mod port;
mod row;
mod symmetry;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

pub use grammar_lang::eval::PartId;
use grammar_lang::eval::{BodyValues, Made, Unmade, Value, WithValues};
use grammar_lang::ir::{Group, RuleSet};
use grammar_lang::units;
use indexmap::IndexMap;
use nalgebra::Isometry3;

pub use body::Body;
pub(crate) use filled::{MOST_BALLS, balls};
pub use port::{PortFrame, ports};
pub(crate) use port::{ends, pose_at};

/// How many bits of a part's number say which of its step's parts it is; the bits above them are the
/// step's number.
const PART_BITS: u32 = 8;

/// The core: the first part of the initial design.
pub const CORE: PartId = PartId::from_number(0);

/// The number of the first part that a step makes.
#[must_use]
pub fn first_of(step: u64) -> PartId {
    PartId::from_number(step << PART_BITS)
}

/// The step that made a part.
#[must_use]
pub fn step_of(id: PartId) -> u64 {
    id.number() >> PART_BITS
}

/// A part of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The declared kind.
    pub kind: String,
    /// The parameters that it has for itself.
    pub params: IndexMap<String, Value>,
    /// What its kind says it is, with these parameters.
    pub(crate) made: Arc<Made>,
    /// Rotation about the port that holds it, rad; an image has that of its original,
    /// measured in its own mirrored frame.
    pub turn: f64,
    /// The part and its port that hold this one; none for the core.
    pub held_by: Option<(PartId, u8)>,
    /// The port of its own that it is held by.
    pub holding: u8,
    /// The part whose image this is.
    pub image_of: Option<PartId>,
    /// Which image of the symmetry it is; 0 is the original.
    pub image: u8,
    /// Whether it has no images, and need not be its own: it, or what holds it, was attached so.
    pub alone: bool,
    /// The step that made it; 0 for the initial design.
    pub step: u64,
    /// Pose of its frame in the world: the centre of a block, the base of an actuator.
    pub pose: Isometry3<f64>,
}

impl Part {
    /// Where its joint stands as a motion begins, in words; none if that is as it is attached.
    #[must_use]
    pub fn begins_bent(&self) -> Option<String> {
        let joint = match self.made.as_ref() {
            Made::Block(made) => made.joint.as_ref()?,
            Made::Actuator(made) => &made.joint,
            Made::Cell(_) => return None,
        };
        let start = joint.start();
        (start != 0.0).then(|| {
            let at = units::shown(start, joint.kind.position());
            format!(
                "`{}` begins with its joint at {at} (its `neutral`, or what `begins` says): leave room for this position",
                self.kind
            )
        })
    }
}

/// Why a change of a design is not possible.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// The part, port or step that is meant does not exist (any more).
    Gone,
    /// Something is attached already to a port of a part of this kind.
    PortTaken {
        /// The kind of the part.
        kind: String,
        /// What the port is called.
        port: String,
    },
    /// The change would break the symmetry: a part of this kind would have no image, and not be its own.
    Asymmetric(String),
    /// The symmetry leads from a port of this kind of part to a place where its image has no port.
    NoImage {
        /// The kind of the part.
        kind: String,
        /// What the port is called.
        port: String,
    },
    /// An actuator of this kind is turned out of the plane of the mirror that it lies on.
    Askew(String),
    /// A parameter lies outside its domain or has no value.
    BadParameter {
        /// Its name.
        name: String,
        /// What is wrong with its value.
        why: String,
    },
    /// With its parameters a field of the part has no value that a part can have.
    NoSuchPart(Unmade),
    /// The part has no such port.
    NoPort(String),
    /// The part belongs to the initial design and stays.
    Fixed,
    /// The parts are not joined.
    NotJoined,
    /// Nothing would be left of the lattice.
    Empty,
    /// There is no cell at the place.
    NoCell,
    /// One step, or the beginning, makes more than 256 parts: see [`PartId`].
    TooMany,
    /// The filling would make more balls of the design than can be worked with.
    TooManyBalls,
}

/// A tree of parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Design {
    /// The parts in the order of their making; the first is the core.
    pub parts: IndexMap<PartId, Part>,
    /// What the initial design calls its parts.
    pub placed: BTreeMap<String, PartId>,
    /// What the parameters of the grammar that rules set are in this body.
    pub values: BodyValues,
}

/// What is attached, where and how.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// The declared kind.
    pub kind: String,
    /// Parameters that the rule gave.
    pub params: Vec<(String, Value)>,
    /// The part that holds it.
    pub part: PartId,
    /// The port of that part.
    pub port: u8,
    /// Rotation about the port's normal, rad.
    pub turn: f64,
    /// The port of its own that it is held by, if one is named.
    pub by: Option<String>,
    /// Whether it has no images.
    pub alone: bool,
}

impl Part {
    /// Whether its ports are those of its kind in a mirror.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        matches!(self.made.as_ref(), Made::Block(block) if block.mirrored)
    }
}

impl Part {
    /// Whether it is another part than one of its kind in the same place would be: its ports, or how its joint moves, are those of
    /// the kind in a mirror.
    #[must_use]
    pub fn is_seen_in_mirror(&self) -> bool {
        let joint = match self.made.as_ref() {
            Made::Block(block) => block.joint.as_ref(),
            Made::Actuator(row) => Some(&row.joint),
            Made::Cell(_) => None,
        };
        self.is_mirrored() || joint.is_some_and(|joint| joint.mirrored)
    }
}

impl Design {
    /// A design of one part, its core.
    ///
    /// # Errors
    ///
    /// A [`Refusal`] when a parameter is not possible.
    pub fn core(rules: &RuleSet, kind: &str, given: &[(String, Value)]) -> Result<Self, Refusal> {
        let values = BodyValues::new();
        let (params, made) = change::params(&WithValues { rules, values: &values }, kind, given, 0)?;
        let part = Part {
            kind: kind.to_owned(),
            params,
            made,
            turn: 0.0,
            held_by: None,
            holding: 0,
            image_of: None,
            image: 0,
            alone: false,
            step: 0,
            pose: Isometry3::identity(),
        };
        let images = symmetry::images(rules.symmetry);
        if !images.iter().all(|image| image.keeps(&part)) {
            return Err(Refusal::Asymmetric(kind.to_owned()));
        }
        Ok(Self { parts: IndexMap::from([(CORE, part)]), placed: BTreeMap::new(), values })
    }

    /// What the fields of its parts can read, beside their own parameters.
    #[must_use]
    pub fn known<'a>(&'a self, rules: &'a RuleSet) -> WithValues<'a> {
        WithValues { rules, values: &self.values }
    }

    /// A part and all its images, the original first.
    #[must_use]
    pub fn orbit(&self, id: PartId) -> Vec<PartId> {
        let original = self.parts.get(&id).and_then(|p| p.image_of).unwrap_or(id);
        let mut orbit: Vec<(u8, PartId)> = self
            .parts
            .iter()
            .filter(|(_, p)| p.image_of == Some(original))
            .map(|(i, p)| (p.image, *i))
            .collect();
        orbit.sort_unstable();
        std::iter::once(original).chain(orbit.into_iter().map(|(_, i)| i)).collect()
    }

    /// The image of a part under the isometry number `k`; the part itself where it is its own image.
    #[must_use]
    pub fn image(&self, rules: &RuleSet, id: PartId, k: usize) -> PartId {
        let orbit = self.orbit(id);
        let order = symmetry::images(rules.symmetry).len() + 1;
        let mine = self.parts.get(&id).map_or(0, |p| p.image as usize);
        if orbit.len() < order { id } else { orbit.get((mine + k) % order).copied().unwrap_or(id) }
    }

    /// The first image of a part; the part itself where it is its own image or there is no symmetry.
    #[must_use]
    pub fn twin(&self, id: PartId) -> PartId {
        self.orbit(id).into_iter().find(|other| *other != id).unwrap_or(id)
    }

    /// How many joints lie between each part and the core.
    #[must_use]
    pub fn depths(&self) -> BTreeMap<PartId, usize> {
        let mut depths = BTreeMap::new();
        for &id in self.parts.keys() {
            let mut way = Vec::new();
            let mut at = id;
            // Up to the core, or to a part whose depth is known.
            while let Some((holder, _)) =
                self.parts.get(&at).filter(|_| !depths.contains_key(&at)).and_then(|p| p.held_by)
            {
                way.push(at);
                at = holder;
            }
            let first = *depths.entry(at).or_insert(0_usize);
            depths.extend(way.into_iter().rev().zip(first + 1..));
        }
        depths
    }

    /// The mass of a part, kg.
    #[must_use]
    pub fn mass(&self, id: PartId) -> Option<f64> {
        let part = self.parts.get(&id)?;
        Some(match part.made.as_ref() {
            Made::Block(block) => block.mass,
            Made::Actuator(actuator) => actuator.mass * port::segments(part) as f64,
            Made::Cell(cell) => cell.mass,
        })
    }

    /// Whether a port holds nothing and is not the one that the part is held by.
    #[must_use]
    pub fn is_free(&self, id: PartId, port: u8) -> bool {
        let Some(part) = self.parts.get(&id) else { return false };
        let own = part.held_by.map(|_| part.holding);
        (port as usize) < port::count(part)
            && own != Some(port)
            && !self.parts.values().any(|p| p.held_by == Some((id, port)))
    }

    /// All ports that are not free, as [`Design::is_free`] says of each.
    #[must_use]
    pub fn taken_ports(&self) -> BTreeSet<(PartId, u8)> {
        let held = self.parts.iter().filter_map(|(id, part)| Some((*id, part)).zip(part.held_by));
        held.flat_map(|((id, part), holder)| [(id, part.holding), holder]).collect()
    }

    /// How many ports a part has.
    #[must_use]
    pub fn port_count(&self, id: PartId) -> u8 {
        self.parts.get(&id).map_or(0, |part| port::count(part) as u8)
    }

    /// Whether a part belongs to a group.
    #[must_use]
    pub fn belongs(&self, rules: &RuleSet, id: PartId, group: &Group) -> bool {
        self.parts.get(&id).is_some_and(|part| match group {
            Group::Part => !lattice::is_cell(id),
            Group::Block => !lattice::is_cell(id) && !rules.is_actuator(&part.kind),
            Group::Cell => lattice::is_cell(id),
            Group::Actuator => rules.is_actuator(&part.kind),
            Group::Kind(kind) => part.kind == *kind,
        })
    }

    /// How many actuators there are; cells that are alike are one.
    #[must_use]
    pub fn actuators(&self, rules: &RuleSet) -> usize {
        let driven = self.parts.values().filter(|part| rules.is_driven(&part.kind));
        if rules.lattice.is_none() {
            return driven.count();
        }
        let mut kinds: Vec<&IndexMap<String, Value>> = Vec::new();
        for cell in driven {
            if !kinds.contains(&&cell.params) {
                kinds.push(&cell.params);
            }
        }
        kinds.len()
    }

    /// The parts joined to a part: its holder and those that it holds.
    #[must_use]
    pub fn neighbours(&self, id: PartId) -> Vec<PartId> {
        let holder = self.parts.get(&id).and_then(|p| p.held_by).map(|(holder, _)| holder);
        let held =
            self.parts.iter().filter(|(_, p)| p.held_by.is_some_and(|(h, _)| h == id)).map(|(i, _)| *i);
        holder.into_iter().chain(held).collect()
    }

    /// The parts that a part holds, directly or through others, in the order in which they were made.
    #[must_use]
    pub fn hanging_on(&self, id: PartId) -> Vec<PartId> {
        let mut found = BTreeSet::from([id]);
        // A part that was inserted is younger than what it holds.
        loop {
            let known = found.len();
            let held = |p: &Part| p.held_by.is_some_and(|(holder, _)| found.contains(&holder));
            let more: Vec<PartId> = self.parts.iter().filter(|(_, p)| held(p)).map(|(i, _)| *i).collect();
            found.extend(more);
            if found.len() == known {
                break;
            }
        }
        self.parts.keys().copied().filter(|other| *other != id && found.contains(other)).collect()
    }

    /// Whether every part is joined to the core.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.parts.values().enumerate().all(|(i, p)| match p.held_by {
            Some((holder, _)) => self.parts.contains_key(&holder),
            None => i == 0,
        })
    }

    /// Whether no two parts overlap; touching is allowed.
    #[must_use]
    pub fn no_overlap(&self, rules: &RuleSet) -> bool {
        overlap::first(self, rules).is_none()
    }

    /// Two parts that overlap, if any do.
    #[must_use]
    pub fn overlapping(&self, rules: &RuleSet) -> Option<(PartId, PartId)> {
        overlap::first(self, rules)
    }

    /// The parts with their places and what holds them, as texts in order: of two designs of
    /// which one is contained in the other, the one has all the pieces of the other.
    #[must_use]
    pub fn pieces(&self) -> Vec<String> {
        canonical::pieces(self)
    }

    /// Whether a hash is that of this body, as this version or an earlier one makes it.
    #[must_use]
    pub fn is_body(&self, hash: &str) -> bool {
        self.canonical_hash() == hash || canonical::hash(self, canonical::Order::Declared) == hash
    }

    /// A hash of what can be done to this design: bodies that look alike differ in it where their ports have changed places.
    #[must_use]
    pub fn turned_hash(&self) -> String {
        canonical::hash(self, canonical::Order::Turned)
    }

    /// A hash of what a drive can read of this design: bodies that look alike differ in it where another part is the original, or where a
    /// part is turned otherwise or hangs on another port.
    #[must_use]
    pub fn driven_hash(&self) -> String {
        canonical::hash(self, canonical::Order::Driven)
    }

    /// A hash of the body that this design is: parts, places and joints, whatever
    /// the order in which they came to be. 64 hexadecimal digits.
    #[must_use]
    pub fn canonical_hash(&self) -> String {
        canonical::hash(self, canonical::Order::ByName)
    }
}
