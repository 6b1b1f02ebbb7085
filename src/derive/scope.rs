//! What the expressions of the derivation can read: the design so far.

use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{Domain, Made, Reference, Scope, Value};
use grammar_lang::ir::{
    Attribute, CellAttribute, DesignFunction, DesignWord, Group, JointAttribute, JointKind, KindField,
    Lattice, PartAttribute, PortAttribute, RuleSet, SearchWord, StepAttribute, Symmetry, Word,
};

use super::Derivation;
use crate::design::{Design, PartId, lattice, ports};

/// The design so far, and the temperature where a weight may read it.
pub struct DesignScope<'a> {
    rules: &'a RuleSet,
    derivation: &'a Derivation,
    temperature: Option<f64>,
    /// The design with what the rule has made so far.
    made: Option<&'a Design>,
    /// How many operations all that is evaluated may still take together.
    left: Option<&'a AtomicU64>,
    /// How deep each part is, once it is asked for: before the step, and in what the rule has made.
    depths: [OnceLock<BTreeMap<PartId, usize>>; 2],
}

impl<'a> DesignScope<'a> {
    /// Sees a design.
    #[must_use]
    pub fn new(rules: &'a RuleSet, derivation: &'a Derivation) -> Self {
        Self { rules, derivation, temperature: None, made: None, left: None, depths: Default::default() }
    }

    /// Sees the temperature, too.
    #[must_use]
    pub fn at_temperature(mut self, temperature: f64) -> Self {
        self.temperature = Some(temperature);
        self
    }

    /// Sees the parts, too, that the effects of a rule have made so far.
    #[must_use]
    pub fn with_made(mut self, made: &'a Design) -> Self {
        self.made = Some(made);
        self
    }

    /// With so many operations for all that is evaluated together.
    pub(super) fn within(mut self, left: &'a AtomicU64) -> Self {
        self.left = Some(left);
        self
    }

