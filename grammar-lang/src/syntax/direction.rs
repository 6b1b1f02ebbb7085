//! Whether more of a value is better, or less.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Which way an objective goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// More is better.
    #[default]
    Maximize,
    /// Less is better.
    Minimize,
}

impl Direction {
    /// A value on a scale where more is better; the same again gives the value back.
    #[must_use]
    pub fn fitness(self, value: f64) -> f64 {
        match self {
            Self::Maximize => value,
            Self::Minimize => -value,
        }
    }

    /// The better end of a range.
    #[must_use]
    pub fn better(self, least: f64, greatest: f64) -> f64 {
        match self {
            Self::Maximize => greatest,
            Self::Minimize => least,
        }
    }

    /// A value that lost something of a size that is not negative.
    #[must_use]
    pub fn worse_by(self, value: f64, lost: f64) -> f64 {
        match self {
            Self::Maximize => value - lost,
            Self::Minimize => value + lost,
        }
    }
}

/// The word of the language.
impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Maximize => "maximize",
            Self::Minimize => "minimize",
        })
    }
}
