//! Shapes and their geometry.
//!
//! What a solver, a picture or a file makes of a shape is theirs; what is true of the shape itself stands here.
//! How grammars write shapes is in `ir/form.rs`.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Vector3};

/// The geometry of a rigid piece, centred on its origin, in metres.
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
    /// A cylinder whose ends are half balls: all that is no farther than its radius from a piece of the local x axis.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Half of that piece of the axis: half of its length without the ends.
        half_straight: f64,
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
            Self::Capsule { .. } => "capsule",
        }
    }

    /// How far it reaches from its centre along its own x, y and z, m.
    #[must_use]
    pub fn half_extents(&self) -> Vector3<f64> {
        match *self {
            Self::Box { half } => half,
            Self::Ball { radius } => Vector3::repeat(radius),
            Self::Cylinder { radius, half_length } => Vector3::new(half_length, radius, radius),
            Self::Capsule { radius, half_straight } => Vector3::new(half_straight + radius, radius, radius),
        }
    }

    /// Its volume, m^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        match *self {
            Self::Box { half } => 8.0 * (half.x * half.y * half.z),
            Self::Ball { radius } => 4.0 / 3.0 * PI * radius * radius * radius,
            Self::Cylinder { radius, half_length } => PI * radius * radius * (2.0 * half_length),
            Self::Capsule { radius, half_straight } => {
                PI * radius * radius * (2.0 * half_straight + 4.0 / 3.0 * radius)
            }
        }
    }

    /// The radius of the ball about its centre that holds it, m.
    #[must_use]
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Box { half } => half.norm(),
            Self::Ball { radius } => radius,
            Self::Cylinder { radius, half_length } => libm::hypot(radius, half_length),
            Self::Capsule { radius, half_straight } => half_straight + radius,
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
        pose.translation.vector.y - self.extent(&up)
    }

    /// How far it goes from its centre along a unit vector of its own frame, m.
    #[must_use]
    pub fn extent(&self, along: &Vector3<f64>) -> f64 {
        match *self {
            Self::Box { half } => half.dot(&along.abs()),
            Self::Ball { radius } => radius,
            Self::Cylinder { radius, half_length } => {
                half_length * along.x.abs() + radius * (1.0 - along.x * along.x).max(0.0).sqrt()
            }
            Self::Capsule { radius, half_straight } => half_straight * along.x.abs() + radius,
        }
    }

    /// Whether a point of its own frame is within it, or no farther outside than this along one of its sizes, m.
    #[must_use]
    pub fn holds(&self, point: &Point3<f64>, slack: f64) -> bool {
        self.inset(point) >= -slack
    }

    /// How far a point of its own frame is within it along that of its sizes where this is least, m; negative outside.
    #[must_use]
    pub fn inset(&self, point: &Point3<f64>) -> f64 {
        match *self {
            Self::Box { half } => (half - point.coords.abs()).min(),
            Self::Ball { radius } => radius - point.coords.norm(),
            Self::Cylinder { radius, half_length } => {
                (half_length - point.x.abs()).min(radius - libm::hypot(point.y, point.z))
            }
            Self::Capsule { radius, half_straight } => {
                let beyond = (point.x.abs() - half_straight).max(0.0);
                radius - Vector3::new(beyond, point.y, point.z).norm()
            }
        }
    }

    /// How far its surface lies from a point of its own frame that is within it, along a unit vector, m; nothing from elsewhere.
    #[must_use]
    pub fn depth(&self, point: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
        let (mut inside, mut outside) = (0.0, 4.0 * self.longest());
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            if self.holds(&(point + direction * middle), 0.0) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }

    /// Whether it is round about its x axis, so that no turn about it can be seen; a ball is round about every axis.
    #[must_use]
    pub fn is_round(&self) -> bool {
        match self {
            Self::Box { .. } => false,
            Self::Ball { .. } | Self::Cylinder { .. } | Self::Capsule { .. } => true,
        }
    }

    /// The point of its own frame with which it touches the ground in a pose: of an edge or a face that lies flat,
    /// within about an angle in rad, the middle.
    #[must_use]
    pub fn sole(&self, pose: &Isometry3<f64>, flat: f64) -> Point3<f64> {
        let down = -(pose.rotation.inverse() * Vector3::y());
        let side = |along: f64| (along / flat).clamp(-1.0, 1.0);
        Point3::from(match *self {
            Self::Box { half } => half.component_mul(&down.map(side)),
            Self::Ball { radius } => down * radius,
            Self::Cylinder { radius, half_length } => {
                let around = Vector3::new(0.0, down.y, down.z);
                let width = around.norm();
                // What stands on its end touches with the middle of it.
                let out = if width > 0.0 { around / width * (radius * side(width)) } else { around };
                Vector3::new(half_length * side(down.x), 0.0, 0.0) + out
            }
            Self::Capsule { radius, half_straight } => {
                Vector3::new(half_straight * side(down.x), 0.0, 0.0) + down * radius
            }
        })
    }

    /// How far the ends of the edge or the corners of the face that lies flat are from its [middle](Self::sole), m; zero of a point.
    #[must_use]
    pub fn sole_reach(&self, pose: &Isometry3<f64>, flat: f64) -> f64 {
        let down = -(pose.rotation.inverse() * Vector3::y());
        let lies = |along: f64| 1.0 - (along / flat).abs().min(1.0);
        match *self {
            Self::Box { half } => half.component_mul(&down.map(lies)).norm(),
            Self::Ball { .. } => 0.0,
            Self::Cylinder { radius, half_length } => {
                let width = libm::hypot(down.y, down.z);
                libm::hypot(half_length * lies(down.x), radius * lies(width))
            }
            Self::Capsule { half_straight, .. } => half_straight * lies(down.x),
        }
    }

    /// Its surface for a picture.
    #[must_use]
    pub fn outline(&self) -> Outline {
        match *self {
            Self::Box { half } => {
                Outline { faces: (0..6).map(|side| box_side(half, side)).collect(), balls: Vec::new() }
            }
            Self::Ball { radius } => Outline { faces: Vec::new(), balls: vec![(Point3::origin(), radius)] },
            Self::Cylinder { radius, half_length } => {
                let caps = [-half_length, half_length].map(|x| cap(radius, x));
                Outline { faces: wall(radius, half_length).chain(caps).collect(), balls: Vec::new() }
            }
            Self::Capsule { radius, half_straight } => Outline {
                faces: wall(radius, half_straight).collect(),
                balls: [-half_straight, half_straight].map(|x| (Point3::new(x, 0.0, 0.0), radius)).to_vec(),
            },
        }
    }

    /// The lengths that tell it from others of its [`Shape::name`], m.
    #[must_use]
    pub fn lengths(&self) -> Vec<f64> {
        match *self {
            Self::Box { half } => vec![half.x, half.y, half.z],
            Self::Ball { radius } => vec![radius],
            Self::Cylinder { radius, half_length } => vec![radius, half_length],
            Self::Capsule { radius, half_straight } => vec![radius, half_straight],
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
            Self::Capsule { radius, half_straight } => {
                let square = radius * radius;
                let straight = Self::Cylinder { radius, half_length: half_straight };
                // The ends together are a ball that is taken apart along x.
                let share = straight.volume() / self.volume();
                let (middle, ends) = (straight.moments(share * mass), (1.0 - share) * mass);
                let apart = half_straight * (half_straight + 0.75 * radius);
                middle + ends * Vector3::new(0.4 * square, 0.4 * square + apart, 0.4 * square + apart)
            }
        }
    }
}

