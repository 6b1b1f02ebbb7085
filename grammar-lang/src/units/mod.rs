//! Dimensions and units.

mod dimension;
mod table;

pub use dimension::Dimension;
pub use table::{Unit, UnitError, display_unit, parse, shown, suggest, unit_names, written_out};
