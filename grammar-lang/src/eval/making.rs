//! What one part is, worked out from what its kind says and the values of its parameters.

use std::sync::atomic::{AtomicU64, Ordering};

use indexmap::IndexMap;

use super::made::{
    Made, MadeActuator, MadeBlock, MadeCell, MadeJoint, MadeMotor, MadePort, SHORTER, SOCKET, Unmade,
};
use super::made::{is_across, is_colour, shortens, unit};
use super::{Bounded, Scope, Value, evaluate};
use crate::ir::{Actuator, Cell, Expr, Field, Form, Joint, JointKind, Kind, Mass, Motor, Part, Port, Speed};
use crate::units::{Dimension, shown};

/// What a number must be.
#[derive(Clone, Copy)]
enum Sign {
    Positive,
    NotNegative,
}

/// What says where a joint stands as a motion begins.
#[derive(Clone, Copy)]
struct Starts {
    neutral: f64,
    begins: Option<f64>,
    driven: bool,
}

/// How many operations all fields of one part may take together.
const MOST_OF_PART: u64 = 200_000;
/// And those of one cell: a lattice has many.
const MOST_OF_CELL: u64 = 20_000;

/// What fields are worked out with.
struct From<'a> {
    scope: &'a dyn Scope,
    params: Vec<Value>,
}

impl Made {
    /// What a part of a kind is.
    ///
    /// # Errors
    ///
    /// An [`Unmade`] field: with these parameters it has no value, or none that a part can have.
    pub fn of(kind: Kind<'_>, scope: &dyn Scope, params: &IndexMap<String, Value>) -> Result<Self, Unmade> {
        Self::bounded(kind, scope, params, most(kind)).0
    }

    /// The same as long as `left` operations last, from which it takes what it needs; `None` where they do not.
    pub fn within(
        kind: Kind<'_>,
        scope: &dyn Scope,
        params: &IndexMap<String, Value>,
        left: &AtomicU64,
    ) -> Option<Result<Self, Unmade>> {
        let all = left.load(Ordering::Relaxed);
        let allowed = all.min(most(kind));
        let (made, rest) = Self::bounded(kind, scope, params, allowed);
        left.store(all - (allowed - rest), Ordering::Relaxed);
        (made.is_ok() || rest > 0 || allowed == most(kind)).then_some(made)
    }

    /// The same within so many operations; and how many of them are left.
    fn bounded(
        kind: Kind<'_>,
        scope: &dyn Scope,
        params: &IndexMap<String, Value>,
        most: u64,
    ) -> (Result<Self, Unmade>, u64) {
        let left = AtomicU64::new(most);
        let from =
            From { scope: &Bounded { scope, left: &left }, params: params.values().cloned().collect() };
        let made = from.made(kind);
        let rest = left.load(Ordering::Relaxed);
        let whose = if let Kind::Cell(_) = kind { "a cell" } else { "a part" };
        let too_much = |unmade| Unmade {
            reason: format!("the fields of {whose} take {most} operations at most; sum over fewer values"),
            ..unmade
        };
        (if rest == 0 { made.map_err(too_much) } else { made }, rest)
    }
}

/// How many operations the fields of one part of a kind may take together.
fn most(kind: Kind<'_>) -> u64 {
    if let Kind::Cell(_) = kind { MOST_OF_CELL } else { MOST_OF_PART }
}

