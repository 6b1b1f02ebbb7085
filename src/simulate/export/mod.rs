//! What the solvers simulate, as text for other programs.
//!
//! Everything comes from the same lowered bodies and servos as the solvers'
//! own, so that a difference in the result is one of the method.

mod drive;
mod mjcf;
mod motion;
#[cfg(test)]
mod tests;
mod xml;

use std::collections::BTreeMap;

use super::lowering::Lowered;
pub use drive::drive;
pub use mjcf::mjcf;
pub use motion::{NotMotion, motion, read_motion};

/// What the hinges of lowered bodies are called, in their order: `bender-1.hinge0`, counted from the end by which the
/// actuator is held.
fn hinge_names(lowered: &Lowered, actuators: &[String]) -> Vec<String> {
    let mut counted: BTreeMap<usize, usize> = BTreeMap::new();
    let hinges = lowered.bodies.iter().filter_map(|body| body.hinge.as_ref());
    let named = hinges.map(|hinge| {
        let number = counted.entry(hinge.actuator).or_default();
        *number += 1;
        let actuator = actuators.get(hinge.actuator).map_or("actuator", String::as_str);
        format!("{actuator}.hinge{}", *number - 1)
    });
    named.collect()
}

/// A number as short as it can be and still be read back exactly.
fn number(value: f64) -> String {
    // Adding zero leaves no negative zero.
    let value = value + 0.0;
    if value != 0.0 && (value.abs() < 1e-4 || value.abs() >= 1e9) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
