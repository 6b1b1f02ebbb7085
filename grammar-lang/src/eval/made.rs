//! What one part is, from what its kind says and the values of its parameters.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use indexmap::IndexMap;

use super::{Bounded, Scope, Value, evaluate};
use crate::ir::{Actuator, Field, Form, Joint, JointKind, Kind, Mass, Motor, Part, Port, Speed};
use crate::units::{Dimension, shown};

/// What one part of a kind is.
#[derive(Clone, Debug, PartialEq)]
pub enum Made {
    /// A passive part.
    Block(MadeBlock),
    /// An actuator.
    Actuator(MadeActuator),
}

/// A passive part.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeBlock {
    /// Its shape.
    pub form: Form,
    /// In kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// `#rrggbb`
    pub colour: String,
    /// Its ports, if they are not the six that every block has.
    pub ports: Vec<MadePort>,
    /// Whether its ports are those of the kind seen in a mirror, with the other sign of z.
    pub mirrored: bool,
    /// The joint with which it hangs on what holds it, if it is not fixed there.
    pub joint: Option<MadeJoint>,
}

/// The joints of a row, or the joint of a part with what holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeJoint {
    /// What it does.
    pub kind: JointKind,
    /// The unit vector about or along which it moves, in the part's frame.
    pub axis: [f64; 3],
    /// A point of the axis in the frame of a part, m, if it is not the port by which the part is held.
    pub pivot: Option<[f64; 3]>,
    /// Stiffness, N m/rad or N/m.
    pub stiffness: f64,
    /// Damping, N m s/rad or N s/m.
    pub damping: f64,
    /// How far the tip of a row goes against its base, or a part against what holds it: least and greatest, rad or m. A spin has
    /// no end.
    pub range: Option<(f64, f64)>,
    /// Where its springs pull it if nothing drives it, rad or m; of a row from base to tip. Beyond the range they press on its end.
    pub neutral: f64,
    /// Where it stands as a motion begins, rad or m, if that is said; of a row from base to tip.
    pub begins: Option<f64>,
    /// Whether it is that of a part seen in a mirror, where that is another joint than the kind's own.
    pub mirrored: bool,
}

impl MadeJoint {
    /// Whether the joint looks different in a mirror that turns the z axis of the frame round: with a range to one side, a spring
    /// that rests there, an axis that is oblique to the mirror, or a pivot beside it.
    fn is_handed(&self) -> bool {
        let [x, y, _] = self.axis;
        let pivot = self.pivot.map_or(0.0, |[_, _, z]| z);
        let seen = self.kind.axis_in_mirror(self.axis);
        let is = |sign: f64| seen.iter().zip(self.axis).all(|(seen, own)| (seen - sign * own).abs() < SAME);
        let even = self.neutral == 0.0
            && self.begins.unwrap_or_default() == 0.0
            && self.range.is_none_or(|(low, high)| (low + high).abs() < SAME);
        let same_axis = is(1.0) || is(-1.0) && even;
        match self.kind {
            JointKind::Slide => !same_axis,
            // It turns about every axis.
            JointKind::Socket => pivot.abs() > SAME,
            JointKind::Bend | JointKind::Twist | JointKind::Spin => {
                // A pivot may move along the axis.
                !same_axis || pivot.abs() > SAME && libm::hypot(x, y) > SAME
            }
        }
    }

    /// Where it stands as a motion begins, rad or m; of a row from base to tip: where its springs leave it, unless it is said.
    #[must_use]
    pub fn start(&self) -> f64 {
        let (low, high) = self.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        self.begins.unwrap_or(self.neutral).max(low).min(high)
    }
}

/// A port that a part declares.
#[derive(Clone, Debug, PartialEq)]
pub struct MadePort {
    /// Its name; several may share one.
    pub name: String,
    /// Its number among those that share the name.
    pub index: f64,
    /// Its place in the part's frame, m.
    pub at: [f64; 3],
    /// The unit vector that points outwards.
    pub facing: [f64; 3],
}

/// An actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeActuator {
    /// One segment.
    pub segment: Form,
    /// Mass of one segment in kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// What drives it; nothing drives a passive row.
    pub motor: Option<MadeMotor>,
    /// Each of its joints.
    pub joint: MadeJoint,
    /// `#rrggbb`
    pub colour: String,
}

