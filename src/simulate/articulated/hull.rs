//! The shapes of elements as collisions see them.
//!
//! Every shape is its core plus a rounding: a ball is a point, a capsule a line, boxes and cylinders
//! are shrunk by a fifth of their smallest half size, so faces stay where they
//! are and only edges are rounded. The closest points of two cores are found
//! by alternating projections (von Neumann): the closest point of a box,
//! cylinder, line or point is a closed form, and going to and fro between two convex
//! sets converges to their distance.

use super::kinematics::Frame;
use super::scalar::Scalar;
use super::tree::LENGTH;
use super::vector::{M3, V3};
use crate::design::assembly::Shape;
use crate::simulate::lowering::Piece;

/// How much of the smallest half size is rounding.
const ROUNDING: f64 = 0.2;
/// Of an axis and a radius of a cylinder, that which the other body is towards by more than this (cos 45 deg) is its side.
const TOWARDS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The shrunk shape about its centre.
#[derive(Clone, Copy, Debug)]
enum Core<S> {
    Point,
    /// Half sizes.
    Box(V3<S>),
    /// Half length along x and radius.
    Cylinder(S, S),
    /// Half length along x.
    Line(S),
}

impl<S: Scalar> Core<S> {
    #[inline(always)]
    fn closest(&self, p: V3<S>) -> V3<S> {
        let clamp = |value: S, most: S| value.min(most).max(-most);
        match *self {
            Self::Point => V3::null(p.kit()),
            Self::Box(half) => V3([clamp(p[0], half[0]), clamp(p[1], half[1]), clamp(p[2], half[2])]),
            Self::Cylinder(half_length, radius) => {
                let square = p[1] * p[1] + p[2] * p[2];
                let outside = (radius * radius).less(square);
                let k = S::pick(outside, radius / square.sqrt(), radius.like(1.0));
                V3([clamp(p[0], half_length), p[1] * k, p[2] * k])
            }
            Self::Line(half_length) => {
                let zero = p[0].like(0.0);
                V3([clamp(p[0], half_length), zero, zero])
            }
        }
    }

    /// A point of the rim of the face that looks along a unit vector, by its number below four.
    #[inline(always)]
    fn rim(&self, towards: V3<S>, number: usize) -> V3<S> {
        let k = |value: f64| towards[0].like(value);
        let zero = k(0.0);
        let (first, second) = (k([-1.0, 1.0][number & 1]), k([-1.0, 1.0][number >> 1]));
        let side = |along: S, half: S| S::pick(along.less(zero), -half, half);
        match *self {
            Self::Point => V3::null(towards.kit()),
            Self::Line(half_length) => V3([first * half_length, zero, zero]),
            Self::Box(half) => {
                let [x, y, z] = towards.0.map(S::abs);
                let is_x = y.at_most(x) & z.at_most(x);
                let is_y = !is_x & z.at_most(y);
                let is_z = !is_x & !is_y;
                V3([
                    S::pick(is_x, side(towards[0], half[0]), first * half[0]),
                    S::pick(is_y, side(towards[1], half[1]), S::pick(is_x, first, second) * half[1]),
                    S::pick(is_z, side(towards[2], half[2]), second * half[2]),
                ])
            }
            Self::Cylinder(half_length, radius) => {
                let is_end = k(TOWARDS).less(towards[0].abs());
                let across = (towards[1] * towards[1] + towards[2] * towards[2]).sqrt().max(k(1e-6));
                let (on_rim, on_side) = (radius * k(TOWARDS), radius / across);
                V3([
                    S::pick(is_end, side(towards[0], half_length), first * half_length),
                    S::pick(is_end, first * on_rim, towards[1] * on_side),
                    S::pick(is_end, second * on_rim, towards[2] * on_side),
                ])
            }
        }
    }
}

/// An element as the collision sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull<S> {
    pub(super) body: usize,
    pub(super) centre: V3<S>,
    /// Element axes in the body's frame.
    rotation: M3<S>,
    core: Core<S>,
    pub(super) rounding: S,
    /// Radius of a ball that holds all of it.
    pub(super) reach: S,
}

