//! What a floor without friction may not do to a body: carry it away, or turn it about the vertical. It pushes upwards only, so neither
//! the centre of mass nor the vertical part of the angular momentum can change, and a motion begins at rest.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::Motion;
use super::sliding::{half_turn, rotation_vector};
use crate::design::assembly::{Assembly, Element};

impl Motion {
    /// How far the centre of mass of the body that this is the motion of ever gets from where it began, along the ground, m.
    #[must_use]
    pub fn drift(&self, body: &Assembly) -> f64 {
        let start = centre(body, &self.elements(0));
        let away = (0..self.frames()).map(|frame| centre(body, &self.elements(frame)) - start);
        away.map(|way| libm::hypot(way.x, way.z)).fold(0.0, f64::max)
    }

    /// How far angular momentum ever turns the body about the vertical through its centre of mass, rad: the sum, over the frames, of
    /// angular momentum over moment of inertia. A body that reorients itself by bending, as a falling cat does, has neither.
    #[must_use]
    pub fn spin(&self, body: &Assembly) -> f64 {
        let (mut before, mut round, mut furthest) = (self.elements(0), 0.0, 0.0_f64);
        for frame in 1..self.frames() {
            let after = self.elements(frame);
            round += turn(body, &before, &after);
            furthest = furthest.max(round.abs());
            before = after;
        }
        furthest
    }

    /// The poses of all elements in a frame.
    fn elements(&self, frame: usize) -> Vec<Isometry3<f64>> {
        let bodies = self.poses.iter().skip(frame * self.bodies).take(self.bodies).collect::<Vec<_>>();
        let of = |body: usize| bodies.get(body).copied().copied().unwrap_or_else(Isometry3::identity);
        self.placements.iter().map(|own| of(own.body) * own.local).collect()
    }
}

/// The centre of mass of a body with its elements in these poses, m.
fn centre(body: &Assembly, poses: &[Isometry3<f64>]) -> Vector3<f64> {
    let mass: f64 = body.elements.iter().map(|element| element.mass).sum();
    let moments = body.elements.iter().zip(poses).map(|(own, pose)| pose.translation.vector * own.mass);
    moments.sum::<Vector3<f64>>() / mass
}

/// By how much the angular momentum between two frames turns a body about the vertical through its centre of mass, rad. Both the
/// angular momentum and the moment of inertia are those half way.
fn turn(body: &Assembly, from: &[Isometry3<f64>], to: &[Isometry3<f64>]) -> f64 {
    let (before, after) = (centre(body, from), centre(body, to));
    let (mut momentum, mut inertia) = (0.0, 0.0);
    for ((element, from), to) in body.elements.iter().zip(from).zip(to) {
        let (a, b) = (from.translation.vector - before, to.translation.vector - after);
        let (middle, way) = ((a + b) / 2.0, b - a);
        momentum += element.mass * (middle.z * way.x - middle.x * way.z);
        inertia += element.mass * (middle.x * middle.x + middle.z * middle.z);
        let (spun, own) = about_the_vertical(element, from, to);
        momentum += spun;
        inertia += own;
    }
    if inertia > 0.0 { momentum / inertia } else { 0.0 }
}

/// The vertical part of moment of inertia times turn of an element about its own centre, kg m^2, and its moment of inertia about the
/// vertical, kg m^2.
fn about_the_vertical(element: &Element, from: &Isometry3<f64>, to: &Isometry3<f64>) -> (f64, f64) {
    let moments = Vector3::from(element.shape.moments(element.mass));
    let turn = rotation_vector(&(to.rotation * from.rotation.inverse()));
    let middle = UnitQuaternion::new_unchecked(half_turn(&(turn / 2.0))) * from.rotation;
    let (up, turn) = (middle.inverse() * Vector3::y(), middle.inverse() * turn);
    (up.dot(&moments.component_mul(&turn)), up.dot(&moments.component_mul(&up)))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::design::assembly::Shape;
    use crate::simulate::motion::Placement;

    /// Two boxes side by side that turn about the vertical through a point between them at these speeds, rad/s: the boxes about their own
    /// centres, and both together.
    fn turning(own: [f64; 2], together: f64) -> (Motion, Assembly) {
        let shape = Shape::Box { half: Vector3::new(0.03, 0.01, 0.02) };
        let at = |body: usize| [-0.05, 0.07][body];
        let element = |body: usize| Element {
            shape,
            pose: Isometry3::translation(at(body), 0.0, 0.0),
            mass: 0.1,
            friction: 0.5,
        };
        let about = |angle: f64| Isometry3::rotation(Vector3::y() * angle);
        let pose = |t: f64, body: usize| {
            about(together * t) * Isometry3::translation(at(body), 0.0, 0.0) * about(own[body] * t)
        };
        let motion = Motion {
            interval: 1.0 / 60.0,
            duration: 1.0,
            bodies: 2,
            poses: (0..=60)
                .flat_map(|frame| [0, 1].map(|body| pose(f64::from(frame) / 60.0, body)))
                .collect(),
            bends: Vec::new(),
            work: Vec::new(),
            commands: None,
            placements: [0, 1].map(|body| Placement::new(body, Isometry3::identity(), shape)).into(),
        };
        (motion, Assembly { elements: vec![element(0), element(1)], ..Assembly::default() })
    }

    #[test]
    fn what_turns_as_a_whole_spins() {
        for speed in [0.1, -0.5 * PI, 12.0] {
            let (motion, body) = turning([0.0, 0.0], speed);
            let spin = motion.spin(&body);
            assert!((spin - speed.abs()).abs() < 4e-3 * speed.abs(), "{spin} at {speed}");
        }
    }

    #[test]
    fn what_turns_against_each_other_does_not_spin() {
        let (motion, body) = turning([3.0, -3.0], 0.0);
        assert!(motion.spin(&body) < 1e-12, "{}", motion.spin(&body));
    }
}