/// What drives the joints of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeMotor {
    /// Speed of the tip against the base while it goes away from rest, rad/s or m/s. Of a spin the greatest.
    pub speed: Speed,
    /// Speed while it goes back to rest.
    pub relaxing_speed: Speed,
    /// Greatest torque or force of each joint, N m or N.
    pub effort: f64,
}

impl MadeActuator {
    /// What a drive can ask of it: where its tip stands against its base, rad or m, or of a spin how fast it turns, rad/s.
    #[must_use]
    pub fn driven_range(&self) -> (f64, f64) {
        let fastest = self.motor.as_ref().map_or(f64::INFINITY, |motor| motor.speed.most());
        self.joint.range.unwrap_or((-fastest, fastest))
    }
}

/// A field of a part that its parameters leave without a value that makes sense.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Unmade {
    /// The field.
    pub field: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

impl fmt::Display for Unmade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "its `{}`: {}", self.field, self.reason)
    }
}

impl std::error::Error for Unmade {}

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

/// What fields are worked out with.
struct From<'a> {
    scope: &'a dyn Scope,
    params: Vec<Value>,
}

impl Made {
    /// What a part of a kind is; none for a cell of a lattice, whose fields are read where it is simulated.
    ///
    /// # Errors
    ///
    /// An [`Unmade`] field: with these parameters it has no value, or none that a part can have.
    pub fn of(
        kind: Kind<'_>,
        scope: &dyn Scope,
        params: &IndexMap<String, Value>,
    ) -> Result<Option<Self>, Unmade> {
        Self::within(kind, scope, params, &AtomicU64::new(u64::MAX)).unwrap_or(Ok(None))
    }

    /// The same as long as `left` operations last, from which it takes what it needs; `None` where they do not.
    pub(crate) fn within(
        kind: Kind<'_>,
        scope: &dyn Scope,
        params: &IndexMap<String, Value>,
        left: &AtomicU64,
    ) -> Option<Result<Option<Self>, Unmade>> {
        let all = left.load(Ordering::Relaxed);
        let allowed = all.min(MOST_OF_PART);
        let own = AtomicU64::new(allowed);
        let made = Self::worked_out(kind, &Bounded { scope, left: &own }, params);
        let rest = own.load(Ordering::Relaxed);
        left.store(all - (allowed - rest), Ordering::Relaxed);
        match made {
            Err(_) if rest == 0 && allowed < MOST_OF_PART => None,
            Err(unmade) if rest == 0 => Some(Err(Unmade {
                reason: format!(
                    "the fields of a part take {MOST_OF_PART} operations at most; sum over fewer values"
                ),
                ..unmade
            })),
            made => Some(made),
        }
    }

    fn worked_out(
        kind: Kind<'_>,
        scope: &dyn Scope,
        params: &IndexMap<String, Value>,
    ) -> Result<Option<Self>, Unmade> {
        let from = From { scope, params: params.values().cloned().collect() };
        Ok(match kind {
            Kind::Block(part) => Some(Self::Block(from.block(part)?)),
            Kind::Actuator(actuator) => Some(Self::Actuator(from.actuator(actuator)?)),
            Kind::Cell(_) => None,
        })
    }

    /// The same as it looks in a mirror. A mirror turns the z axis of a part's frame round. Where the kind has a port for
    /// each port in the mirror, the part is the same; otherwise its ports have the other sign of z. A joint keeps its numbers, and says whether it is another one.
    #[must_use]
    pub fn in_mirror(mut self) -> Self {
        if let Self::Block(block) = &mut self
            && is_handed(&block.ports)
        {
            for port in &mut block.ports {
                *port = mirrored(port);
            }
            block.mirrored = !block.mirrored;
        }
        let joint = match &mut self {
            Self::Block(block) => block.joint.as_mut(),
            Self::Actuator(actuator) => Some(&mut actuator.joint),
        };
        if let Some(joint) = joint.filter(|joint| joint.is_handed()) {
            joint.mirrored = !joint.mirrored;
        }
        self
    }

    /// Its colour, `#rrggbb`.
    #[must_use]
    pub fn colour(&self) -> &str {
        match self {
            Self::Block(block) => &block.colour,
            Self::Actuator(actuator) => &actuator.colour,
        }
    }
}

