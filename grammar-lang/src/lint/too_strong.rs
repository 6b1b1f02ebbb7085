//! Motors with a torque that nothing of their weight has.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Made;
use crate::ir::{JointKind, Kind};
use crate::units::{Dimension, shown};

use super::instances::made;
use super::known::Known;

/// The torque of a motor for its mass, N m/kg. The best motors with gears of robots have about 100; hobby servos and small gear motors 10 to 30
/// (data sheets of Pololu, Dynamixel and Harmonic Drive; written down without the sheets at hand).
const MOST: f64 = 500.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, actuator) in known.ruleset.actuators.iter().filter(|(_, a)| a.joint.kind == JointKind::Spin) {
        let ratio = |(torque, mass): &(f64, f64)| torque / mass;
        let motors = made(known, Kind::Actuator(actuator)).map(|(_, made)| match made {
            Ok(Made::Actuator(made)) => Some((made.motor.as_ref()?.effort, made.mass)),
            _ => None,
        });
        // The weakest for its weight: what is told is so of all.
        let weakest = motors
            .collect::<Option<Vec<_>>>()
            .and_then(|all| all.into_iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b))));
        if let Some((torque, mass)) = weakest.filter(|one| ratio(one) > MOST) {
            findings.push(
                Diagnostic::new(Code::UNUSUAL, actuator.span, format!("`{name}` is far too strong for its weight"))
                    .label(format!(
                        "{} with a segment of {}",
                        shown(torque, Dimension::TORQUE),
                        shown(mass, Dimension::MASS)
                    ))
                    .help("motors with gears have 10 to 100 N*m for each kg: check the units of `effort` and `mass`"),
            );
        }
    }
}