    pub(super) fn rules(&self) -> &'a RuleSet {
        self.rules
    }

    /// The design before the step.
    pub(super) fn design(&self) -> &Design {
        &self.derivation.design
    }

    /// The design that knows a part: that before the rule, or else that with what the rule made.
    fn design_of(&self, id: PartId) -> &Design {
        match self.made {
            Some(made) if !self.design().parts.contains_key(&id) => made,
            _ => self.design(),
        }
    }

    fn port_attribute(&self, id: PartId, port: u8, attribute: PortAttribute) -> Option<Value> {
        let design = self.design_of(id);
        Some(match attribute {
            PortAttribute::Part => reference(Reference::Part(id)),
            PortAttribute::Free => Value::Bool(design.is_free(id, port)),
            PortAttribute::Index => {
                let frames = ports(design.parts.get(&id)?);
                Value::Number(frames.get(port as usize)?.number)
            }
            PortAttribute::Place => Value::Vector(design.attached().place_of_port(id, port)?),
            PortAttribute::Facing => Value::Vector(design.attached().facing_of_port(id, port)?),
            PortAttribute::PlaceAtRest => Value::Vector(design.at_rest(self.rules).place_of_port(id, port)?),
            PortAttribute::FacingAtRest => {
                Value::Vector(design.at_rest(self.rules).facing_of_port(id, port)?)
            }
        })
    }

    /// What the kind of a part says of it.
    fn kind_field(&self, id: PartId, field: KindField) -> Option<Value> {
        let design = self.design_of(id);
        let (friction, joint, motor) = match design.parts.get(&id)?.made.as_ref() {
            Made::Block(block) => (block.friction, block.joint.as_ref(), None),
            Made::Actuator(row) => (row.friction, Some(&row.joint), row.motor.as_ref()),
            Made::Cell(cell) => {
                return match field {
                    KindField::Friction => Some(Value::Number(cell.friction)),
                    KindField::Stiffness => Some(Value::Number(cell.stiffness)),
                    KindField::Damping => Some(Value::Number(cell.damping)),
                    KindField::Torque | KindField::Effort => None,
                };
            }
        };
        let springs = || joint.filter(|joint| joint.kind != JointKind::Spin);
        let strength = || {
            let kind = joint?.kind;
            motor.filter(|_| kind.effort_field() == field.text()).map(|motor| motor.effort)
        };
        Some(Value::Number(match field {
            KindField::Friction => friction,
            KindField::Stiffness => springs()?.stiffness,
            KindField::Damping => joint?.damping,
            KindField::Torque | KindField::Effort => strength()?,
        }))
    }

    fn part_attribute(&self, id: PartId, attribute: PartAttribute) -> Option<Value> {
        let design = self.design_of(id);
        let part = design.parts.get(&id).filter(|_| !lattice::is_cell(id))?;
        // A parameter of that name is what the actuator itself says.
        let own = || part.params.get(attribute.text()).cloned();
        // That of a row, or the one that a part hangs on.
        let joint = |slides: bool| {
            let joint = match part.made.as_ref() {
                Made::Actuator(row) => Some(&row.joint),
                Made::Block(block) => block.joint.as_ref(),
                Made::Cell(_) => None,
            };
            joint.filter(|joint| (joint.kind == JointKind::Slide) == slides)
        };
        let range = |slides: bool| joint(slides)?.range;
        let neutral = |slides: bool| Some(Value::Number(joint(slides)?.neutral));
        let fastest = || match part.made.as_ref() {
            Made::Actuator(row) if row.joint.kind == JointKind::Spin => {
                row.motor.as_ref().map(|motor| motor.speed.most())
            }
            _ => None,
        };
        Some(match attribute {
            PartAttribute::Turn => Value::Number(part.turn),
            PartAttribute::Image => Value::Number(f64::from(part.image)),
            PartAttribute::OwnImage => {
                let mirror = matches!(self.rules.symmetry, Symmetry::Mirror(_));
                Value::Bool(mirror && !part.alone && part.image == 0 && design.twin(id) == id)
            }
            PartAttribute::Depth => {
                let known = &self.depths[usize::from(!std::ptr::eq(design, self.design()))];
                Value::Number(*known.get_or_init(|| design.depths()).get(&id)? as f64)
            }
            PartAttribute::Mass => Value::Number(design.mass(id)?),
            // The core holds itself.
            PartAttribute::Holder => {
                reference(Reference::Part(part.held_by.map_or(id, |(holder, _)| holder)))
            }
            PartAttribute::Port => {
                let (holder, port) = part.held_by?;
                reference(Reference::Port(holder, port))
            }
            PartAttribute::Place => Value::Vector(design.attached().place(id)?),
            PartAttribute::Centre => Value::Vector(design.attached().centre(id)?),
            PartAttribute::LeastCorner => Value::Vector(design.corners(self.rules, id)?[0]),
            PartAttribute::GreatestCorner => Value::Vector(design.corners(self.rules, id)?[1]),
            PartAttribute::Facing => Value::Vector(design.attached().axis(id, 0)?),
            PartAttribute::Upward => Value::Vector(design.attached().axis(id, 1)?),
            PartAttribute::Sideways => Value::Vector(design.attached().axis(id, 2)?),
            PartAttribute::PlaceAtRest => Value::Vector(design.at_rest(self.rules).place(id)?),
            PartAttribute::FacingAtRest => Value::Vector(design.at_rest(self.rules).axis(id, 0)?),
            PartAttribute::UpwardAtRest => Value::Vector(design.at_rest(self.rules).axis(id, 1)?),
            PartAttribute::SidewaysAtRest => Value::Vector(design.at_rest(self.rules).axis(id, 2)?),
            PartAttribute::CentreAtRest => Value::Vector(design.at_rest(self.rules).centre(id)?),
            PartAttribute::LowestPoint => Value::Number(design.lowest_point(self.rules, id)?),
            PartAttribute::Twin => reference(Reference::Part(design.twin(id))),
            PartAttribute::LeastBend => own().or_else(|| Some(Value::Number(range(false)?.0)))?,
            PartAttribute::GreatestBend => own().or_else(|| Some(Value::Number(range(false)?.1)))?,
            PartAttribute::LeastDistance => own().or_else(|| Some(Value::Number(range(true)?.0)))?,
            PartAttribute::GreatestDistance => own().or_else(|| Some(Value::Number(range(true)?.1)))?,
            PartAttribute::NeutralBend => own().or_else(|| neutral(false))?,
            PartAttribute::NeutralDistance => own().or_else(|| neutral(true))?,
            PartAttribute::GreatestSpeed => own().or_else(|| Some(Value::Number(fastest()?)))?,
            // Only a motion has it.
            PartAttribute::Work => own()?,
        })
    }

    /// An attribute of a place.
    fn cell_attribute(&self, id: PartId, attribute: CellAttribute) -> Option<Value> {
        let [x, y, z] = lattice::place_of(id)?;
        Some(match attribute {
            CellAttribute::X => Value::Number(x as f64),
            CellAttribute::Y => Value::Number(y as f64),
            CellAttribute::Z => Value::Number(z as f64),
            CellAttribute::Filled => Value::Bool(self.design().parts.contains_key(&id)),
        })
    }

    fn joint_attribute(&self, held: PartId, attribute: JointAttribute) -> Option<Value> {
        let (holder, port) = self.design_of(held).parts.get(&held)?.held_by?;
        Some(reference(match attribute {
            JointAttribute::Holder => Reference::Part(holder),
            JointAttribute::Held => Reference::Part(held),
            JointAttribute::Port => Reference::Port(holder, port),
        }))
    }

    fn step_attribute(&self, id: u64, attribute: StepAttribute) -> Option<Value> {
        let (i, step) = self.derivation.steps.iter().enumerate().find(|(_, s)| s.id == id)?;
        Some(match attribute {
            StepAttribute::Rule => Value::Text(step.rule.as_str().into()),
            StepAttribute::Number => Value::Number((i + 1) as f64),
        })
    }
}

