//! Dimensions and units.

mod dimension;
mod table;

pub use dimension::Dimension;
pub use table::{
    Unit, UnitError, display_unit, exact, parse, quantity, shown, suggest, unit_names, written_out,
};

/// No number of a text, and no value of an objective or a term, is larger, in SI units: sums of its square over all designs of a run
/// still have a value.
pub const LARGEST: f64 = 1e100;
