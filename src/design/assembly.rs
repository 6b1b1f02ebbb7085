//! The assembly: a design as plain rigid elements, joints and springs.
//!
//! This is the contract between whatever makes designs and whatever simulates
//! them. It knows no grammar and no solver: a model lowers it to its own bodies.
//!
//! Frame: right-handed, y is up, x-z is the ground plane. SI units throughout.
//! Poses are those at rest (every joint at zero).

pub(crate) mod solid;

use nalgebra::{Isometry3, Point3, UnitVector3};

pub use grammar_lang::shape::Shape;

/// Elements that no longer overlap once they have shrunk to this share of their size only touch: a design may hold them,
/// and what simulates it must not let them pass through each other.
pub const TOUCHING: f64 = 0.98;

/// One simulated rigid piece: a cube, a ball or one cylinder of an actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Geometry about the element's own origin.
    pub shape: Shape,
    /// Pose of the element's centre in the world, at rest.
    pub pose: Isometry3<f64>,
    /// Mass in kg, positive; spread evenly over the shape.
    pub mass: f64,
    /// Coulomb coefficient of the surface; a contact uses the geometric mean
    /// of the two surfaces' coefficients.
    pub friction: f64,
}

/// A joint between two elements; the joints of an assembly form a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Index of the element nearer to the core.
    pub parent: usize,
    /// Index of the other element.
    pub child: usize,
    /// What the joint lets the child do.
    pub kind: JointKind,
}

/// What a joint lets its child do relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub enum JointKind {
    /// Nothing: the two are one body.
    Rigid,
    /// One degree of freedom.
    Dof(Dof),
    /// It turns about three axes, one after the other from the parent on, as a ball in its socket.
    Socket(Box<[Dof; 3]>),
}

impl JointKind {
    /// The degrees of freedom, from the parent on.
    #[must_use]
    pub fn dofs(&self) -> &[Dof] {
        match self {
            Self::Rigid => &[],
            Self::Dof(dof) => std::slice::from_ref(dof),
            Self::Socket(dofs) => dofs.as_slice(),
        }
    }

    /// The same, to change them.
    pub fn dofs_mut(&mut self) -> &mut [Dof] {
        match self {
            Self::Rigid => &mut [],
            Self::Dof(dof) => std::slice::from_mut(dof),
            Self::Socket(dofs) => dofs.as_mut_slice(),
        }
    }
}

impl From<Dof> for JointKind {
    fn from(dof: Dof) -> Self {
        Self::Dof(dof)
    }
}

/// A degree of freedom. Its position is that of the child relative to the parent, zero at rest: an angle in rad,
/// right-handed about `axis`, or a distance in m along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Dof {
    /// A point on the axis, in the world at rest.
    pub anchor: Point3<f64>,
    /// The axis, in the world at rest.
    pub axis: UnitVector3<f64>,
    /// What the child does.
    pub travel: Travel,
    /// What moves it.
    pub control: Control,
    /// The share of all that the actuator does that this one takes.
    pub share: f64,
    /// Hard limits of the position, low then high.
    pub limits: (f64, f64),
    /// Stiffness in N m/rad or N/m; not used where a speed is controlled.
    pub stiffness: f64,
    /// Of a row that bends, for soft rods: stiffness across the axis, N m/rad, if it is not that of a solid rod.
    pub sideways: Option<f64>,
    /// The same against being twisted.
    pub torsion: Option<f64>,
    /// Damping in N m s/rad or N s/m.
    pub damping: f64,
    /// Largest torque or force in N m or N; without limit where nothing drives it.
    pub effort: f64,
}

/// What a degree of freedom lets a body do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// It turns about the axis.
    Turn,
    /// It slides along the axis.
    Slide,
}

/// What moves a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// A servo holds it where the drive of its actuator says.
    Position {
        /// Which actuator it belongs to: an index below [`Assembly::actuators`].
        actuator: usize,
        /// Fastest change of the servo's own target away from zero, rad/s or m/s of this joint.
        rate: f64,
        /// The same while it goes back towards zero.
        relaxing_rate: f64,
        /// Where this joint stands at rest, as the drive counts it, rad or m: there its position is zero.
        rest: f64,
    },
    /// A motor turns it as fast as the drive of its actuator says: the damping is what drives it.
    Speed {
        /// Which actuator it belongs to.
        actuator: usize,
        /// So many times as fast as it is asked to turn.
        times: f64,
    },
    /// Its own spring and damper.
    Passive {
        /// Where the spring is slack, rad or m.
        neutral: f64,
    },
}

impl Control {
    /// The same with so many times the speed.
    #[must_use]
    pub fn faster(self, by: f64) -> Self {
        match self {
            Self::Position { actuator, rate, relaxing_rate, rest } => {
                Self::Position { actuator, rate: rate * by, relaxing_rate: relaxing_rate * by, rest }
            }
            Self::Speed { actuator, times } => Self::Speed { actuator, times: times * by },
            Self::Passive { .. } => self,
        }
    }
}

impl Dof {
    /// Which actuator drives it, if one does.
    #[must_use]
    pub fn actuator(&self) -> Option<usize> {
        match self.control {
            Control::Position { actuator, .. } | Control::Speed { actuator, .. } => Some(actuator),
            Control::Passive { .. } => None,
        }
    }

    /// Whether what is controlled is its speed.
    #[must_use]
    pub fn is_spun(&self) -> bool {
        matches!(self.control, Control::Speed { .. })
    }
}

/// A spring between the centres of two balls. Its length at rest is their distance at rest, times
/// one plus the mean strain of the two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Index of one element.
    pub from: usize,
    /// Index of the other.
    pub to: usize,
    /// In N/m, positive.
    pub stiffness: f64,
    /// Along the spring, in N s/m, not negative.
    pub damping: f64,
}

/// Material that is actuated: a ball's strain is the target of its actuator times a gain, and its radius is
/// that at rest times one plus the strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swelling {
    /// Index of the element.
    pub element: usize,
    /// Which actuator strains it: an index below [`Assembly::actuators`].
    pub actuator: usize,
    /// Strain per target; an element that is named more than once has the sum.
    pub gain: f64,
}

/// A design as rigid elements, held together either by joints that form a tree, or by springs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assembly {
    /// The elements; the first is the core, the root of the tree.
    pub elements: Vec<Element>,
    /// The joints, parents before children: one fewer than elements, or none where there are springs.
    pub joints: Vec<Joint>,
    /// The springs; all elements are then balls.
    pub springs: Vec<Spring>,
    /// What the actuators of balls do; those of joints are told by the joints.
    pub swellings: Vec<Swelling>,
    /// How many actuators the joints and swellings refer to.
    pub actuators: usize,
}
