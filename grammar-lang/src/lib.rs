//! The `sgc` grammar language: from text to a typed rule set.
//!
//! Pure: no file system, clock, random numbers or terminal. Texts come from a
//! [`source::World`]; findings are data.

pub mod diagnostics;
pub mod eval;
pub mod ir;
pub mod source;
pub mod syntax;
pub mod units;
