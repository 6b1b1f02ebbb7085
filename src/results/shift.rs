//! The world of a simulation, shifted.

use crate::design::assembly::{Assembly, JointKind};
use crate::simulate::Settings;

/// A body or a ground that is not quite what was thought: a factor for one of its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shift {
    /// Friction of the parts with the ground and each other.
    Friction(f64),
    /// No friction at all.
    Ice,
    /// The masses of all parts.
    Mass(f64),
    /// Largest torque, stiffness and damping of the servos.
    Motors(f64),
}

impl Shift {
    pub(super) fn apply(self, assembly: &mut Assembly, settings: &mut Settings) {
        match self {
            Self::Ice => Self::Friction(0.0).apply(assembly, settings),
            Self::Friction(factor) => {
                settings.ground_friction *= factor;
                assembly.elements.iter_mut().for_each(|element| element.friction *= factor);
            }
            Self::Mass(factor) => assembly.elements.iter_mut().for_each(|element| element.mass *= factor),
            Self::Motors(factor) => {
                for joint in &mut assembly.joints {
                    if let JointKind::Hinge(hinge) = &mut joint.kind {
                        hinge.torque *= factor;
                        hinge.stiffness *= factor;
                        hinge.damping *= factor;
                    }
                }
                assembly.swellings.iter_mut().for_each(|swelling| swelling.gain *= factor);
            }
        }
    }
}
