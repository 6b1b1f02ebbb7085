//! What the expressions of the derivation can read: the design so far.

use grammar_lang::eval::{Domain, Reference, Scope, Value};
use grammar_lang::ir::{Function, Group, Lattice, RuleSet, Word};

use super::Derivation;
use crate::design::{Design, PartId, lattice, ports};

/// The design so far, and the temperature where a weight may read it.
pub struct DesignScope<'a> {
    rules: &'a RuleSet,
    derivation: &'a Derivation,
    temperature: Option<f64>,
    /// The design with what the rule has made so far.
    made: Option<&'a Design>,
}

impl<'a> DesignScope<'a> {
    /// Sees a design.
    #[must_use]
    pub fn new(rules: &'a RuleSet, derivation: &'a Derivation) -> Self {
        Self { rules, derivation, temperature: None, made: None }
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

    fn design(&self) -> &Design {
        &self.derivation.design
    }

    /// The design that knows a part: that before the rule, or else that with what the rule made.
    fn design_of(&self, id: PartId) -> &Design {
        match self.made {
            Some(made) if !self.design().parts.contains_key(&id) => made,
            _ => self.design(),
        }
    }

    fn port_attribute(&self, id: PartId, port: u8, name: &str) -> Option<Value> {
        let design = self.design_of(id);
        match name {
            "part" => Some(reference(Reference::Part(id))),
            "free" => Some(Value::Bool(design.is_free(self.rules, id, port))),
            "index" => {
                let frames = ports(self.rules, design.parts.get(&id)?);
                Some(Value::Number(frames.get(port as usize)?.number))
            }
            _ => None,
        }
    }

    fn part_attribute(&self, id: PartId, name: &str) -> Option<Value> {
        let design = self.design_of(id);
        let part = design.parts.get(&id)?;
        Some(match name {
            "turn" => Value::Number(part.turn),
            "image" => Value::Number(f64::from(part.image)),
            "depth" => Value::Number(design.depth(id) as f64),
            "mass" => Value::Number(design.mass(self.rules, id)?),
            // The core holds itself.
            "holder" => reference(Reference::Part(part.held_by.map_or(id, |(holder, _)| holder))),
            "twin" => reference(Reference::Part(design.twin(id))),
            // A parameter of that name is what the actuator itself says.
            _ if part.params.contains_key(name) => part.params.get(name).cloned()?,
            "least_bend" => Value::Number(self.rules.actuators.get(&part.kind)?.bend.0),
            "greatest_bend" => Value::Number(self.rules.actuators.get(&part.kind)?.bend.1),
            _ => return None,
        })
    }

    /// An attribute of a place, or of the cell there.
    fn cell_attribute(&self, id: PartId, name: &str) -> Option<Value> {
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name);
        if let Some(axis) = axis {
            let place = lattice::place_of(id)?;
            return place.get(axis).map(|at| Value::Number(*at as f64));
        }
        let cell = self.design().parts.get(&id);
        if name == "filled" { Some(Value::Bool(cell.is_some())) } else { cell?.params.get(name).cloned() }
    }

    fn step_attribute(&self, id: u64, name: &str) -> Option<Value> {
        let (i, step) = self.derivation.steps.iter().enumerate().find(|(_, s)| s.id == id)?;
        match name {
            "rule" => Some(Value::Text(step.rule.as_str().into())),
            "number" => Some(Value::Number((i + 1) as f64)),
            _ => None,
        }
    }
}

impl DesignScope<'_> {
    /// The functions that know a lattice.
    fn call_in(&self, lattice: &Lattice, function: Function, arguments: &[Value]) -> Option<Value> {
        match function {
            Function::Cell => {
                let [x, y, z] = arguments else { return None };
                let place = [x.as_number()? as i64, y.as_number()? as i64, z.as_number()? as i64];
                lattice::cell_at(lattice, place).map(cell)
            }
            Function::Region => {
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
            Function::Neighbours => {
                let joined = self.design().joined(lattice, part(arguments.first()?)?);
                Some(Value::List(joined.into_iter().map(cell).collect()))
            }
            _ => None,
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

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Connected => Some(Value::Bool(match &self.rules.lattice {
                Some(lattice) => self.design().is_one_piece(lattice),
                None => self.design().is_connected(),
            })),
            Word::Middle => lattice::middle(self.rules.lattice.as_ref()?).map(cell),
            Word::NoOverlap if self.rules.lattice.is_some() => Some(Value::Bool(true)),
            Word::NoOverlap => Some(Value::Bool(self.design().no_overlap(self.rules))),
            Word::Temperature => self.temperature.map(Value::Number),
            _ => None,
        }
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

    fn attribute(&self, of: &Value, name: &str) -> Option<Value> {
        match of {
            Value::Reference(Reference::Part(id)) if lattice::is_cell(*id) => self.cell_attribute(*id, name),
            Value::Reference(Reference::Part(id)) => self.part_attribute(*id, name),
            Value::Reference(Reference::Port(id, port)) => self.port_attribute(*id, *port, name),
            Value::Reference(Reference::Step(id)) => self.step_attribute(*id, name),
            Value::Reference(Reference::Joint(held)) => {
                let (holder, port) = self.design_of(*held).parts.get(held)?.held_by?;
                match name {
                    "holder" => Some(reference(Reference::Part(holder))),
                    "held" => Some(reference(Reference::Part(*held))),
                    "port" => Some(reference(Reference::Port(holder, port))),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn port(&self, of: &Value, name: &str, number: Option<f64>) -> Option<Value> {
        let id = part(of)?;
        let frames = ports(self.rules, self.design_of(id).parts.get(&id)?);
        let found = frames.iter().position(|p| p.name == name && number.is_none_or(|n| n == p.number))?;
        Some(reference(Reference::Port(id, found as u8)))
    }

    fn is_port(&self, port: &Value, name: &str) -> Option<bool> {
        let Value::Reference(Reference::Port(id, port)) = port else { return None };
        let frames = ports(self.rules, self.design_of(*id).parts.get(id)?);
        Some(frames.get(*port as usize)?.name == name)
    }

    fn clusters(&self, cells: &[(Value, Value)]) -> Option<usize> {
        let cells: Option<Vec<_>> =
            cells.iter().map(|(cell, value)| Some((part(cell)?, value.clone()))).collect();
        Some(lattice::clusters(self.rules.lattice.as_ref()?, &cells?))
    }

    fn call(&self, function: Function, arguments: &[Value]) -> Option<Value> {
        if let Some(lattice) = &self.rules.lattice {
            return self.call_in(lattice, function, arguments);
        }
        let id = part(arguments.first()?)?;
        let design = self.design_of(id);
        let parts = match function {
            Function::Neighbours => design.neighbours(id),
            Function::Images => design.orbit(id).into_iter().filter(|other| *other != id).collect(),
            _ => return None,
        };
        Some(Value::List(parts.into_iter().map(|id| reference(Reference::Part(id))).collect()))
    }
}
