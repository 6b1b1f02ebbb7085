//! Joints: between the segments of a row, and of a part with what holds it.

use serde::{Deserialize, Serialize};

use super::{Field, Ty};
use crate::units::Dimension;

/// How the segments of a row move against each other, or a part against what holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// What it does.
    pub kind: JointKind,
    /// About or along what, in the frame of the part (of a row: x from base to tip, y its top). A unit vector where it is the
    /// same for all. A socket turns about all axes, and has none.
    pub axis: Field<[f64; 3]>,
    /// How far the tip of a row goes against its base, or a part against what holds it: least and greatest, in rad (of a slide
    /// m), rest among them. A spin has no end.
    pub range: Option<Field<(f64, f64)>>,
    /// Stiffness of each joint, N m/rad or N/m; of a spin none.
    pub stiffness: Field<f64>,
    /// Damping of each joint, N m s/rad or N s/m.
    pub damping: Field<f64>,
    /// Of a row that bends: stiffness of each joint across its axis, N m/rad. Without it, as of a solid rod with this stiffness. Only soft rods
    /// give way there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideways: Option<Field<f64>>,
    /// The same against being twisted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torsion: Option<Field<f64>>,
    /// Where it rests, and begins, rad or m; of a row from base to tip: where its springs pull it if nothing drives it. Beyond the range these
    /// press on its end.
    pub neutral: Field<f64>,
    /// Where a passive joint stands as a motion begins, rad or m; of a row from base to tip. Without it, at `neutral`, or at the end of
    /// the range that is nearest to that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub begins: Option<Field<f64>>,
    /// Of a part: a point of the axis in the frame of the part, m. Without it, the port by which the part is held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pivot: Option<Field<[f64; 3]>>,
}

impl Joint {
    /// Whether it may rest, or begin, elsewhere than where it is attached.
    #[must_use]
    pub fn rests_elsewhere(&self) -> bool {
        self.neutral != Field::Fixed(0.0)
            || self.begins.as_ref().is_some_and(|begins| *begins != Field::Fixed(0.0))
    }
}

/// What a joint lets one segment do against the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// It turns about an axis across the row.
    Bend,
    /// It turns about the row.
    Twist,
    /// It moves along an axis.
    Slide,
    /// It turns about an axis, on and on.
    Spin,
    /// It turns about every axis, as a ball in its socket. Nothing drives it.
    Socket,
}

/// The axes that have names.
pub const NAMED_AXES: [(&str, [f64; 3]); 3] =
    [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];

impl JointKind {
    /// Every one, in the order of the reference.
    pub const ALL: [Self; 5] = [Self::Bend, Self::Twist, Self::Slide, Self::Spin, Self::Socket];

    /// The axis of the joint in a mirror that turns the z axis of its frame round: a turn goes the same way about z and the other way
    /// about x and y, a slide the same way along x and y.
    #[must_use]
    pub fn axis_in_mirror(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Slide => [x, y, -z],
            Self::Bend | Self::Twist | Self::Spin | Self::Socket => [-x, -y, z],
        }
    }

    /// How a grammar writes it.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Bend => "bend",
            Self::Twist => "twist",
            Self::Slide => "slide",
            Self::Spin => "spin",
            Self::Socket => "socket",
        }
    }

    /// What it does, as part of a sentence: "an actuator that bends".
    #[must_use]
    pub fn does(self) -> &'static str {
        match self {
            Self::Bend => "bends",
            Self::Twist => "twists",
            Self::Slide => "slides",
            Self::Spin => "spins",
            Self::Socket => "turns in a socket",
        }
    }

    /// The kind that a grammar writes like this.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.text() == text)
    }

    /// The word before its axis; none for a twist, whose axis is the row, and for a socket.
    #[must_use]
    pub fn axis_word(self) -> Option<&'static str> {
        match self {
            Self::Bend | Self::Spin => Some("about"),
            Self::Slide => Some("along"),
            Self::Twist | Self::Socket => None,
        }
    }

    /// The axis of a joint that names none.
    #[must_use]
    pub fn usual_axis(self) -> [f64; 3] {
        match self {
            Self::Bend => [0.0, 0.0, 1.0],
            Self::Twist | Self::Slide | Self::Spin | Self::Socket => [1.0, 0.0, 0.0],
        }
    }

    /// How a grammar writes it with the axis that it usually has.
    #[must_use]
    pub fn example(self) -> &'static str {
        match self {
            Self::Bend => "bend about z",
            Self::Twist => "twist",
            Self::Slide => "slide along x",
            Self::Spin => "spin about x",
            Self::Socket => "socket",
        }
    }

    /// Of where it stands.
    #[must_use]
    pub fn position(self) -> Dimension {
        if self == Self::Slide { Dimension::LENGTH } else { Dimension::ANGLE }
    }

    /// Of how fast it moves.
    #[must_use]
    pub fn speed(self) -> Dimension {
        if self == Self::Slide { Dimension::VELOCITY } else { Dimension::ANGULAR_VELOCITY }
    }

    /// Of what drives it: where it is to stand, or of a spin how fast it is to turn.
    #[must_use]
    pub fn driven(self) -> Dimension {
        if self == Self::Spin { self.speed() } else { self.position() }
    }

    /// What an actuation calls that: `drive angle = ...`.
    #[must_use]
    pub fn driven_word(self) -> &'static str {
        match self {
            Self::Bend | Self::Twist | Self::Socket => "angle",
            Self::Slide => "distance",
            Self::Spin => "speed",
        }
    }

    /// Of its torque or force.
    #[must_use]
    pub fn effort(self) -> Dimension {
        if self == Self::Slide { Dimension::FORCE } else { Dimension::TORQUE }
    }

    /// Of its stiffness.
    #[must_use]
    pub fn stiffness(self) -> Dimension {
        if self == Self::Slide { Dimension::STIFFNESS } else { Dimension::ANGULAR_STIFFNESS }
    }

    /// Of its damping.
    #[must_use]
    pub fn damping(self) -> Dimension {
        if self == Self::Slide { Dimension::DAMPING } else { Dimension::ANGULAR_DAMPING }
    }

    /// The field that says how far it goes.
    #[must_use]
    pub fn range(self) -> &'static str {
        if self == Self::Bend { "bend" } else { "range" }
    }

    /// The field that says how fast it goes.
    #[must_use]
    pub fn speed_field(self) -> &'static str {
        if self == Self::Bend { "bending_speed" } else { "speed" }
    }

    /// The field that says how strong it is.
    #[must_use]
    pub fn effort_field(self) -> &'static str {
        if self == Self::Bend { "torque" } else { "effort" }
    }
}

/// What an actuator does that is driven by this: "of what slides".
#[must_use]
pub fn moved_by(driven: &str) -> &'static str {
    match driven {
        "distance" => "slides",
        "speed" => "spins",
        _ => "bends or twists",
    }
}

/// What an actuation can drive of an actuator, and the type of it.
pub const DRIVEN: [(&str, Ty); 4] = [
    ("angle", Ty::Quantity(Dimension::ANGLE)),
    ("distance", Ty::Quantity(Dimension::LENGTH)),
    ("speed", Ty::Quantity(Dimension::ANGULAR_VELOCITY)),
    ("valves", Ty::Valves),
];
