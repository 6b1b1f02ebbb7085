//! Outputs by the names that are printed on the board.

use std::fmt;
use std::str::FromStr;
use thiserror::Error;

use serde::{Deserialize, Serialize};

/// An output of the board, D3 to D12 or A0 to A5, as Arduino names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Pin(u8);

impl Pin {
    /// All outputs: sixteen, two valves for each of eight actuators.
    pub fn all() -> impl Iterator<Item = Self> {
        (3..=12).chain(14..=19).map(Self)
    }

    /// Its number in the protocol: 0 to 13 for D0 to D13, then 14 to 19 for A0 to A5.
    #[must_use]
    pub fn number(self) -> u8 {
        self.0
    }
}

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            number @ 0..=13 => write!(f, "D{number}"),
            number => write!(f, "A{}", number - 14),
        }
    }
}

/// Why a name is of no pin that a valve or servo can have.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NoPin {
    /// No board has it.
    #[error("there is no pin {0}: use D3 to D12 or A0 to A5")]
    Unknown(String),
    /// The board needs it itself.
    #[error("{name} {taken}: use D3 to D12 or A0 to A5")]
    Taken {
        /// Its name.
        name: String,
        /// What it is.
        taken: &'static str,
    },
}

impl FromStr for Pin {
    type Err = NoPin;

    /// Reads a name such as `D3` or `A0`, in small or large letters.
    ///
    /// # Errors
    ///
    /// Says which pins there are, and what the pin asked for is used for if the board needs it itself.
    fn from_str(text: &str) -> Result<Self, NoPin> {
        let name = text.trim().to_ascii_uppercase();
        if let Some(pin) = Self::all().find(|pin| pin.to_string() == name) {
            return Ok(pin);
        }
        let taken = match name.as_str() {
            "D0" | "D1" => "is the serial line",
            "D2" => "is the stop circuit",
            "D13" => "is the lamp, which blinks at each reset: a valve there would click",
            "A6" | "A7" => "can only be read, on boards that have it",
            _ => return Err(NoPin::Unknown(text.to_owned())),
        };
        Err(NoPin::Taken { name, taken })
    }
}

impl TryFrom<String> for Pin {
    type Error = NoPin;

    fn try_from(text: String) -> Result<Self, NoPin> {
        text.parse()
    }
}

impl From<Pin> for String {
    fn from(pin: Pin) -> Self {
        pin.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written() {
        // Those that a grammar may name.
        let names: Vec<String> = Pin::all().map(|pin| pin.to_string()).collect();
        assert_eq!(names, grammar_lang::ir::PINS);
        for pin in Pin::all() {
            assert_eq!(pin.to_string().parse(), Ok(pin));
        }
        assert_eq!("a5".parse::<Pin>().map(Pin::number), Ok(19));
    }

    #[test]
    fn pins_that_are_taken_say_by_what() {
        for (name, why) in
            [("D0", "serial"), ("D2", "stop"), ("D13", "lamp"), ("D14", "no pin"), ("", "no pin")]
        {
            let error = name.parse::<Pin>().unwrap_err().to_string();
            assert!(error.contains(why) && error.contains("D3 to D12"), "{error}");
        }
    }
}
