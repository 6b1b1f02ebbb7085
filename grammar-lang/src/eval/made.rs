//! What one part is.

use std::fmt;

use crate::ir::{Form, JointKind, Speed};

/// What one part of a kind is.
#[derive(Clone, Debug, PartialEq)]
pub enum Made {
    /// A passive part.
    Block(MadeBlock),
    /// An actuator.
    Actuator(MadeActuator),
    /// A cell of a lattice.
    Cell(MadeCell),
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
    /// Of a row that bends: across its axis, N m/rad, if it is given.
    pub sideways: Option<f64>,
    /// The same against being twisted.
    pub torsion: Option<f64>,
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

/// A cell of a lattice: a ball that springs join to its neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeCell {
    /// In kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// Of a spring between two such cells, N/m.
    pub stiffness: f64,
    /// Of such a spring, N s/m.
    pub damping: f64,
    /// `#rrggbb`
    pub colour: String,
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

impl Made {
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
            Self::Cell(_) => None,
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
            Self::Cell(cell) => &cell.colour,
        }
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
