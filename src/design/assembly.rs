//! The assembly: a design as plain rigid elements, joints and springs.
//!
//! This is the contract between whatever makes designs and whatever simulates
//! them. It knows no grammar and no solver: a model lowers it to its own bodies.
//!
//! Frame: right-handed, y is up, x-z is the ground plane. SI units throughout.
//! Poses are those at rest (every hinge at angle zero).

use nalgebra::{Isometry3, Point3, UnitVector3};

pub use grammar_lang::shape::Shape;

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
    /// Rotation about one axis, driven by a servo.
    Hinge(Hinge),
}

/// A hinge with its servo. Angles are of the child relative to the parent,
/// right-handed about `axis`, zero at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Hinge {
    /// A point on the axis, in the world at rest.
    pub anchor: Point3<f64>,
    /// The axis, in the world at rest.
    pub axis: UnitVector3<f64>,
    /// Which actuator drives this hinge: an index below [`Assembly::actuators`].
    pub actuator: usize,
    /// The share of the actuator's total bend angle that this hinge takes.
    pub share: f64,
    /// Hard limits of the hinge angle in rad, low then high.
    pub limits: (f64, f64),
    /// Servo stiffness in N m/rad.
    pub stiffness: f64,
    /// Servo damping in N m s/rad.
    pub damping: f64,
    /// Largest servo torque in N m.
    pub torque: f64,
    /// Fastest change of the servo's own target while the bend grows away from
    /// zero, rad/s of this hinge.
    pub bending_rate: f64,
    /// The same while the bend goes back towards zero, rad/s of this hinge.
    pub relaxing_rate: f64,
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
    /// What the actuators of balls do; those of hinges are told by the hinges.
    pub swellings: Vec<Swelling>,
    /// How many actuators the hinges and swellings refer to.
    pub actuators: usize,
}