impl<S: Scalar> Hull<S> {
    /// Of an element in SI units.
    pub(super) fn new(kit: S::Kit, piece: &Piece) -> Self {
        let of = |metres: f64| S::of(kit, metres * LENGTH);
        let turn = piece.local.rotation.to_rotation_matrix();
        let m = turn.matrix();
        let (core, rounding) = match piece.shape {
            Shape::Box { half } => {
                let rounding = half.min() * ROUNDING;
                (Core::Box(V3([0, 1, 2].map(|axis| of(half[axis] - rounding)))), rounding)
            }
            Shape::Ball { radius } => (Core::Point, radius),
            Shape::Cylinder { radius, half_length } => {
                let rounding = radius.min(half_length) * ROUNDING;
                (Core::Cylinder(of(half_length - rounding), of(radius - rounding)), rounding)
            }
            Shape::Capsule { radius, half_straight } => (Core::Line(of(half_straight)), radius),
        };
        Self {
            body: piece.body,
            centre: V3::constant(kit, (piece.local.translation.vector * LENGTH).into()),
            rotation: M3([0, 1, 2].map(|row| V3::constant(kit, [m[(row, 0)], m[(row, 1)], m[(row, 2)]]))),
            core,
            rounding: of(rounding),
            reach: of(piece.shape.reach()),
        }
    }

    /// On how many points of the rim of a face it can lie.
    pub(super) fn rim(&self) -> usize {
        match self.core {
            Core::Point => 0,
            Core::Line(_) => 2,
            Core::Box(_) | Core::Cylinder(..) => 4,
        }
    }
}

/// Where a hull is now.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a, S> {
    pub(super) hull: &'a Hull<S>,
    pub(super) centre: V3<S>,
    rotation: M3<S>,
}

impl<'a, S: Scalar> Placed<'a, S> {
    #[inline(always)]
    pub(super) fn new(hull: &'a Hull<S>, frame: &Frame<S>) -> Self {
        let centre = frame.centre + frame.rotation * hull.centre;
        Self { hull, centre, rotation: frame.rotation * hull.rotation }
    }

    /// The point of its core that is closest to another one.
    #[inline(always)]
    pub(super) fn closest(&self, p: V3<S>) -> V3<S> {
        let local = self.rotation.transposed(p - self.centre);
        self.centre + self.rotation * self.hull.core.closest(local)
    }

    /// A point of the rim of the face of its core that looks along a unit vector, by its number below [`Hull::rim`].
    #[inline(always)]
    pub(super) fn rim(&self, towards: V3<S>, number: usize) -> V3<S> {
        self.centre + self.rotation * self.hull.core.rim(self.rotation.transposed(towards), number)
    }
}

/// The closest points of two cores, starting from a point of the second.
///
/// Where faces meet at a small angle the alternation creeps along them in a
/// geometric series. Each round therefore ends with a jump to the limit of that
/// series (Aitken), taken back where the cores are further apart there.
#[inline(always)]
pub(super) fn project<S: Scalar>(
    a: &Placed<'_, S>,
    b: &Placed<'_, S>,
    start: V3<S>,
    rounds: usize,
) -> (V3<S>, V3<S>) {
    let mut on_b = start;
    let mut on_a = a.closest(on_b);
    for _ in 0..rounds {
        let first = b.closest(on_a);
        let second = b.closest(a.closest(first));
        let (before, after) = (first - on_b, second - first);
        (on_a, on_b) = (a.closest(second), second);
        let k = |value: f64| start[0].like(value);
        let ratio = before.dot(after) / (before.square() + k(1e-12));
        let ratio = ratio.max(k(0.0)).min(k(0.98));
        let jump = b.closest(second + after * (ratio / (k(1.0) - ratio)));
        let there = a.closest(jump);
        let (way, other) = (on_a - on_b, there - jump);
        let closer = other.square().less(way.square());
        (on_a, on_b) = (V3::pick(closer, there, on_a), V3::pick(closer, jump, on_b));
    }
    (on_a, b.closest(on_a))
}
