//! The world of a motion: how it differs from what model and design say.

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

use super::Settings;
use crate::design::assembly::Assembly;

/// Where a body moves, and what of the body is not quite as it was designed. Plain data: every solver applies
/// the same worlds.
///
/// What an actuator is asked for (its lateness, the pressure of a supply) is part of the
/// [`Targets`](super::Targets) already; only the rates of servos are limited by the solvers, and so are here.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Factor of the Coulomb coefficient of every contact, also of the body with itself.
    pub friction: f64,
    /// The Coulomb coefficient of the ground in place of that of the settings.
    pub ground_friction: Option<f64>,
    /// Factor of masses and moments of inertia.
    pub mass: f64,
    /// Factor of the greatest torques of servos. Their stiffness and damping stay.
    pub torque: f64,
    /// Factor of the rates of servos.
    pub speed: f64,
    /// By how much the ground rises towards +x, rad. Gravity is turned, so that heights stay above the ground.
    pub slope: f64,
    /// By how much the body is turned about its core before it is set on the ground, rad.
    pub tilt: f64,
    /// About which level axis, as an angle from +x towards -z, rad.
    pub heading: f64,
}

impl World {
    /// What model and design say.
    pub const NOMINAL: Self = Self {
        friction: 1.0,
        ground_friction: None,
        mass: 1.0,
        torque: 1.0,
        speed: 1.0,
        slope: 0.0,
        tilt: 0.0,
        heading: 0.0,
    };

    /// The coefficient of a contact between a part and the ground.
    pub(super) fn grip(&self, part: f64, settings: &Settings) -> f64 {
        (part * self.ground_friction.unwrap_or(settings.ground_friction)).sqrt() * self.friction
    }

    /// Gravity as the ground sees it, m/s^2; y points away from the ground.
    pub(super) fn gravity(&self, settings: &Settings) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(self.slope);
        Vector3::new(0.0 - sin * settings.gravity, -cos * settings.gravity, 0.0)
    }

    /// How the body is turned before it is set on the ground.
    pub(super) fn turn(&self) -> UnitQuaternion<f64> {
        let (sin, cos) = libm::sincos(self.tilt / 2.0);
        let (z, x) = libm::sincos(self.heading);
        UnitQuaternion::new_unchecked(Quaternion::new(cos, x * sin, 0.0, 0.0 - z * sin))
    }

    /// A vector of the body, turned like that; the same to the bit where the body is not.
    pub(super) fn turned(&self, vector: Vector3<f64>) -> Vector3<f64> {
        if self.tilt == 0.0 { vector } else { self.turn() * vector }
    }

    /// The body and the settings that have in the nominal world what these have in this one; all but the slope.
    ///
    /// The body is turned about the centre of its core element.
    pub(super) fn made(&self, assembly: &Assembly, settings: &Settings) -> (Assembly, Settings) {
        let (mut body, mut settings) = (assembly.clone(), settings.clone());
        // A contact has the root of the product of two coefficients.
        settings.ground_friction = self.ground_friction.unwrap_or(settings.ground_friction) * self.friction;
        let core = body.elements.first().map_or_else(Vector3::zeros, |core| core.pose.translation.vector);
        let turn = self.turn();
        let about = |place: Vector3<f64>| core + turn * (place - core);
        for element in &mut body.elements {
            element.mass *= self.mass;
            element.friction *= self.friction;
            if self.tilt != 0.0 {
                element.pose.translation.vector = about(element.pose.translation.vector);
                element.pose.rotation = turn * element.pose.rotation;
            }
        }
        for dof in body.joints.iter_mut().flat_map(|joint| joint.kind.dofs_mut()) {
            dof.effort *= self.torque;
            dof.control = dof.control.faster(self.speed);
            if self.tilt != 0.0 {
                dof.anchor = Point3::from(about(dof.anchor.coords));
                dof.axis = turn * dof.axis;
            }
        }
        (body, settings)
    }
}
