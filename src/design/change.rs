//! Changes of a design: attaching, setting, removing, replacing, with all images.

use std::sync::Arc;

use grammar_lang::eval::{KindValue, Made, Unmade, Value, WithValues};
use grammar_lang::ir::{Kind, RuleSet, Settable, Ty};
use grammar_lang::units;
use indexmap::IndexMap;
use nalgebra::Isometry3;

use super::port::{self, ends, ports};
use super::{Attachment, Design, Part, PartId, Refusal, first_of, step_of, symmetry};

impl Design {
    /// Attaches a part and its images; `step` numbers the step that does. Gives the part.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn attach(&mut self, rules: &RuleSet, attachment: &Attachment, step: u64) -> Result<PartId, Refusal> {
        let place = (attachment.part, attachment.port);
        let holder = self.parts.get(&place.0).ok_or(Refusal::Gone)?;
        if attachment.alone || holder.alone {
            let alone = Attachment { alone: true, ..attachment.clone() };
            return self.add(rules, &alone, step, None);
        }
        let images = symmetry::images(rules.symmetry);
        let mut places = Vec::with_capacity(images.len());
        for (k, image) in images.iter().enumerate() {
            places.push(symmetry::image_port(self, rules, k + 1, image, place.0, place.1)?);
        }
        let original = self.add(rules, attachment, step, None)?;
        if places.contains(&place) {
            // Where the symmetry leaves the place alone, the application is its own
            // image, or it cannot have one.
            let all_here = places.iter().all(|p| *p == place);
            if all_here && self.parts.get(&original).is_some_and(|p| images.iter().all(|i| i.keeps(p))) {
                return Ok(original);
            }
            let mirrored = all_here && images.iter().all(symmetry::Image::reflects);
            return Err(if mirrored && rules.actuators.contains_key(&attachment.kind) {
                Refusal::Askew(attachment.kind.clone())
            } else {
                Refusal::Asymmetric(attachment.kind.clone())
            });
        }
        for (k, (part, port)) in places.into_iter().enumerate() {
            let image = Attachment { part, port, ..attachment.clone() };
            self.add(rules, &image, step, Some((original, k + 1)))?;
        }
        self.check_symmetry(rules)?;
        Ok(original)
    }

    fn add(
        &mut self,
        rules: &RuleSet,
        attachment: &Attachment,
        step: u64,
        image_of: Option<(PartId, usize)>,
    ) -> Result<PartId, Refusal> {
        if !self.is_free(attachment.part, attachment.port) {
            return Err(self.taken(attachment.part, attachment.port));
        }
        let id = self.next_id(step)?;
        let image = image_of.map_or(0, |(_, k)| k as u8);
        let (params, made) = params(&self.known(rules), &attachment.kind, &attachment.params, image)?;
        let mut part = Part {
            kind: attachment.kind.clone(),
            params,
            made,
            turn: normal_turn(attachment.turn),
            held_by: Some((attachment.part, attachment.port)),
            holding: ends(rules, &attachment.kind).0,
            image_of: image_of.map(|(original, _)| original),
            image,
            alone: attachment.alone,
            step,
            pose: Isometry3::identity(),
        };
        if let Some(by) = &attachment.by {
            let found = ports(&part).iter().position(|p| p.name == *by);
            part.holding = found.ok_or_else(|| Refusal::NoPort(by.clone()))? as u8;
        }
        if symmetry::is_reflected(rules, image) {
            part.holding = symmetry::mirrored_port(&part, part.holding);
        }
        let (index, _) = self.parts.insert_full(id, part);
        // The others stay where they are.
        self.find_pose(&symmetry::images(rules.symmetry), index)?;
        Ok(id)
    }

    /// The refusal of a port that holds something already.
    fn taken(&self, part: PartId, port: u8) -> Refusal {
        let Some(part) = self.parts.get(&part) else { return Refusal::Gone };
        let port = ports(part).into_iter().nth(port as usize).map_or(String::new(), |p| p.name);
        Refusal::PortTaken { kind: part.kind.clone(), port }
    }

    fn next_id(&self, step: u64) -> Result<PartId, Refusal> {
        let last = self.parts.keys().filter(|id| step_of(**id) == step).max();
        let next = last.map_or(first_of(step), |id| PartId::from_number(id.number() + 1));
        if step_of(next) == step { Ok(next) } else { Err(Refusal::TooMany) }
    }

    /// Sets `turn` or a parameter of a part and of its images.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn set(
        &mut self,
        rules: &RuleSet,
        id: PartId,
        attribute: &Settable,
        value: &Value,
    ) -> Result<(), Refusal> {
        if !self.parts.contains_key(&id) {
            return Err(Refusal::Gone);
        }
        for id in self.orbit(id) {
            let part = self.parts.get_mut(&id).ok_or(Refusal::Gone)?;
            match attribute {
                // What hangs on nothing is turned about no port.
                Settable::Turn if part.held_by.is_none() => {}
                Settable::Turn => part.turn = normal_turn(value.as_number().ok_or(Refusal::Gone)?),
                Settable::Param(name) => {
                    in_domain(rules, &part.kind, name, value)?;
                    // It is what it was: rules that are carried out always set most parts to what they are.
                    if part.params.get(name) == Some(value) {
                        continue;
                    }
                    part.params.insert(name.clone(), value.clone());
                    let known = WithValues { rules, values: &self.values };
                    part.made = made(&known, &part.kind, &part.params, part.image)?;
                }
            }
        }
        self.place_all(rules)?;
        self.check_symmetry(rules)
    }

    /// Sets what a parameter of the grammar is in this body, and works out again what its parts are.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn set_of_body(&mut self, rules: &RuleSet, name: &str, value: &Value) -> Result<(), Refusal> {
        let declared = rules.params.get(name).ok_or(Refusal::Gone)?;
        is_within(name, (&declared.ty, declared.domain), value)?;
        if *value == declared.in_force() {
            self.values.remove(name);
        } else {
            self.values.insert(name.to_owned(), value.clone());
        }
        self.remake(rules).map_err(Refusal::NoSuchPart)?;
        // Cells stay where they are.
        if rules.lattice.is_some() {
            return Ok(());
        }
        self.place_all(rules)?;
        self.check_symmetry(rules)
    }

    /// Takes away a part, its images, and all that hangs on them.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]: parts of the initial design stay.
    pub fn remove(&mut self, id: PartId) -> Result<(), Refusal> {
        if !self.parts.contains_key(&id) {
            return Err(Refusal::Gone);
        }
        let mut going = self.orbit(id);
        let mut next = 0;
        while let Some(id) = going.get(next).copied() {
            next += 1;
            let held = self.parts.iter().filter(|(_, p)| p.held_by.is_some_and(|(h, _)| h == id));
            going.extend(held.map(|(i, _)| *i));
        }
        for id in going {
            if self.parts.get(&id).is_some_and(|p| p.step == 0) {
                return Err(Refusal::Fixed);
            }
            self.parts.shift_remove(&id);
        }
        Ok(())
    }

    /// Puts a part of a kind in the place of another, and of each of its images.
    /// What hung on the old one hangs on the new one: at the far end what was at
    /// the far end, elsewhere at the port of the same name. `between` names the
    /// neighbours at the near and the far end. Gives the new part.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn replace(
        &mut self,
        rules: &RuleSet,
        id: PartId,
        with: &KindValue,
        between: Option<(PartId, PartId)>,
        step: u64,
    ) -> Result<PartId, Refusal> {
        let original = self.parts.get(&id).ok_or(Refusal::Gone)?.image_of.unwrap_or(id);
        let mine = self.parts.get(&id).map_or(0, |p| p.image as usize);
        let order = symmetry::images(rules.symmetry).len() + 1;
        let mut made: Option<PartId> = None;
        for old in self.orbit(original) {
            let part = self.parts.get(&old).ok_or(Refusal::Gone)?;
            if part.step == 0 {
                return Err(Refusal::Fixed);
            }
            // The neighbours were named for one of the images: the others have their images.
            let shift = (part.image as usize + order - mine % order) % order;
            let between = between.map(|(a, b)| (self.image(rules, a, shift), self.image(rules, b, shift)));
            let id = self.replace_one(rules, old, with, between, step)?;
            if let Some(part) = self.parts.get_mut(&id) {
                part.image_of = made;
            }
            made = made.or(Some(id));
        }
        self.place_all(rules)?;
        self.check_symmetry(rules)?;
        made.ok_or(Refusal::Gone)
    }

    fn replace_one(
        &mut self,
        rules: &RuleSet,
        old: PartId,
        with: &KindValue,
        between: Option<(PartId, PartId)>,
        step: u64,
    ) -> Result<PartId, Refusal> {
        let index = self.parts.get_index_of(&old).ok_or(Refusal::Gone)?;
        let id = self.next_id(step)?;
        let (near, far) = ends(rules, &with.name);
        let before = self.parts.shift_remove(&old).ok_or(Refusal::Gone)?;
        let holder = before.held_by.map(|(h, _)| h);
        let (params, made) = params(&self.known(rules), &with.name, &with.params, before.image)?;
        let mut part = Part { kind: with.name.clone(), params, made, holding: near, step, ..before.clone() };
        if let Some((a, b)) = between
            && holder != Some(a)
        {
            // The side that holds the core stays: the new part is held by its far end.
            if holder != Some(b) {
                return Err(Refusal::NotJoined);
            }
            part.holding = far.ok_or_else(|| Refusal::NoPort("front".to_owned()))?;
        }
        if symmetry::is_reflected(rules, part.image) {
            part.holding = symmetry::mirrored_port(&part, part.holding);
        }
        let (old_ports, new_ports) = (ports(&before), ports(&part));
        let mut taken = vec![part.holding];
        let children: Vec<(PartId, u8)> = self
            .parts
            .iter()
            .filter_map(|(i, p)| p.held_by.filter(|(h, _)| *h == old).map(|(_, port)| (*i, port)))
            .collect();
        for (child, port) in children {
            let name = old_ports.get(port as usize).map_or("", |p| p.name.as_str());
            let to = match between {
                Some((a, _)) if a == child => Some(near),
                Some((_, b)) if b == child => far,
                _ if matches!(name, "front" | "tip") => far,
                _ if matches!(name, "back" | "base") => Some(near),
                _ => new_ports.iter().position(|p| p.name == name).map(|p| p as u8),
            };
            let to = to.ok_or_else(|| Refusal::NoPort(name.to_owned()))?;
            if taken.contains(&to) {
                let port = new_ports.get(to as usize).map_or(String::new(), |p| p.name.clone());
                return Err(Refusal::PortTaken { kind: with.name.clone(), port });
            }
            taken.push(to);
            if let Some(child) = self.parts.get_mut(&child) {
                child.held_by = Some((id, to));
            }
        }
        self.parts.shift_insert(index, id, part);
        Ok(id)
    }

    /// Checks that every part without images is its own image.
    fn check_symmetry(&self, rules: &RuleSet) -> Result<(), Refusal> {
        let images = symmetry::images(rules.symmetry);
        if images.is_empty() {
            return Ok(());
        }
        let is_sound = |(id, part): &(&PartId, &Part)| {
            part.alone || self.orbit(**id).len() > 1 || images.iter().all(|image| image.keeps(part))
        };
        match self.parts.iter().find(|part| !is_sound(part)) {
            Some((_, part)) => Err(Refusal::Asymmetric(part.kind.clone())),
            None => Ok(()),
        }
    }

    /// Finds every pose anew and checks that images still are images.
    pub(super) fn place_all(&mut self, rules: &RuleSet) -> Result<(), Refusal> {
        let images = symmetry::images(rules.symmetry);
        (0..self.parts.len()).try_for_each(|index| self.find_pose(&images, index))
    }

    /// Finds the pose of a part, by its place among all, whose holder and original have theirs.
    fn find_pose(&mut self, images: &[symmetry::Image], index: usize) -> Result<(), Refusal> {
        let Some((_, part)) = self.parts.get_index(index) else { return Ok(()) };
        let held = match part.held_by {
            None => Isometry3::identity(),
            Some((holder, port)) => {
                let holder = self.parts.get(&holder).ok_or(Refusal::Gone)?;
                port::pose_at(holder, port, part).ok_or(Refusal::Gone)?
            }
        };
        let image = (part.image as usize).checked_sub(1).and_then(|k| images.get(k));
        let pose = match (part.image_of, image) {
            (Some(original), Some(image)) => {
                let original = self.parts.get(&original).ok_or(Refusal::Gone)?;
                let pose = image.pose(&original.pose);
                // An image must still sit where it is held.
                let (have, want) = (port::base(part, &pose), port::base(part, &held));
                if (have - want).norm() > symmetry::SAME {
                    return Err(Refusal::Asymmetric(part.kind.clone()));
                }
                pose
            }
            _ => held,
        };
        if let Some((_, part)) = self.parts.get_index_mut(index) {
            part.pose = pose;
        }
        Ok(())
    }
}

