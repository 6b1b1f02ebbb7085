//! Images of parts and ports under a symmetry.
//!
//! A symmetry is a cyclic group of isometries about the core's centre: the
//! identity and its images. The image of a part under a reflection has the
//! mirrored x and y axes and so, to stay right-handed, the opposite of the
//! mirrored z axis: its left and right are swapped, and an actuator that bends by
//! the same angle about its own z axis moves as the mirror image does.

use grammar_lang::eval::Made;
use grammar_lang::ir::{Form, JointKind, RuleSet, Symmetry};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::assembly::Shape;
use super::port::{self, PortFrame, ports};
use super::{Design, Part, PartId, Refusal};

/// Places closer than this (m) are the same.
pub(super) const SAME: f64 = 1e-7;

/// One isometry of a symmetry, other than the identity.
pub(super) struct Image {
    matrix: Matrix3<f64>,
    reflects: bool,
}

/// Whether a part is seen in the mirror: its frame has the opposite of the mirrored z axis.
pub(super) fn is_reflected(rules: &RuleSet, image: u8) -> bool {
    image > 0 && matches!(rules.symmetry, Symmetry::Mirror(_))
}

/// The isometries of a symmetry in order, without the identity.
pub(super) fn images(symmetry: Symmetry) -> Vec<Image> {
    match symmetry {
        Symmetry::None => Vec::new(),
        Symmetry::Mirror(normal) => {
            let mut matrix = Matrix3::identity();
            if let Some(entry) = matrix.get_mut((normal, normal)) {
                *entry = -1.0;
            }
            vec![Image { matrix, reflects: true }]
        }
        Symmetry::Radial(count, axis) => (1..count)
            .map(|k| {
                let angle = 2.0 * std::f64::consts::PI * k as f64 / count as f64;
                let matrix = port::about(axis, angle).to_rotation_matrix().into_inner();
                Image { matrix, reflects: false }
            })
            .collect(),
    }
}

impl Image {
    /// Whether it swaps left and right.
    pub(super) fn reflects(&self) -> bool {
        self.reflects
    }

    fn point(&self, point: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.matrix * point.coords)
    }

    /// The pose of a part's image.
    pub(super) fn pose(&self, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let hand = if self.reflects { -1.0 } else { 1.0 };
        let own = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, hand));
        let rotation = self.matrix * pose.rotation.to_rotation_matrix().matrix() * own;
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Isometry3::from_parts((self.matrix * pose.translation.vector).into(), rotation)
    }

    /// Whether what a part's joint moves is its own image: its axis lies where the axis of its image does, and where the image moves to
    /// the other side, it neither begins there nor presses to there.
    fn keeps_joint(&self, part: &Part) -> bool {
        let (joint, anchor) = match part.made.as_ref() {
            Made::Block(block) if part.held_by.is_some() => {
                let Some(joint) = &block.joint else { return true };
                let side = if self.reflects && part.image > 0 { -1.0 } else { 1.0 };
                let pivot = joint.pivot.map(|[x, y, z]| part.pose * Point3::new(x, y, side * z));
                (joint, pivot.unwrap_or_else(|| port::base(part, &part.pose)))
            }
            // Its joints lie on its x axis, which is compared with the rest of its frame.
            Made::Actuator(row) => (&row.joint, Point3::from(part.pose.translation.vector)),
            Made::Block(_) | Made::Cell(_) => return true,
        };
        let axis = part.pose.rotation * Vector3::from(joint.axis);
        // A reflection turns turns round.
        let hand = if joint.kind != JointKind::Slide && self.reflects { -1.0 } else { 1.0 };
        let image = self.matrix * axis * hand;
        let is_same = |other: Vector3<f64>| (other - axis).norm() < 1e-6;
        let is_kept = is_same(image) || is_same(-image) && joint.neutral == 0.0 && joint.start() == 0.0;
        let moved = self.point(&anchor) - anchor;
        match joint.kind {
            JointKind::Socket => moved.norm() < SAME,
            JointKind::Slide => is_kept,
            JointKind::Bend | JointKind::Twist | JointKind::Spin => {
                is_kept && (moved - axis * axis.dot(&moved)).norm() < SAME
            }
        }
    }

    /// Whether a part is its own image.
    pub(super) fn keeps(&self, part: &Part) -> bool {
        let image = self.pose(&part.pose);
        if (image.translation.vector - part.pose.translation.vector).norm() > SAME {
            return false;
        }
        if !self.keeps_joint(part) {
            return false;
        }
        let have = part.pose.rotation.to_rotation_matrix();
        let want = image.rotation.to_rotation_matrix();
        let relative = want.matrix().transpose() * have.matrix();
        let form = match part.made.as_ref() {
            Made::Block(block) => Some(block.form),
            // A round row on the axis that all its joints turn about or slide along, as far as that is an axis of symmetry.
            Made::Actuator(row) if !self.reflects && row.segment.shape.is_round() => {
                let is_along = row.joint.axis[0].abs() > 1.0 - 1e-6 && !row.segment.stands;
                return is_along && relative[(0, 0)] > 1.0 - 1e-6;
            }
            Made::Actuator(_) | Made::Cell(_) => None,
        };
        match form {
            Some(Form { shape: Shape::Ball { .. }, .. }) => true,
            Some(Form { shape: Shape::Box { half }, .. }) => {
                // Every edge must lie along an edge of the same length.
                (0..3).all(|i| {
                    (0..3).any(|j| {
                        relative[(i, j)].abs() > 1.0 - 1e-6 && 2.0 * (half[i] - half[j]).abs() < SAME
                    })
                })
            }
            Some(Form { shape, stands }) if shape.is_round() => {
                let axis = usize::from(stands);
                relative[(axis, axis)].abs() > 1.0 - 1e-6
            }
            _ => (have.matrix() - want.matrix()).norm() < 1e-6,
        }
    }
}

/// The image number `k` (from 1) of a port: on the part's image, at the image of its place.
pub(super) fn image_port(
    design: &Design,
    rules: &RuleSet,
    k: usize,
    image: &Image,
    id: PartId,
    port: u8,
) -> Result<(PartId, u8), Refusal> {
    let part = design.parts.get(&id).ok_or(Refusal::Gone)?;
    let PortFrame { frame, name: named, .. } =
        ports(part).into_iter().nth(port as usize).ok_or(Refusal::Gone)?;
    let wanted = image.point(&(part.pose * Point3::from(frame.translation.vector)));
    let twin_id = design.image(rules, id, k);
    let twin = design.parts.get(&twin_id).ok_or(Refusal::Gone)?;
    ports(twin)
        .iter()
        .position(|p| ((twin.pose * Point3::from(p.frame.translation.vector)) - wanted).norm() < SAME)
        .map(|found| (twin_id, found as u8))
        .ok_or_else(|| Refusal::NoImage { kind: part.kind.clone(), port: named.clone() })
}

/// The port by which the image of a part in the mirror is held, where the part itself is held by this one: the port on the other side of
/// its frame. A part whose kind has no such port has mirrored ports, and is held by the same one.
pub(super) fn mirrored_port(image: &Part, port: u8) -> u8 {
    if image.is_mirrored() {
        return port;
    }
    let frames = ports(image);
    let Some(own) = frames.get(port as usize) else { return port };
    let place = own.frame.translation.vector;
    let wanted = Vector3::new(place.x, place.y, -place.z);
    let found = frames.iter().position(|p| (p.frame.translation.vector - wanted).norm() < SAME);
    // What lies on the plane is its own image, whatever else is there.
    if place.z.abs() < SAME { port } else { found.map_or(port, |found| found as u8) }
}
