//! Where parts and ports are, as expressions read it, in the frame of the core: in the body as it is attached, with every joint at 0, and
//! as a motion begins.

use grammar_lang::eval::Made;
use grammar_lang::ir::RuleSet;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::port::ports;
use super::{Body, Design, PartId};

/// Places (m) and directions are rounded to this: what is on a plane is not a rounding error beside it.
const GRID: f64 = 1e-9;

impl Design {
    /// Where parts and ports are in the body as it is attached, with every joint at 0.
    #[must_use]
    pub fn attached(&self) -> Posture<'_> {
        Posture { design: self, at_rest: None }
    }

    /// Where they are as a motion begins: passive joints are then where their springs rest, and driven ones where they start.
    #[must_use]
    pub fn at_rest(&self, rules: &RuleSet) -> Posture<'_> {
        Posture { design: self, at_rest: Some(Body::of_parts(self, rules)) }
    }

    /// The height of the lowest point of a part as a motion begins, m: passive joints are then where their springs rest.
    #[must_use]
    pub fn lowest_point(&self, rules: &RuleSet, id: PartId) -> Option<f64> {
        let body = Body::new(self, rules);
        let elements = body.elements_of(id).filter_map(|i| body.assembly.elements.get(i));
        elements.map(|element| element.shape.lowest(&element.pose)).reduce(f64::min).map(rounded)
    }

    /// The corners of the bounding box of a part as a motion begins, m: with the least coordinates, and with the greatest.
    #[must_use]
    pub fn corners(&self, rules: &RuleSet, id: PartId) -> Option<[[f64; 3]; 2]> {
        let body = Body::new(self, rules);
        let mut corners = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        for element in body.elements_of(id).filter_map(|i| body.assembly.elements.get(i)) {
            let at = element.pose.translation.vector;
            let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
            let own = axes.map(|axis| element.shape.extent(&(element.pose.rotation.inverse() * axis)));
            let reach = Vector3::from(own);
            corners = [corners[0].inf(&(at - reach)), corners[1].sup(&(at + reach))];
        }
        corners[0].x.is_finite().then_some(corners.map(|corner| corner.map(rounded).into()))
    }
}

/// A posture of the body: where its parts and ports are.
pub struct Posture<'d> {
    design: &'d Design,
    /// The body that they are of, if it is that with which a motion begins.
    at_rest: Option<Body>,
}

impl Posture<'_> {
    /// The origin of a part's frame, m.
    #[must_use]
    pub fn place(&self, id: PartId) -> Option<[f64; 3]> {
        Some(place(&self.frame(id, 0)?))
    }

    /// The centre of mass of a part, m. Of a row as it is attached, this is the middle between base and tip.
    #[must_use]
    pub fn centre(&self, id: PartId) -> Option<[f64; 3]> {
        let Some(body) = &self.at_rest else {
            let part = self.design.parts.get(&id)?;
            let middle = match part.made.as_ref() {
                Made::Actuator(_) => {
                    let ends = ports(part);
                    let sum: Vector3<f64> = ends.iter().map(|end| end.frame.translation.vector).sum();
                    sum / ends.len() as f64
                }
                _ => Vector3::zeros(),
            };
            return Some(place(&(part.pose * Translation3::from(middle))));
        };
        let elements = || body.elements_of(id).filter_map(|i| body.assembly.elements.get(i));
        let mass: f64 = elements().map(|element| element.mass).sum();
        let moment: Vector3<f64> = elements().map(|e| e.pose.translation.vector * e.mass).sum();
        (mass > 0.0).then(|| place(&Translation3::from(moment / mass).into()))
    }

    /// Where the x, y or z axis (0, 1, 2) of a part points, a unit vector; of an actuator that of its base.
    #[must_use]
    pub fn axis(&self, id: PartId, axis: usize) -> Option<[f64; 3]> {
        let own = [Vector3::x(), Vector3::y(), Vector3::z()];
        Some(direction(&self.frame(id, 0)?, own.get(axis)?))
    }

    /// The place of a port, m.
    #[must_use]
    pub fn place_of_port(&self, id: PartId, port: u8) -> Option<[f64; 3]> {
        Some(place(&self.pose_of_port(id, port)?))
    }

    /// Where a port points, a unit vector.
    #[must_use]
    pub fn facing_of_port(&self, id: PartId, port: u8) -> Option<[f64; 3]> {
        Some(direction(&self.pose_of_port(id, port)?, &Vector3::x()))
    }

    fn pose_of_port(&self, id: PartId, port: u8) -> Option<Isometry3<f64>> {
        Some(self.frame(id, port)? * ports(self.design.parts.get(&id)?).get(port as usize)?.frame)
    }

    /// The frame of a part that one of its ports is given in.
    fn frame(&self, id: PartId, port: u8) -> Option<Isometry3<f64>> {
        let part = self.design.parts.get(&id)?;
        match &self.at_rest {
            Some(body) => body.frame_at_rest(id, part, port),
            None => Some(part.pose),
        }
    }
}

fn rounded(x: f64) -> f64 {
    // The sum takes the sign of a zero away.
    libm::round(x / GRID) * GRID + 0.0
}

fn place(pose: &Isometry3<f64>) -> [f64; 3] {
    Point3::from(pose.translation.vector).coords.map(rounded).into()
}

fn direction(pose: &Isometry3<f64>, of: &Vector3<f64>) -> [f64; 3] {
    (pose.rotation * of).map(rounded).into()
}