impl From<'_> {
    fn made(&self, kind: Kind<'_>) -> Result<Made, Unmade> {
        Ok(match kind {
            Kind::Block(part) => Made::Block(self.block(part)?),
            Kind::Actuator(actuator) => Made::Actuator(self.actuator(actuator)?),
            Kind::Cell(lattice) => Made::Cell(self.cell(&lattice.cell)?),
        })
    }

    fn cell(&self, cell: &Cell) -> Result<MadeCell, Unmade> {
        let number = |name, field, sign| signed(name, self.read(None, name, field, as_number)?, sign);
        Ok(MadeCell {
            mass: number("mass", &cell.mass, Sign::Positive)?,
            friction: number("friction", &cell.friction, Sign::NotNegative)?,
            stiffness: number("stiffness", &cell.stiffness, Sign::Positive)?,
            damping: number("damping", &cell.damping, Sign::NotNegative)?,
            colour: coloured(self.read(None, "colour", &cell.colour, as_text)?)?,
        })
    }

    fn block(&self, part: &Part) -> Result<MadeBlock, Unmade> {
        let form = self.form("shape", &part.shape)?;
        Ok(MadeBlock {
            form,
            mass: self.mass(&part.mass, form)?,
            friction: self.number("friction", &part.friction, Sign::NotNegative)?,
            colour: self.colour(&part.colour)?,
            ports: part.ports.iter().map(|port| self.port(port)).collect::<Result<_, _>>()?,
            mirrored: false,
            joint: part.joint.as_ref().map(|joint| self.joint(joint, 1.0, false)).transpose()?,
        })
    }

    fn actuator(&self, actuator: &Actuator) -> Result<MadeActuator, Unmade> {
        let segment = self.form("segment", &actuator.segment)?;
        let segments = actuator.params.get_index_of("segments");
        let segments = segments.and_then(|slot| self.params.get(slot)?.as_number()).unwrap_or(2.0);
        let joint = self.joint(&actuator.joint, (segments - 1.0).max(1.0), actuator.motor.is_some())?;
        if actuator.joint.kind == JointKind::Bend && !is_across(joint.axis) {
            return Err(Unmade {
                field: "joint",
                reason: "a row can bend only about an axis across it".to_owned(),
            });
        }
        if let (JointKind::Slide, Some(range)) = (actuator.joint.kind, joint.range) {
            let length = 2.0 * segment.half_extents().x * segments;
            let shorter = shortens(joint.axis, range);
            if shorter > SHORTER * length * (1.0 + 1e-9) {
                return Err(Unmade {
                    field: "range",
                    reason: format!(
                        "a row of length {} cannot get shorter by {}; the limit is half of its length",
                        shown(length, Dimension::LENGTH),
                        shown(shorter, Dimension::LENGTH)
                    ),
                });
            }
        }
        Ok(MadeActuator {
            segment,
            mass: self.mass(&actuator.mass, segment)?,
            friction: self.number("friction", &actuator.friction, Sign::NotNegative)?,
            motor: actuator.motor.as_ref().map(|motor| self.motor(motor, actuator.joint.kind)).transpose()?,
            joint,
            colour: self.colour(&actuator.colour)?,
        })
    }

    fn motor(&self, motor: &Motor, kind: JointKind) -> Result<MadeMotor, Unmade> {
        Ok(MadeMotor {
            speed: self.speed(kind.speed_field(), &motor.speed)?,
            relaxing_speed: self.speed("relaxing_speed", &motor.relaxing_speed)?,
            effort: self.number(kind.effort_field(), &motor.effort, Sign::Positive)?,
        })
    }

    fn speed(&self, name: &'static str, field: &Field<Speed>) -> Result<Speed, Unmade> {
        let speed = self.value(name, field, |value| value.as_number().map(Speed::Constant))?;
        match speed {
            Speed::Constant(x) if x <= 0.0 => {
                Err(Unmade { field: name, reason: "it must be above 0".to_owned() })
            }
            _ => Ok(speed),
        }
    }

    /// A joint of a row with so many of them, or of a part.
    fn joint(&self, joint: &Joint, joints: f64, driven: bool) -> Result<MadeJoint, Unmade> {
        let unmade = |reason: &str| Unmade { field: "joint", reason: reason.to_owned() };
        let axis = unit(self.value("joint", &joint.axis, as_vector)?)
            .ok_or_else(|| unmade("an axis needs a direction"))?;
        // What drives a joint needs a spring to hold it, or, of a spin, a damper to turn it.
        let spins = joint.kind == JointKind::Spin;
        let needs = |what: bool| if what && driven { Sign::Positive } else { Sign::NotNegative };
        let neutral = self.value("neutral", &joint.neutral, |value| value.as_number())?;
        let begins =
            joint.begins.as_ref().map(|begins| self.value("begins", begins, |value| value.as_number()));
        let begins = begins.transpose()?;
        let starts = Starts { neutral, begins, driven };
        let range = joint.range.as_ref().map(|range| self.range(joint.kind, range, starts)).transpose()?;
        if let Some((low, high)) = range.filter(|_| joint.kind == JointKind::Socket)
            && high.max(-low) > SOCKET * joints * (1.0 + 1e-9)
        {
            let reason = "a socket can turn by at most 80 deg about each axis".to_owned();
            return Err(Unmade { field: joint.kind.range(), reason });
        }
        Ok(MadeJoint {
            kind: joint.kind,
            axis,
            pivot: joint.pivot.as_ref().map(|pivot| self.value("pivot", pivot, as_vector)).transpose()?,
            range,
            neutral,
            begins,
            mirrored: false,
            sideways: self.across("sideways", joint.sideways.as_ref())?,
            torsion: self.across("torsion", joint.torsion.as_ref())?,
            stiffness: self.number("stiffness", &joint.stiffness, needs(!spins))?,
            damping: self.number("damping", &joint.damping, needs(spins))?,
        })
    }

    fn across(&self, name: &'static str, stiffness: Option<&Field<f64>>) -> Result<Option<f64>, Unmade> {
        stiffness.map(|stiffness| self.number(name, stiffness, Sign::Positive)).transpose()
    }

    /// How far a joint goes. It begins within that: where it is attached, unless its springs rest elsewhere.
    fn range(
        &self,
        kind: JointKind,
        range: &Field<(f64, f64)>,
        Starts { neutral, begins, driven }: Starts,
    ) -> Result<(f64, f64), Unmade> {
        let name = kind.range();
        let (low, high) = self.value(name, range, |value| match value {
            Value::Domain(domain) => domain.ends(),
            _ => None,
        })?;
        if driven && neutral != 0.0 && (neutral < low || neutral > high) {
            let reason = format!("a driven joint must rest within its range, not at {}", {
                shown(neutral, kind.position())
            });
            return Err(Unmade { field: "neutral", reason });
        }
        let shown = |x: f64| shown(x, kind.position());
        if let Some(begins) = begins.filter(|begins| low < high && (*begins < low || *begins > high)) {
            let reason =
                format!("{} is not within its range {} .. {}", shown(begins), shown(low), shown(high));
            return Err(Unmade { field: "begins", reason });
        }
        if low < high && (low <= 0.0 && high >= 0.0 || neutral != 0.0 || begins.is_some()) {
            return Ok((low, high));
        }
        let (zero, others) =
            if kind == JointKind::Slide { ("0 mm", "distances") } else { ("0 deg", "angles") };
        let rests = match kind == JointKind::Socket {
            true => "",
            false => ", unless `neutral` says that it rests elsewhere",
        };
        let reason =
            format!("{} .. {} must contain {zero}, and other {others}, too{rests}", shown(low), shown(high));
        Err(Unmade { field: name, reason })
    }

    /// The value of a field as `read` takes it. `index` is the number of a port: it is the local behind the parameters.
    fn value_with<T: Clone>(
        &self,
        index: Option<Value>,
        name: &'static str,
        field: &Field<T>,
        read: impl FnOnce(Value) -> Option<T>,
    ) -> Result<T, Unmade> {
        match field {
            Field::Fixed(value) => Ok(value.clone()),
            Field::Varies(value) => self.read(index, name, value, read),
        }
    }

    fn read<T>(
        &self,
        index: Option<Value>,
        name: &'static str,
        value: &Expr,
        read: impl FnOnce(Value) -> Option<T>,
    ) -> Result<T, Unmade> {
        let unmade = |reason: String| Unmade { field: name, reason };
        let mut locals: Vec<Value> = self.params.iter().cloned().chain(index).collect();
        let value = evaluate(value, self.scope, &mut locals).map_err(|error| unmade(error.reason))?;
        read(value).ok_or_else(|| unmade("this value is not of the right kind".to_owned()))
    }

    fn value<T: Clone>(
        &self,
        name: &'static str,
        field: &Field<T>,
        read: impl FnOnce(Value) -> Option<T>,
    ) -> Result<T, Unmade> {
        self.value_with(None, name, field, read)
    }

    fn number(&self, name: &'static str, field: &Field<f64>, sign: Sign) -> Result<f64, Unmade> {
        signed(name, self.value(name, field, as_number)?, sign)
    }

    fn mass(&self, mass: &Mass, form: Form) -> Result<f64, Unmade> {
        match mass {
            Mass::Given(mass) => self.number("mass", mass, Sign::Positive),
            Mass::Dense { density } => {
                Ok(self.number("density", density, Sign::Positive)? * form.shape.volume())
            }
        }
    }

    fn form(&self, name: &'static str, field: &Field<Form>) -> Result<Form, Unmade> {
        let form = self.value(name, field, |value| match value {
            Value::Shape(form) => Some(form),
            _ => None,
        })?;
        let sizes = form.written().1;
        if sizes.iter().all(|size| *size > 0.0) {
            Ok(form)
        } else {
            Err(Unmade { field: name, reason: "every size of a shape must be above 0".to_owned() })
        }
    }

    fn colour(&self, field: &Field<String>) -> Result<String, Unmade> {
        coloured(self.value("colour", field, as_text)?)
    }

    fn port(&self, port: &Port) -> Result<MadePort, Unmade> {
        let index = || Some(Value::Number(port.index));
        let at = self.value_with(index(), "port", &port.at, as_vector)?;
        let facing = unit(self.value_with(index(), "port", &port.facing, as_vector)?).ok_or_else(|| {
            Unmade { field: "port", reason: "a port must face in some direction".to_owned() }
        })?;
        Ok(MadePort { name: port.name.clone(), index: port.index, at, facing })
    }
}

/// A number, if it has the sign that its field must have.
fn signed(field: &'static str, x: f64, sign: Sign) -> Result<f64, Unmade> {
    let (fine, must) = match sign {
        Sign::Positive => (x > 0.0, "must be above 0"),
        Sign::NotNegative => (x >= 0.0, "must not be below 0"),
    };
    if fine { Ok(x) } else { Err(Unmade { field, reason: format!("it {must}") }) }
}

/// A text, if it is a colour.
fn coloured(text: String) -> Result<String, Unmade> {
    if is_colour(&text) {
        Ok(text)
    } else {
        Err(Unmade { field: "colour", reason: "a colour must be written as `#rrggbb`".to_owned() })
    }
}

fn as_number(value: Value) -> Option<f64> {
    value.as_number()
}

fn as_text(value: Value) -> Option<String> {
    if let Value::Text(text) = value { Some(text.to_string()) } else { None }
}

fn as_vector(value: Value) -> Option<[f64; 3]> {
    match value {
        Value::Vector(vector) => Some(vector),
        _ => None,
    }
}