impl DesignScope<'_> {
    /// The functions that know a lattice.
    fn call_in(&self, lattice: &Lattice, function: DesignFunction, arguments: &[Value]) -> Option<Value> {
        match function {
            DesignFunction::Cell => {
                let [x, y, z] = arguments else { return None };
                let place = [x.as_number()? as i64, y.as_number()? as i64, z.as_number()? as i64];
                lattice::cell_at(lattice, place).map(cell)
            }
            DesignFunction::Region => {
                let [from, x, y, z] = arguments else { return None };
                let [nx, ny, nz] = lattice.sides;
                let (from, [x, y, z]) = (part(from)?, [offsets(x, nx)?, offsets(y, ny)?, offsets(z, nz)?]);
                let mut places = Vec::new();
                for z in z {
                    for y in y.clone() {
                        let row = x.clone().filter_map(|x| lattice::beside(lattice, from, [x, y, z]));
                        places.extend(row.map(cell));
                    }
                }
                Some(Value::List(places.into()))
            }
            DesignFunction::Neighbours => {
                let joined = self.design().joined(lattice, part(arguments.first()?)?);
                Some(Value::List(joined.into_iter().map(cell).collect()))
            }
            DesignFunction::Images | DesignFunction::HangingOn => None,
        }
    }
}

/// Offsets along one side: one number, or all of a range. Further than the side is long none leads anywhere.
fn offsets(value: &Value, side: usize) -> Option<std::ops::RangeInclusive<i64>> {
    let (low, high) = match value {
        Value::Number(x) => (*x, *x),
        Value::Domain(domain) => match &**domain {
            Domain::Range { low, high, .. } => (libm::ceil(*low), libm::floor(*high)),
            Domain::Items(_) => return None,
        },
        _ => return None,
    };
    let far = side as f64;
    Some(low.clamp(-far, far) as i64..=high.clamp(-far, far) as i64)
}

fn cell(id: PartId) -> Value {
    reference(Reference::Part(id))
}

fn reference(reference: Reference) -> Value {
    Value::Reference(reference)
}

fn part(value: &Value) -> Option<PartId> {
    match value {
        Value::Reference(Reference::Part(id)) => Some(*id),
        _ => None,
    }
}