impl From<'_> {
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
            return Err(Unmade { field: "joint", reason: "a row bends about an axis across it".to_owned() });
        }
        if let (JointKind::Slide, Some(range)) = (actuator.joint.kind, joint.range) {
            let length = 2.0 * segment.half_extents().x * segments;
            let shorter = shortens(joint.axis, range);
            if shorter > SHORTER * length * (1.0 + 1e-9) {
                return Err(Unmade {
                    field: "range",
                    reason: format!(
                        "a row of {} cannot get shorter by {}; half of its length is the most",
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
            let reason = "a socket turns by at most 80 deg about each axis".to_owned();
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
            stiffness: self.number("stiffness", &joint.stiffness, needs(!spins))?,
            damping: self.number("damping", &joint.damping, needs(spins))?,
        })
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
            let reason = format!("what is driven rests within its range, and not at {}", {
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
        let value = match field {
            Field::Fixed(value) => return Ok(value.clone()),
            Field::Varies(value) => value,
        };
        let unmade = |reason: String| Unmade { field: name, reason };
        let mut locals: Vec<Value> = self.params.iter().cloned().chain(index).collect();
        let value = evaluate(value, self.scope, &mut locals).map_err(|error| unmade(error.reason))?;
        read(value).ok_or_else(|| unmade("this is no such value".to_owned()))
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
        let x = self.value(name, field, |value| value.as_number())?;
        let (fine, must) = match sign {
            Sign::Positive => (x > 0.0, "must be above 0"),
            Sign::NotNegative => (x >= 0.0, "must not be below 0"),
        };
        if fine { Ok(x) } else { Err(Unmade { field: name, reason: format!("it {must}") }) }
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
        let colour = self.value("colour", field, |value| match value {
            Value::Text(text) => Some(text.to_string()),
            _ => None,
        })?;
        if is_colour(&colour) {
            Ok(colour)
        } else {
            Err(Unmade { field: "colour", reason: "a colour is written as `#rrggbb`".to_owned() })
        }
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

/// A vector with the other sign of z.
fn other_side([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, y, 0.0 - z]
}

/// A port as it looks in a mirror.
fn mirrored(port: &MadePort) -> MadePort {
    MadePort { at: other_side(port.at), facing: other_side(port.facing), ..port.clone() }
}

/// Whether ports look different in a mirror: some port has none on the other side that faces the other way.
fn is_handed(ports: &[MadePort]) -> bool {
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME);
    let has =
        |wanted: &MadePort| ports.iter().any(|p| near(p.at, wanted.at) && near(p.facing, wanted.facing));
    !ports.iter().all(|port| has(&mirrored(port)))
}

/// Ports are in one place if they are nearer than this, m; and face one way, as a share of 1.
const SAME: f64 = 1e-7;

fn as_vector(value: Value) -> Option<[f64; 3]> {
    match value {
        Value::Vector(vector) => Some(vector),
        _ => None,
    }
}

/// An axis of a bend has at least this share across the row, of what it has along it.
const ACROSS: f64 = 1e-3;

/// Whether a row can bend about an axis: it must not lie along the row.
#[must_use]
pub fn is_across(axis: [f64; 3]) -> bool {
    let [along, across, aside] = axis;
    (across * across + aside * aside).sqrt() >= ACROSS * along.abs()
}

/// How far a socket turns about each of its axes, at most, rad. At a right angle two of them would be one.
pub const SOCKET: f64 = 80.0 * std::f64::consts::PI / 180.0;

/// By how much a row gets shorter at most, m, where its joints slide along an axis within a range.
#[must_use]
pub fn shortens(axis: [f64; 3], (low, high): (f64, f64)) -> f64 {
    (-low * axis[0]).max(-high * axis[0]).max(0.0)
}

/// The share of its length by which a row may get shorter: beyond it, segments that are not neighbours would meet.
pub const SHORTER: f64 = 0.5;

/// The vector of length one in this direction; none of a vector without length.
#[must_use]
pub fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    let [x, y, z] = vector;
    let length = (x * x + y * y + z * z).sqrt();
    (length > 0.0 && length.is_finite()).then(|| [x / length, y / length, z / length])
}

/// Whether a text is a colour: `#rrggbb`.
#[must_use]
pub fn is_colour(text: &str) -> bool {
    text.strip_prefix('#').is_some_and(|hex| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()))
}
