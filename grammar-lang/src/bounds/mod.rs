//! What can be said of an expression before there is a design: numbers as
//! intervals, truth as always, never or sometimes.
//!
//! Everything here is sound: it claims only what holds for every design that
//! the grammar can make, whatever its parameters are set to. What it cannot
//! follow may be anything.

mod call;
mod exclude;
mod facts;
mod interval;
mod kinds;
pub mod linear;
mod locals;
mod reason;
mod value;

pub use facts::Facts;
pub use interval::Interval;
pub use kinds::{Begun, Kinds};
pub use locals::{Repeated, actuation_locals, conjuncts, locals_of, narrowed_locals_of, state_locals};
pub use reason::{Asked, Lacking, Never, Reasoning};
pub use value::{Abstract, Truth};