/// An angle within one turn.
fn normal_turn(turn: f64) -> f64 {
    let full = 2.0 * std::f64::consts::PI;
    let turn = turn - full * libm::floor(turn / full);
    // A whole turn that rounding left just below is none.
    if full - turn < 1e-9 { 0.0 } else { turn }
}

pub(super) fn in_domain(rules: &RuleSet, kind: &str, name: &str, value: &Value) -> Result<(), Refusal> {
    let declared = rules.params_of(kind).and_then(|params| params.get(name));
    let lacks =
        || Refusal::BadParameter { name: name.to_owned(), why: format!("`{kind}` has no such parameter") };
    let declared = declared.ok_or_else(lacks)?;
    is_within(name, (&declared.ty, declared.domain), value)
}

/// Whether a parameter of this type and domain can have a value.
fn is_within(name: &str, (ty, domain): (&Ty, Option<(f64, f64)>), value: &Value) -> Result<(), Refusal> {
    let bad = |why: String| Refusal::BadParameter { name: name.to_owned(), why };
    let shown = |x: f64| units::shown(x, ty.dimension().unwrap_or_default());
    match (domain, value) {
        (Some((low, high)), Value::Number(x)) if !grammar_lang::eval::order::is_within(low, *x, high) => {
            Err(bad(format!("{} is not within {} .. {}", shown(*x), shown(low), shown(high))))
        }
        (_, Value::Number(x)) if x.abs() > units::LARGEST => Err(bad(format!("{} is too large", shown(*x)))),
        _ => Ok(()),
    }
}

