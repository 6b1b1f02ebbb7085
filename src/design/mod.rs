//! The design: what a rule set makes and a model simulates.
//!
//! A [`Design`] is a tree of parts with the history of steps that made it. It is
//! the contract between derivation and simulation: any rule set makes designs,
//! any model lowers their [`assembly::Assembly`].

pub mod assembly;
mod body;
mod canonical;
mod overlap;
mod port;
mod symmetry;

use std::collections::BTreeMap;

use grammar_lang::eval::Value;
use grammar_lang::ir::{Group, RuleSet};
use indexmap::IndexMap;
use nalgebra::Isometry3;

pub use body::Body;
pub use port::{PortFrame, ports};

/// Names a part for as long as the step that made it exists: the step's number
/// in the upper bits, the part's number within the step in the lower eight.
pub type PartId = u64;

/// A part of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The declared kind.
    pub kind: String,
    /// Parameters of an actuator.
    pub params: IndexMap<String, Value>,
    /// Rotation about the port that holds it, rad; an image has that of its original,
    /// measured in its own mirrored frame.
    pub turn: f64,
    /// The part and its port that hold this one; none for the core.
    pub held_by: Option<(PartId, u8)>,
    /// The part whose mirror image this is.
    pub image_of: Option<PartId>,
    /// The step that made it; 0 for the initial design.
    pub step: u64,
    /// Pose of its frame in the world: the centre of a block, the base of an actuator.
    pub pose: Isometry3<f64>,
}

/// Why a change of a design is not possible.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// The part, port or step that is meant does not exist (any more).
    Gone,
    /// Something is attached to the port already.
    PortTaken,
    /// The change would break the symmetry.
    Asymmetric,
    /// A parameter lies outside its domain or has no value.
    BadParameter(String),
}

/// A tree of parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Design {
    /// The parts in the order of their making; the first is the core.
    pub parts: IndexMap<PartId, Part>,
    /// What the initial design calls its parts.
    pub placed: BTreeMap<String, PartId>,
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
}

impl Design {
    /// The initial design of a rule set.
    #[must_use]
    pub fn begin(rules: &RuleSet) -> Self {
        let mut design = Self::default();
        for (i, placed) in rules.begin.iter().enumerate() {
            let id = i as PartId;
            let part = Part {
                kind: placed.kind.clone(),
                params: IndexMap::new(),
                turn: 0.0,
                held_by: None,
                image_of: None,
                step: 0,
                pose: Isometry3::identity(),
            };
            design.parts.insert(id, part);
            design.placed.insert(placed.name.clone(), id);
        }
        design
    }

    /// The image of a part; the part itself where it is its own image or there is no symmetry.
    #[must_use]
    pub fn twin(&self, id: PartId) -> PartId {
        match self.parts.get(&id).and_then(|p| p.image_of) {
            Some(original) => original,
            None => self.parts.iter().find(|(_, p)| p.image_of == Some(id)).map_or(id, |(twin, _)| *twin),
        }
    }

    /// Whether a port holds nothing and is not the one that the part is held by.
    #[must_use]
    pub fn is_free(&self, rules: &RuleSet, id: PartId, port: u8) -> bool {
        let Some(part) = self.parts.get(&id) else { return false };
        let own = part.held_by.map(|_| port::holding(rules, part));
        own != Some(port) && !self.parts.values().any(|p| p.held_by == Some((id, port)))
    }

    /// The free ports of a part.
    #[must_use]
    pub fn free_ports(&self, rules: &RuleSet, id: PartId) -> Vec<u8> {
        let Some(part) = self.parts.get(&id) else { return Vec::new() };
        (0..ports(rules, part).len() as u8).filter(|p| self.is_free(rules, id, *p)).collect()
    }

    /// Whether a part belongs to a group.
    #[must_use]
    pub fn belongs(&self, rules: &RuleSet, id: PartId, group: &Group) -> bool {
        self.parts.get(&id).is_some_and(|part| match group {
            Group::Part => true,
            Group::Block => !rules.is_actuator(&part.kind),
            Group::Actuator => rules.is_actuator(&part.kind),
            Group::Kind(kind) => part.kind == *kind,
        })
    }

    /// The parts joined to a part: its holder and those that it holds.
    #[must_use]
    pub fn neighbours(&self, id: PartId) -> Vec<PartId> {
        let holder = self.parts.get(&id).and_then(|p| p.held_by).map(|(holder, _)| holder);
        let held =
            self.parts.iter().filter(|(_, p)| p.held_by.is_some_and(|(h, _)| h == id)).map(|(i, _)| *i);
        holder.into_iter().chain(held).collect()
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
        overlap::none(self, rules)
    }

    /// A hash of the body that this design is: parts, places and joints, whatever
    /// the order in which they came to be. 64 hexadecimal digits.
    #[must_use]
    pub fn canonical_hash(&self, rules: &RuleSet) -> String {
        canonical::hash(self, rules)
    }

