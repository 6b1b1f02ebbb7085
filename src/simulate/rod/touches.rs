//! Which parts of the body touch each other: closest points by the geometry library, one contact for each pair.

use nalgebra::{Isometry3, Vector3};
use parry3d_f64::query;

use super::discs::Discs;
use super::links::Place;
use crate::design::assembly::solid::{Solid, pose};
use crate::simulate::lowering::{Lowered, Piece};

/// Elements that are no farther than this from each other at rest, m, are made to meet there: they do not collide.
const MEET: f64 = 1e-3;
/// Slices of one beam collide where they are so many times its radius apart along it.
const APART: f64 = 3.0;

/// Two elements that may touch.
#[derive(Clone, Copy, Debug)]
struct Pair {
    first: usize,
    second: usize,
}

/// Two bodies that may touch in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) bodies: (usize, usize),
    /// The two elements.
    pub(super) pieces: (usize, usize),
    /// Between the two surfaces, m.
    pub(super) point: Vector3<f64>,
    /// From the second to the first.
    pub(super) normal: Vector3<f64>,
    /// How far the surfaces are apart, m; negative where they overlap.
    pub(super) gap: f64,
    /// The number of the pair.
    pub(super) pair: usize,
}

/// All pairs that may touch.
#[derive(Clone, Debug)]
pub(super) struct Touches {
    solids: Vec<(Solid, f64)>,
    pairs: Vec<Pair>,
}

impl Touches {
    /// The pairs of a refined assembly.
    pub(super) fn new(discs: &Discs, lowered: &Lowered) -> Self {
        let pieces = &lowered.pieces;
        let solids: Vec<(Solid, f64)> =
            pieces.iter().map(|piece| (Solid::new(&piece.shape, 1.0), piece.shape.reach())).collect();
        let rest = |piece: &Piece| {
            let body = Isometry3::from_parts(
                lowered.bodies[piece.body].centre.into(),
                nalgebra::UnitQuaternion::identity(),
            );
            pose(&(body * piece.local), &piece.shape)
        };
        let poses: Vec<_> = pieces.iter().map(rest).collect();
        // Where a slice is along its beam, m, and the radius of the beam.
        let along = |piece: usize| {
            discs.beams.iter().enumerate().find_map(|(beam, own)| {
                let disc = own.discs.iter().position(|disc| *disc == piece)?;
                let at = own.length() * disc as f64 / own.links() as f64;
                let radius = (own.section.area / std::f64::consts::PI).sqrt();
                Some((beam, at, radius))
            })
        };
        // What is one body with an end of a beam is there.
        let by_end = |beam: usize, piece: usize| {
            let own = &discs.beams[beam];
            let (base, tip) = (own.discs[0], own.discs[own.links()]);
            let body = pieces[piece].body;
            let at = [(base, 0.0), (tip, own.length())];
            at.into_iter().find(|(end, _)| pieces[*end].body == body).map(|(_, at)| at)
        };
        let mut pairs = Vec::new();
        for first in 0..pieces.len() {
            for second in 0..first {
                let is_joint = || lowered.are_joined(first, second);
                if pieces[first].body == pieces[second].body || is_joint() {
                    continue;
                }
                let near = |one: usize, other: usize| {
                    let Some((beam, at, radius)) = along(one) else { return false };
                    let there = match along(other) {
                        Some((same, at, _)) if same == beam => Some(at),
                        _ => by_end(beam, other),
                    };
                    there.is_some_and(|there| (at - there).abs() < APART * radius)
                };
                if near(first, second) || near(second, first) {
                    continue;
                }
                let (a, b) = (solids[first].0, solids[second].0);
                let meet = query::contact(&poses[first], a.shape(), &poses[second], b.shape(), MEET);
                if !matches!(meet, Ok(Some(_))) {
                    pairs.push(Pair { first, second });
                }
            }
        }
        Self { solids, pairs }
    }

    /// How many pairs there are.
    pub(super) fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Hands over the pairs that are closer than a margin of each element, m.
    pub(super) fn find(
        &self,
        pieces: &[Piece],
        places: &[Place],
        margins: &[f64],
        found: &mut impl FnMut(Meeting),
    ) {
        let pose_of = |piece: &Piece| {
            let place = &places[piece.body];
            Isometry3::from_parts(place.centre.into(), place.turn) * piece.local
        };
        let poses: Vec<Isometry3<f64>> = pieces.iter().map(pose_of).collect();
        for (number, pair) in self.pairs.iter().enumerate() {
            let margin = margins[pair.first] + margins[pair.second];
            let (first, second) = (&self.solids[pair.first], &self.solids[pair.second]);
            let between = poses[pair.first].translation.vector - poses[pair.second].translation.vector;
            let reach = first.1 + second.1 + margin;
            if between.norm_squared() > reach * reach {
                continue;
            }
            let at = |piece: usize| pose(&poses[piece], &pieces[piece].shape);
            let (a, b) = (first.0, second.0);
            let contact = query::contact(&at(pair.first), a.shape(), &at(pair.second), b.shape(), margin);
            let Ok(Some(contact)) = contact else { continue };
            let vector = |v: parry3d_f64::math::Vector| Vector3::new(v.x, v.y, v.z);
            found(Meeting {
                bodies: (pieces[pair.first].body, pieces[pair.second].body),
                pieces: (pair.first, pair.second),
                point: (vector(contact.point1) + vector(contact.point2)) * 0.5,
                normal: -vector(contact.normal1),
                gap: contact.dist,
                pair: number,
            });
        }
    }
}