impl Design {
    /// Works out again what each part is, by rules that say otherwise only what drives it.
    ///
    /// # Errors
    ///
    /// A part that these rules leave without a value for one of its fields.
    pub fn remake(&mut self, rules: &RuleSet) -> Result<(), Unmade> {
        if let Some(lattice) = &rules.lattice {
            return self.remake_cells(rules, lattice);
        }
        let known = WithValues { rules, values: &self.values };
        for part in self.parts.values_mut() {
            let Some(kind) = rules.kind(&part.kind) else { continue };
            part.made = own(&known, kind, &part.params, part.image)?;
        }
        Ok(())
    }
}

impl Design {
    /// Lets actuators move as far and as fast as other rules say. `there` is what the steps of this design make under them: parameters
    /// have the values that they have there. Without it, they have those of this design, and one that is not known here is as these rules
    /// give it.
    ///
    /// # Errors
    ///
    /// An actuator that they leave without a range or a speed.
    pub fn move_as(&mut self, rules: &RuleSet, there: Option<&Design>) -> Result<(), Unmade> {
        let values = there.map(|there| there.values.clone()).unwrap_or_default();
        let known = WithValues { rules, values: &values };
        for (id, part) in &mut self.parts {
            let (Made::Actuator(own), Some(kind)) = (part.made.as_ref(), rules.actuators.get(&part.kind))
            else {
                continue;
            };
            let mut params = IndexMap::new();
            for (name, declared) in &kind.params {
                let usual = || {
                    let default = declared.default.as_ref()?;
                    grammar_lang::eval::evaluate(default, &known, &mut Vec::new()).ok()
                };
                let same =
                    there.and_then(|there| there.parts.get(id)).filter(|other| other.kind == part.kind);
                let given = same.map_or(&part.params, |other| &other.params);
                if let Some(value) = given.get(name).cloned().or_else(usual) {
                    params.insert(name.clone(), value);
                }
            }
            let Made::Actuator(other) = Made::of(Kind::Actuator(kind), &known, &params)? else { continue };
            let mut made = own.clone();
            made.joint.range = made.joint.range.and(other.joint.range).or(made.joint.range);
            if let (Some(motor), Some(other)) = (&mut made.motor, other.motor) {
                motor.speed = other.speed;
                motor.relaxing_speed = other.relaxing_speed;
            }
            part.made = Arc::new(Made::Actuator(made));
        }
        Ok(())
    }
}

