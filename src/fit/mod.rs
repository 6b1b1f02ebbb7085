//! Hinges from materials: what the actuators of a grammar say of their construction, computed with finite elements, and written as a
//! variant.

mod actuator;
mod text;

pub use actuator::{Constructed, NotFitted, kinds};
pub use text::{summary, variant};