/// The surface of a shape, in its own frame: flat pieces, and balls that show where nothing is before them.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// The flat pieces.
    pub faces: Vec<Face>,
    /// Centres and radii of the balls, m.
    pub balls: Vec<(Point3<f64>, f64)>,
}

/// A flat piece of a surface.
#[derive(Clone, Debug)]
pub struct Face {
    /// Its corners in order, m.
    pub corners: Vec<Point3<f64>>,
    /// Where it looks.
    pub normal: Vector3<f64>,
}

/// Corners of what is round.
pub const CORNERS: usize = 16;

/// A direction around the x axis: of so many, the i-th.
#[must_use]
pub fn around(i: usize, many: usize) -> Vector3<f64> {
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / many as f64);
    Vector3::new(0.0, cos, sin)
}

fn box_side(half: Vector3<f64>, side: usize) -> Face {
    let axis = side % 3;
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let sign = if side < 3 { 1.0 } else { -1.0 };
    let corner = |a: f64, b: f64| {
        let mut at = Vector3::zeros();
        (at[axis], at[u], at[v]) = (sign * half[axis], a * half[u], b * half[v]);
        Point3::from(at)
    };
    let mut normal = Vector3::zeros();
    normal[axis] = sign;
    Face { corners: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], normal }
}

/// A point of a rim about the x axis.
fn rim(radius: f64, x: f64, i: usize) -> Point3<f64> {
    Point3::from(around(i, CORNERS) * radius + Vector3::new(x, 0.0, 0.0))
}

/// What is between two rims.
fn wall(radius: f64, half: f64) -> impl Iterator<Item = Face> {
    (0..CORNERS).map(move |i| Face {
        corners: [(-half, i), (half, i), (half, i + 1), (-half, i + 1)]
            .map(|(x, i)| rim(radius, x, i))
            .to_vec(),
        normal: around(2 * i + 1, 2 * CORNERS),
    })
}

/// What is within a rim.
fn cap(radius: f64, x: f64) -> Face {
    let corners = (0..CORNERS).map(|i| rim(radius, x, i)).collect();
    Face { corners, normal: Vector3::new(x / x.abs().max(1e-12), 0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    const ALL: [Shape; 4] = [
        Shape::Box { half: Vector3::new(0.01, 0.02, 0.03) },
        Shape::Ball { radius: 0.02 },
        Shape::Cylinder { radius: 0.01, half_length: 0.03 },
        Shape::Capsule { radius: 0.02, half_straight: 0.03 },
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
            let [x, y, z]: [f64; 3] = shape.half_extents().into();
            close(8.0 * x * y * z * points.len() as f64 / f64::from(60 * 60 * 60), shape.volume());
            let farthest = points.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
            assert!(farthest <= shape.reach() && farthest > 0.93 * shape.reach(), "{shape:?}");
            let lowest = points.iter().map(|p| (pose * p).y).fold(f64::INFINITY, f64::min);
            let bottom = shape.lowest(&pose);
            assert!(bottom <= lowest && lowest - bottom < 0.002, "{shape:?}: {bottom}, {lowest}");
        }
        assert_eq!(ALL.map(|shape| shape.longest()), [0.06, 0.04, 0.06, 0.1]);
    }
}
