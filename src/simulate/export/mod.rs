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
use crate::design::assembly::Travel;
pub use drive::drive;
pub use mjcf::mjcf;
pub use motion::{NotMotion, motion, read_motion};

/// What the joints of lowered bodies are called, in their order: `bender-1.hinge0`, counted from the end by which the
/// actuator is held. Those that nothing drives are counted together.
fn joint_names(lowered: &Lowered, actuators: &[String]) -> Vec<String> {
    let mut counted: BTreeMap<Option<usize>, usize> = BTreeMap::new();
    let dofs = lowered.bodies.iter().filter_map(|body| body.dof.as_ref());
    let named = dofs.map(|dof| {
        let number = counted.entry(dof.actuator()).or_default();
        *number += 1;
        let owner = match dof.actuator() {
            Some(actuator) => actuators.get(actuator).map_or("actuator", String::as_str),
            None => "passive",
        };
        let what = match dof.travel {
            Travel::Turn => "hinge",
            Travel::Slide => "slide",
        };
        format!("{owner}.{what}{}", *number - 1)
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
