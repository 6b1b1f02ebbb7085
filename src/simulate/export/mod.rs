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

pub use drive::drive;
pub use mjcf::{MODEL_MARK, mjcf};
pub use motion::{motion, read_motion};

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