impl Scope for DesignScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(self.rules)
    }

    fn left(&self) -> Option<&AtomicU64> {
        self.left
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Design(word) => Some(match (word, &self.rules.lattice) {
                (DesignWord::Connected, Some(lattice)) => Value::Bool(self.design().is_one_piece(lattice)),
                (DesignWord::Connected, None) => Value::Bool(self.design().is_connected()),
                (DesignWord::Middle, lattice) => lattice::middle(lattice.as_ref()?).map(cell)?,
                (DesignWord::NoOverlap, Some(_)) => Value::Bool(true),
                (DesignWord::NoOverlap, None) => Value::Bool(self.design().no_overlap(self.rules)),
            }),
            Word::Search(SearchWord::Temperature) => self.temperature.map(Value::Number),
            Word::Search(_)
            | Word::Motion(_)
            | Word::Time
            | Word::Now
            | Word::Before
            | Word::ControlInterval
            | Word::Cycle => None,
            // These mean the same everywhere.
            Word::Pi | Word::Closed | Word::Inflate | Word::Vent => None,
        }
    }

    fn of_body(&self, name: &str) -> Option<Value> {
        self.design().known(self.rules).of_body(name)
    }

    fn placed(&self, name: &str) -> Option<Value> {
        self.design().placed.get(name).map(|id| Value::Reference(Reference::Part(*id)))
    }

    fn group(&self, group: &Group) -> Option<Vec<Value>> {
        let parts = self.design().parts.keys().filter(|id| self.design().belongs(self.rules, **id, group));
        Some(parts.map(|id| Value::Reference(Reference::Part(*id))).collect())
    }

    fn belongs(&self, value: &Value, group: &Group) -> Option<bool> {
        let id = part(value)?;
        Some(self.design_of(id).belongs(self.rules, id, group))
    }

    fn adds(&self, step: &Value, group: &Group) -> Option<bool> {
        let Value::Reference(Reference::Step(step)) = step else { return None };
        let design = self.design();
        Some(design.parts.iter().any(|(id, p)| p.step == *step && design.belongs(self.rules, *id, group)))
    }

    fn attribute(&self, of: Reference, attribute: &Attribute) -> Option<Value> {
        match (attribute, of) {
            (Attribute::Part(attribute), Reference::Part(id)) => self.part_attribute(id, *attribute),
            (Attribute::Cell(attribute), Reference::Part(id)) => self.cell_attribute(id, *attribute),
            (Attribute::Port(attribute), Reference::Port(id, port)) => {
                self.port_attribute(id, port, *attribute)
            }
            (Attribute::Joint(attribute), Reference::Joint(held)) => self.joint_attribute(held, *attribute),
            (Attribute::Step(attribute), Reference::Step(id)) => self.step_attribute(id, *attribute),
            (Attribute::Param(name), Reference::Part(id)) => {
                // Of several kinds, some may have a field of that name.
                let field = || self.kind_field(id, KindField::named(name)?);
                self.design_of(id).parts.get(&id)?.params.get(name).cloned().or_else(field)
            }
            (Attribute::Field(field), Reference::Part(id)) => self.kind_field(id, *field),
            // Only a motion has them, or its world, or a vector.
            (Attribute::Element(_) | Attribute::Track(_) | Attribute::World(_) | Attribute::Axis(_), _) => {
                None
            }
            // The checker lets nothing else through.
            (
                Attribute::Part(_)
                | Attribute::Cell(_)
                | Attribute::Port(_)
                | Attribute::Joint(_)
                | Attribute::Step(_)
                | Attribute::Field(_)
                | Attribute::Param(_),
                _,
            ) => None,
        }
    }

    fn port(&self, of: &Value, name: &str, number: Option<f64>) -> Option<Value> {
        let id = part(of)?;
        let frames = ports(self.design_of(id).parts.get(&id)?);
        let found = frames.iter().position(|p| p.name == name && number.is_none_or(|n| n == p.number))?;
        Some(reference(Reference::Port(id, found as u8)))
    }

    fn is_port(&self, port: &Value, name: &str) -> Option<bool> {
        let Value::Reference(Reference::Port(id, port)) = port else { return None };
        let frames = ports(self.design_of(*id).parts.get(id)?);
        Some(frames.get(*port as usize)?.name == name)
    }

    fn clusters(&self, cells: &[(Value, Value)]) -> Option<usize> {
        let cells: Option<Vec<_>> =
            cells.iter().map(|(cell, value)| Some((part(cell)?, value.clone()))).collect();
        Some(lattice::clusters(self.rules.lattice.as_ref()?, &cells?))
    }

    fn call(&self, function: DesignFunction, arguments: &[Value]) -> Option<Value> {
        if let Some(lattice) = &self.rules.lattice {
            return self.call_in(lattice, function, arguments);
        }
        let id = part(arguments.first()?)?;
        let design = self.design_of(id);
        let parts = match function {
            DesignFunction::Neighbours => design.neighbours(id),
            DesignFunction::Images => design.orbit(id).into_iter().filter(|other| *other != id).collect(),
            DesignFunction::HangingOn => design.hanging_on(id),
            DesignFunction::Cell | DesignFunction::Region => return None,
        };
        Some(Value::List(parts.into_iter().map(|id| reference(Reference::Part(id))).collect()))
    }
}
