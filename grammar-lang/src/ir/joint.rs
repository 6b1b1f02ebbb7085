//! The joints of an actuator's row.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Ty;
use crate::units::Dimension;

/// How the segments of a row move against each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// What they do.
    pub kind: JointKind,
    /// About or along what, a unit vector in the frame of the row: x from base to tip, y its top.
    pub axis: [f64; 3],
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
}

impl Joint {
    /// What rows do that say nothing else: a positive bend is towards their top.
    pub const BEND: Self = Self { kind: JointKind::Bend, axis: [0.0, 0.0, 1.0] };
}

impl fmt::Display for Joint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.kind.text())?;
        if let Some(word) = self.kind.axis_word() {
            let named = NAMED_AXES.iter().find(|(_, axis)| *axis == self.axis);
            match named {
                Some((name, _)) => write!(f, " {word} {name}")?,
                None => write!(f, " {word} vector({})", self.axis.map(|x| x.to_string()).join(", "))?,
            }
        }
        Ok(())
    }
}

/// The axes that have names.
pub const NAMED_AXES: [(&str, [f64; 3]); 3] =
    [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];

impl JointKind {
    /// Every one, in the order of the reference.
    pub const ALL: [Self; 4] = [Self::Bend, Self::Twist, Self::Slide, Self::Spin];

    /// How a grammar writes it.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Bend => "bend",
            Self::Twist => "twist",
            Self::Slide => "slide",
            Self::Spin => "spin",
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
        }
    }

    /// The kind that a grammar writes like this.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.text() == text)
    }

    /// The word before its axis; none for a twist, whose axis is the row.
    #[must_use]
    pub fn axis_word(self) -> Option<&'static str> {
        match self {
            Self::Bend | Self::Spin => Some("about"),
            Self::Slide => Some("along"),
            Self::Twist => None,
        }
    }

    /// The axis of a row that names none.
    #[must_use]
    pub fn usual_axis(self) -> [f64; 3] {
        match self {
            Self::Bend => Joint::BEND.axis,
            Self::Twist | Self::Slide | Self::Spin => [1.0, 0.0, 0.0],
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
            Self::Bend | Self::Twist => "angle",
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

/// What an actuation can drive of an actuator, and the type of it.
pub const DRIVEN: [(&str, Ty); 4] = [
    ("angle", Ty::Quantity(Dimension::ANGLE)),
    ("distance", Ty::Quantity(Dimension::LENGTH)),
    ("speed", Ty::Quantity(Dimension::ANGULAR_VELOCITY)),
    ("valves", Ty::Valves),
];
