//! Shapes of elements, and their geometry.
//!
//! What a solver, a picture or a file makes of a shape is theirs; what is true of the shape itself stands here.

use nalgebra::{Isometry3, Point3, Vector3};

/// The geometry of an element, centred on its origin, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A box with half its edge lengths along x, y and z.
    Box {
        /// Half of each edge.
        half: Vector3<f64>,
    },
    /// A ball.
    Ball {
        /// Its radius.
        radius: f64,
    },
    /// A cylinder whose axis is the local x axis.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Half of its length along x.
        half_length: f64,
    },
}

impl Shape {
    /// What people call it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Box { .. } => "box",
            Self::Ball { .. } => "ball",
            Self::Cylinder { .. } => "cylinder",
        }
    }

    /// How far it reaches from its centre along its own x, y and z, m.
    #[must_use]
    pub fn half_extents(&self) -> Vector3<f64> {
        match *self {
            Self::Box { half } => half,
            Self::Ball { radius } => Vector3::repeat(radius),
            Self::Cylinder { radius, half_length } => Vector3::new(half_length, radius, radius),
        }
    }

    /// The radius of the ball about its centre that holds it, m.
    #[must_use]
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Box { half } => half.norm(),
            Self::Ball { radius } => radius,
            Self::Cylinder { radius, half_length } => libm::hypot(radius, half_length),
        }
    }

    /// Its longest edge, length or diameter, m.
    #[must_use]
    pub fn longest(&self) -> f64 {
        2.0 * self.half_extents().max()
    }

    /// The height of its lowest point in a pose, m.
    #[must_use]
    pub fn lowest(&self, pose: &Isometry3<f64>) -> f64 {
        let up = pose.rotation.inverse() * Vector3::y();
        let reach = match *self {
            Self::Box { half } => half.dot(&up.abs()),
            Self::Ball { radius } => radius,
            Self::Cylinder { radius, half_length } => {
                half_length * up.x.abs() + radius * (1.0 - up.x * up.x).max(0.0).sqrt()
            }
        };
        pose.translation.vector.y - reach
    }

    /// Whether a point of its own frame is within it, or no farther outside than this along one of its sizes, m.
    #[must_use]
    pub fn holds(&self, point: &Point3<f64>, slack: f64) -> bool {
        let near = |at: f64, half: f64| at.abs() <= half + slack;
        match *self {
            Self::Box { half } => near(point.x, half.x) && near(point.y, half.y) && near(point.z, half.z),
            Self::Ball { radius } => near(point.coords.norm(), radius),
            Self::Cylinder { radius, half_length } => {
                near(point.x, half_length) && near(libm::hypot(point.y, point.z), radius)
            }
        }
    }

    /// Its principal moments of inertia about its centre, evenly filled with a mass in kg, kg m^2.
    #[must_use]
    pub fn moments(&self, mass: f64) -> Vector3<f64> {
        match *self {
            Self::Box { half } => {
                let square = half.component_mul(&half) / 3.0;
                mass * Vector3::new(square.y + square.z, square.x + square.z, square.x + square.y)
            }
            Self::Ball { radius } => Vector3::repeat(0.4 * mass * radius * radius),
            Self::Cylinder { radius, half_length } => {
                let across = mass * (radius * radius / 4.0 + half_length * half_length / 3.0);
                Vector3::new(0.5 * mass * radius * radius, across, across)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    const ALL: [Shape; 3] = [
        Shape::Box { half: Vector3::new(0.01, 0.02, 0.03) },
        Shape::Ball { radius: 0.02 },
        Shape::Cylinder { radius: 0.01, half_length: 0.03 },
    ];

    /// Points of the inside, evenly over a grid.
    fn inside(shape: &Shape) -> Vec<Point3<f64>> {
        let n = 60;
        let half = shape.half_extents();
        let at = |i: usize, half: f64| half * ((2 * i + 1) as f64 / n as f64 - 1.0);
        let grid = (0..n * n * n)
            .map(|i| Point3::new(at(i % n, half.x), at(i / n % n, half.y), at(i / (n * n), half.z)));
        grid.filter(|point| shape.holds(point, 0.0)).collect()
    }

    #[test]
    fn what_a_shape_says_of_itself_is_true_of_the_points_that_it_holds() {
        let turn = UnitQuaternion::from_euler_angles(0.4, -0.9, 1.3);
        let pose = Isometry3::from_parts(Translation3::new(0.1, 0.2, -0.3), turn);
        for shape in ALL {
            let points = inside(&shape);
            let mean =
                |of: &dyn Fn(&Point3<f64>) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
            let moments = [(1, 2), (0, 2), (0, 1)].map(|(a, b)| mean(&|p| p[a] * p[a] + p[b] * p[b]));
            let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 0.02, "{shape:?}: {a}, {b}");
            moments.iter().zip(&shape.moments(1.0)).for_each(|(a, b)| close(*a, *b));
            let farthest = points.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
            assert!(farthest <= shape.reach() && farthest > 0.93 * shape.reach(), "{shape:?}");
            let lowest = points.iter().map(|p| (pose * p).y).fold(f64::INFINITY, f64::min);
            let bottom = shape.lowest(&pose);
            assert!(bottom <= lowest && lowest - bottom < 0.002, "{shape:?}: {bottom}, {lowest}");
        }
        assert_eq!(ALL.map(|shape| shape.longest()), [0.06, 0.04, 0.06]);
    }
}
