//! Physical dimensions: integer exponents of five base dimensions.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Exponents of length, mass, time, angle and current.
///
/// Angle is a base dimension on purpose: a forgotten `deg` is the classic bug.
/// A torque is therefore an energy per angle (N*m/rad).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Dimension(pub [i8; 5]);

macro_rules! dimensions {
    ($($constant:ident $name:literal $doc:literal $exponents:expr;)*) => {
        /// Names for people, the commonest first.
        const NAMES: &[(&str, Dimension)] = &[$(($name, Dimension::$constant)),*];

        impl Dimension {
            $(#[doc = $doc] pub const $constant: Self = Self($exponents);)*
        }
    };
}

dimensions! {
    NUMBER "Number" "A bare number." [0, 0, 0, 0, 0];
    LENGTH "Length" "Length." [1, 0, 0, 0, 0];
    MASS "Mass" "Mass." [0, 1, 0, 0, 0];
    TIME "Time" "Time." [0, 0, 1, 0, 0];
    ANGLE "Angle" "Angle." [0, 0, 0, 1, 0];
    CURRENT "Current" "Current." [0, 0, 0, 0, 1];
    AREA "Area" "Area." [2, 0, 0, 0, 0];
    VOLUME "Volume" "Volume." [3, 0, 0, 0, 0];
    VELOCITY "Velocity" "Velocity." [1, 0, -1, 0, 0];
    ACCELERATION "Acceleration" "Acceleration." [1, 0, -2, 0, 0];
    ANGULAR_VELOCITY "AngularVelocity" "Angular velocity." [0, 0, -1, 1, 0];
    FREQUENCY "Frequency" "Frequency." [0, 0, -1, 0, 0];
    FORCE "Force" "Force." [1, 1, -2, 0, 0];
    ENERGY "Energy" "Energy." [2, 1, -2, 0, 0];
    POWER "Power" "Power." [2, 1, -3, 0, 0];
    TORQUE "Torque" "Torque." [2, 1, -2, -1, 0];
    ANGULAR_STIFFNESS "AngularStiffness" "Angular stiffness." [2, 1, -2, -2, 0];
    ANGULAR_DAMPING "AngularDamping" "Angular damping." [2, 1, -1, -2, 0];
    STIFFNESS "Stiffness" "Stiffness." [0, 1, -2, 0, 0];
    DAMPING "Damping" "Damping." [0, 1, -1, 0, 0];
    PRESSURE "Pressure" "Pressure." [-1, 1, -2, 0, 0];
    FLOW_CONDUCTANCE "FlowConductance" "Flow conductance." [4, -1, 1, 0, 0];
    DENSITY "Density" "Density." [-3, 1, 0, 0, 0];
}

impl Dimension {
    /// The dimension with this name, such as `Length` or `Torque`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        NAMES.iter().find(|(n, _)| *n == name).map(|(_, d)| *d)
    }

    /// Every name that a declaration may use.
    pub fn names() -> impl Iterator<Item = &'static str> {
        NAMES.iter().map(|(n, _)| *n)
    }

    /// Whether this is a bare number.
    #[must_use]
    pub fn is_number(self) -> bool {
        self == Self::NUMBER
    }

    /// The dimension of a product; `None` if an exponent grows past all reason.
    #[must_use]
    pub fn times(self, other: Self) -> Option<Self> {
        let mut exponents = self.0;
        for (a, b) in exponents.iter_mut().zip(other.0) {
            *a = a.checked_add(b)?;
        }
        Some(Self(exponents))
    }

    /// The dimension of a power; `None` if an exponent grows past all reason.
    #[must_use]
    pub fn power(self, n: i8) -> Option<Self> {
        let mut exponents = self.0;
        for a in &mut exponents {
            *a = a.checked_mul(n)?;
        }
        Some(Self(exponents))
    }

    /// The dimension of a quotient; `None` if an exponent grows past all reason.
    #[must_use]
    pub fn over(self, other: Self) -> Option<Self> {
        self.times(other.power(-1)?)
    }

    /// The dimension of a square root, if it has one.
    #[must_use]
    pub fn root(self) -> Option<Self> {
        let mut exponents = self.0;
        for a in &mut exponents {
            if *a % 2 != 0 {
                return None;
            }
            *a /= 2;
        }
        Some(Self(exponents))
    }

    /// The product of SI units with this dimension, such as `kg*m^2/s^2`.
    #[must_use]
    pub fn si(self) -> String {
        let symbols = ["m", "kg", "s", "rad", "A"];
        let part = |positive: bool| {
            self.0
                .iter()
                .zip(symbols)
                .filter(|(e, _)| (**e > 0) == positive && **e != 0)
                .map(|(e, s)| if e.abs() == 1 { s.to_owned() } else { format!("{s}^{}", e.unsigned_abs()) })
                .collect::<Vec<_>>()
        };
        let (above, below) = (part(true), part(false));
        let above = if above.is_empty() { "1".to_owned() } else { above.join("*") };
        if below.is_empty() { above } else { format!("{above}/{}", below.join("/")) }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match NAMES.iter().find(|(_, d)| d == self) {
            Some((name, _)) => f.write_str(name),
            None => write!(f, "quantity in {}", self.si()),
        }
    }
}