/// The parameters of a part, and what it is with them.
type Own = (IndexMap<String, Value>, Arc<Made>);

/// What a part of a kind is with these parameters, as this image of its original.
fn own(
    known: &WithValues<'_>,
    kind: Kind<'_>,
    params: &IndexMap<String, Value>,
    image: u8,
) -> Result<Arc<Made>, Unmade> {
    let made = Made::of(kind, known, params)?;
    Ok(Arc::new(if symmetry::is_reflected(known.rules, image) { made.in_mirror() } else { made }))
}

/// The same of a kind by its name.
fn made(
    known: &WithValues<'_>,
    kind: &str,
    params: &IndexMap<String, Value>,
    image: u8,
) -> Result<Arc<Made>, Refusal> {
    let kind = known.rules.kind(kind).ok_or(Refusal::Gone)?;
    own(known, kind, params, image).map_err(Refusal::NoSuchPart)
}

/// The parameters of a new part, those given and defaults for the others, and what it is with them, as this image of its original.
pub(super) fn params(
    known: &WithValues<'_>,
    kind: &str,
    given: &[(String, Value)],
    image: u8,
) -> Result<Own, Refusal> {
    let mut out = IndexMap::new();
    let params = known.rules.params_of(kind).ok_or(Refusal::Gone)?;
    for (name, declared) in params {
        let given = given.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone());
        let value = match (given, &declared.default) {
            (Some(value), _) => value,
            (None, Some(default)) => grammar_lang::eval::evaluate(default, known, &mut Vec::new())
                .map_err(|error| Refusal::BadParameter { name: name.clone(), why: error.reason })?,
            (None, None) => {
                let why = "it has no value".to_owned();
                return Err(Refusal::BadParameter { name: name.clone(), why });
            }
        };
        in_domain(known.rules, kind, name, &value)?;
        out.insert(name.clone(), value);
    }
    let made = made(known, kind, &out, image)?;
    Ok((out, made))
}
