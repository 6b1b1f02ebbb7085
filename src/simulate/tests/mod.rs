//! What all solvers must get right, and the bodies to try them on.

pub(crate) mod bodies;
mod feedback;
mod joints;
mod keeps;
pub(crate) mod lattices;
mod report;
mod truth;
mod work;
mod worlds;

use super::Settings;

/// The solvers that take hinges.
pub(crate) const HINGED: [&str; 3] = ["articulated", "rapier", "rod"];

/// The settings of the measurements.
pub(crate) fn settings() -> Settings {
    Settings {
        step: 1.0 / 240.0,
        duration: 20.0,
        record: 0.1,
        gravity: 9.81,
        ground_friction: 0.8,
        iterations: 8,
        tolerance: 1e-3,
        self_collision: true,
        speed_limit: 10.0,
        pace_limit: None,
    }
}
