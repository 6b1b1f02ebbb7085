//! Mirror images of parts and ports.
//!
//! The image of a part has the mirrored x and y axes and so, to stay
//! right-handed, the opposite of the mirrored z axis: its left and right are
//! swapped, and an actuator that bends by the same angle about its own z axis
//! moves as the mirror image does.

use grammar_lang::ir::{RuleSet, Shape, Symmetry};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::port::ports;
use super::{Design, Part, PartId, Refusal};

/// Places closer than this (m) are the same.
pub(super) const SAME: f64 = 1e-7;

/// A reflection in a plane through the origin.
pub(super) struct Mirror {
    flip: Matrix3<f64>,
}

/// The reflection of a symmetry, if it has one.
pub(super) fn mirror(symmetry: Symmetry) -> Option<Mirror> {
    let Symmetry::Mirror(normal) = symmetry else { return None };
    let mut flip = Matrix3::identity();
    if let Some(entry) = flip.get_mut((normal, normal)) {
        *entry = -1.0;
    }
    Some(Mirror { flip })
}

impl Mirror {
    fn point(&self, point: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.flip * point.coords)
    }

    /// The pose of a part's image.
    pub(super) fn image(&self, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let own = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
        let rotation = self.flip * pose.rotation.to_rotation_matrix().matrix() * own;
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Isometry3::from_parts((self.flip * pose.translation.vector).into(), rotation)
    }

    /// Whether a part looks the same in the mirror.
    pub(super) fn keeps(&self, rules: &RuleSet, part: &Part) -> bool {
        let image = self.image(&part.pose);
        if (image.translation.vector - part.pose.translation.vector).norm() > SAME {
            return false;
        }
        let have = part.pose.rotation.to_rotation_matrix();
        let want = image.rotation.to_rotation_matrix();
        match rules.parts.get(&part.kind).map(|p| p.shape) {
            Some(Shape::Sphere(_)) => true,
            Some(Shape::Box(edges)) => {
                // Every edge must lie along an edge of the same length.
                let relative = want.matrix().transpose() * have.matrix();
                (0..3).all(|i| {
                    (0..3).any(|j| relative[(i, j)].abs() > 1.0 - 1e-6 && (edges[i] - edges[j]).abs() < SAME)
                })
            }
            _ => (have.matrix() - want.matrix()).norm() < 1e-6,
        }
    }
}

/// The port that a port's reflection is: on the part's image, at the reflected place.
pub(super) fn image_port(
    design: &Design,
    rules: &RuleSet,
    mirror: &Mirror,
    id: PartId,
    port: u8,
) -> Result<(PartId, u8), Refusal> {
    let part = design.parts.get(&id).ok_or(Refusal::Gone)?;
    let frame = ports(rules, part).get(port as usize).ok_or(Refusal::Gone)?.frame;
    let wanted = mirror.point(&(part.pose * Point3::from(frame.translation.vector)));
    let twin_id = design.twin(id);
    let twin = design.parts.get(&twin_id).ok_or(Refusal::Gone)?;
    ports(rules, twin)
        .iter()
        .position(|p| ((twin.pose * Point3::from(p.frame.translation.vector)) - wanted).norm() < SAME)
        .map(|found| (twin_id, found as u8))
        .ok_or(Refusal::Asymmetric)
}