    /// Attaches a part and its mirror image; `step` numbers the step that does.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn attach(&mut self, rules: &RuleSet, attachment: &Attachment, step: u64) -> Result<(), Refusal> {
        if !self.parts.contains_key(&attachment.part) {
            return Err(Refusal::Gone);
        }
        let mirror = symmetry::mirror(rules.symmetry);
        let image_place = match &mirror {
            Some(mirror) => {
                Some(symmetry::image_port(self, rules, mirror, attachment.part, attachment.port)?)
            }
            None => None,
        };
        let original = self.add(rules, attachment, step, None)?;
        let (Some(mirror), Some((part, port))) = (mirror, image_place) else { return Ok(()) };
        let own_image = self.parts.get(&original).is_some_and(|p| mirror.keeps(rules, p));
        if (part, port) == (attachment.part, attachment.port) {
            // On the mirror plane the application maps onto itself, or cannot be mirrored.
            return if own_image { Ok(()) } else { Err(Refusal::Asymmetric) };
        }
        self.add(rules, &Attachment { part, port, ..attachment.clone() }, step, Some(original))?;
        self.check_symmetry(rules)
    }

    fn add(
        &mut self,
        rules: &RuleSet,
        attachment: &Attachment,
        step: u64,
        image_of: Option<PartId>,
    ) -> Result<PartId, Refusal> {
        if !self.is_free(rules, attachment.part, attachment.port) {
            return Err(Refusal::PortTaken);
        }
        let ordinal = self.parts.keys().filter(|id| **id >> 8 == step).count() as u64;
        let id = step << 8 | ordinal;
        let part = Part {
            kind: attachment.kind.clone(),
            params: params(rules, attachment)?,
            turn: attachment.turn,
            held_by: Some((attachment.part, attachment.port)),
            image_of,
            step,
            pose: Isometry3::identity(),
        };
        self.parts.insert(id, part);
        self.place_all(rules)?;
        Ok(id)
    }

    /// Sets `turn` or a parameter of a part and of its image.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn set(
        &mut self,
        rules: &RuleSet,
        id: PartId,
        attribute: &str,
        value: &Value,
    ) -> Result<(), Refusal> {
        for id in [id, self.twin(id)] {
            let part = self.parts.get_mut(&id).ok_or(Refusal::Gone)?;
            if attribute == "turn" {
                let full = 2.0 * std::f64::consts::PI;
                let turn = value.as_number().ok_or(Refusal::Gone)?;
                let turn = turn - full * libm::floor(turn / full);
                // A whole turn that rounding left just below is none.
                part.turn = if full - turn < 1e-9 { 0.0 } else { turn };
            } else {
                in_domain(rules, &part.kind, attribute, value)?;
                part.params.insert(attribute.to_owned(), value.clone());
            }
        }
        self.place_all(rules)?;
        self.check_symmetry(rules)
    }

    /// Checks that every part without an image is its own image.
    fn check_symmetry(&self, rules: &RuleSet) -> Result<(), Refusal> {
        let Some(mirror) = symmetry::mirror(rules.symmetry) else { return Ok(()) };
        let sound = self.parts.iter().all(|(id, part)| self.twin(*id) != *id || mirror.keeps(rules, part));
        if sound { Ok(()) } else { Err(Refusal::Asymmetric) }
    }

    /// Finds every pose anew and checks that images still are images.
    fn place_all(&mut self, rules: &RuleSet) -> Result<(), Refusal> {
        let mirror = symmetry::mirror(rules.symmetry);
        for i in 0..self.parts.len() {
            let Some((_, part)) = self.parts.get_index(i) else { continue };
            let held = match part.held_by {
                None => Isometry3::identity(),
                Some((holder, port)) => {
                    let holder = self.parts.get(&holder).ok_or(Refusal::Gone)?;
                    port::pose_at(rules, holder, port, part).ok_or(Refusal::Gone)?
                }
            };
            let pose = match (part.image_of, &mirror) {
                (Some(original), Some(mirror)) => {
                    let original = self.parts.get(&original).ok_or(Refusal::Gone)?;
                    let pose = mirror.image(&original.pose);
                    // An image must still sit where it is held.
                    let (have, want) = (port::base(rules, part, &pose), port::base(rules, part, &held));
                    if (have - want).norm() > symmetry::SAME {
                        return Err(Refusal::Asymmetric);
                    }
                    pose
                }
                _ => held,
            };
            if let Some((_, part)) = self.parts.get_index_mut(i) {
                part.pose = pose;
            }
        }
        Ok(())
    }
}

fn in_domain(rules: &RuleSet, kind: &str, name: &str, value: &Value) -> Result<(), Refusal> {
    let declared = rules.actuators.get(kind).and_then(|a| a.params.get(name));
    let declared = declared.ok_or_else(|| Refusal::BadParameter(name.to_owned()))?;
    match (declared.domain, value) {
        (Some((low, high)), Value::Number(x)) if *x < low || *x > high => {
            Err(Refusal::BadParameter(name.to_owned()))
        }
        _ => Ok(()),
    }
}

/// The parameters of a new part: those given, and defaults for the others.
fn params(rules: &RuleSet, attachment: &Attachment) -> Result<IndexMap<String, Value>, Refusal> {
    let mut out = IndexMap::new();
    let Some(actuator) = rules.actuators.get(&attachment.kind) else { return Ok(out) };
    for (name, declared) in &actuator.params {
        let given = attachment.params.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone());
        let value = match (given, &declared.default) {
            (Some(value), _) => value,
            (None, Some(default)) => grammar_lang::eval::evaluate(default, rules, &mut Vec::new())
                .map_err(|_| Refusal::BadParameter(name.clone()))?,
            (None, None) => return Err(Refusal::BadParameter(name.clone())),
        };
        in_domain(rules, &attachment.kind, name, &value)?;
        out.insert(name.clone(), value);
    }
    Ok(out)
}
