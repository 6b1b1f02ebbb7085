//! Which points of the body may touch the ground.

use nalgebra::{UnitQuaternion, Vector3};

use super::links::Place;
use crate::design::assembly::Shape;
use crate::simulate::lowering::Piece;

/// Points of a rim that are fixed to it: what stands on its end stands on them.
const FAN: usize = 4;

/// A point that may touch the ground in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub(super) body: usize,
    /// Where it is, m.
    pub(super) point: Vector3<f64>,
    /// The number that remembers its impulse.
    pub(super) slot: usize,
}

/// The part of an element that faces the ground.
#[derive(Clone, Debug)]
pub(super) struct Sole {
    body: usize,
    /// The centre of the element, and its turn, in the frame of its body.
    centre: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    shape: Shape,
    /// Whether it is a slice of a beam: others lie before and behind it.
    is_slice: bool,
    first: usize,
}

impl Sole {
    /// That of an element whose points have numbers from this one on.
    pub(super) fn new(piece: &Piece, is_slice: bool, first: usize) -> Self {
        let (centre, turn) = (piece.local.translation.vector, piece.local.rotation);
        Self { body: piece.body, centre, turn, shape: piece.shape, is_slice, first }
    }

    /// How many points it has.
    pub(super) fn slots(&self) -> usize {
        match self.shape {
            Shape::Box { .. } => 8,
            Shape::Ball { .. } => 1,
            Shape::Capsule { .. } => 2,
            Shape::Cylinder { .. } if self.is_slice => 1,
            Shape::Cylinder { .. } => 2 * (1 + FAN),
        }
    }

    /// The number of its first point.
    pub(super) fn first(&self) -> usize {
        self.first
    }

    /// Hands over the points that are lower than a margin, m.
    pub(super) fn find(&self, place: &Place, margin: f64, found: &mut impl FnMut(Near)) {
        let centre = place.centre + place.turn * self.centre;
        if centre.y - self.shape.reach() > margin {
            return;
        }
        let turn = place.turn * self.turn;
        let mut add = |number: usize, way: Vector3<f64>| {
            let point = centre + way;
            if point.y < margin {
                found(Near { body: self.body, point, slot: self.first + number });
            }
        };
        match self.shape {
            Shape::Ball { radius } => add(0, Vector3::y() * -radius),
            Shape::Capsule { radius, half_straight } => {
                for (number, x) in [half_straight, -half_straight].into_iter().enumerate() {
                    add(number, turn * (Vector3::x() * x) - Vector3::y() * radius);
                }
            }
            Shape::Box { half } => {
                for number in 0..8 {
                    let sign = |bit: usize| if number >> bit & 1 == 0 { 1.0 } else { -1.0 };
                    add(number, turn * half.component_mul(&Vector3::new(sign(0), sign(1), sign(2))));
                }
            }
            Shape::Cylinder { radius, half_length } => {
                let axis = turn * Vector3::x();
                let down = axis * axis.y - Vector3::y();
                let length = down.norm();
                // Upright, no point of the rim is the lowest, and those that are fixed carry.
                let lowest = (length > 1e-3).then(|| down * (radius / length));
                if self.is_slice {
                    lowest.into_iter().for_each(|lowest| add(0, lowest));
                    return;
                }
                for (end, x) in [half_length, -half_length].into_iter().enumerate() {
                    let first = end * (1 + FAN);
                    lowest.into_iter().for_each(|lowest| add(first, axis * x + lowest));
                    if length < 0.5 {
                        for number in 0..FAN {
                            let (sin, cos) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][number];
                            let rim = Vector3::new(0.0, cos * radius, sin * radius);
                            add(first + 1 + number, axis * x + turn * rim);
                        }
                    }
                }
            }
        }
    }
}
