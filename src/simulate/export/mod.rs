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
/// part is held. `elements` are the names of the parts that the elements belong to.
fn joint_names(lowered: &Lowered, elements: &[String]) -> Vec<String> {
    let mut counted: BTreeMap<&str, usize> = BTreeMap::new();
    // Between the degrees of freedom of a socket are bodies without elements: the part comes behind them.
    let owner = |body: usize| {
        let mut whole = lowered.bodies.iter().enumerate().skip(body).filter(|(_, body)| !body.is_massless());
        let (whole, _) = whole.next()?;
        let element = lowered.pieces.iter().position(|piece| piece.body == whole)?;
        elements.get(element).map(String::as_str)
    };
    let dofs = lowered.bodies.iter().enumerate().filter_map(|(i, body)| Some((i, body.dof.as_ref()?)));
    let named = dofs.map(|(body, dof)| {
        let owner = owner(body).unwrap_or("part");
        let number = counted.entry(owner).or_default();
        *number += 1;
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
