//! The section of a rod: what its shape makes of a material.

use std::f64::consts::PI;

use nalgebra::{UnitVector3, Vector3};

use crate::design::assembly::{Element, Shape};

/// Poisson's ratio of what rods are made of: rubber keeps its volume.
pub(super) const POISSON: f64 = 0.49;

/// Areas and second moments of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Section {
    /// Area, m^2.
    pub(super) area: f64,
    /// Second moment for bending about the driven axis, m^4.
    pub(super) driven: f64,
    /// Second moment for bending about the axis across it, m^4.
    pub(super) sideways: f64,
    /// Torsion constant of Saint-Venant, m^4.
    pub(super) torsion: f64,
    /// Share of the area that counts for shear (Cowper, The Shear Coefficient in Timoshenko's Beam Theory, 1966).
    pub(super) shear: f64,
}

impl Section {
    /// That of an element across a direction, which bends about an axis across that. None where it has no even section.
    pub(super) fn new(element: &Element, way: &UnitVector3<f64>, axis: &UnitVector3<f64>) -> Option<Self> {
        match element.shape {
            Shape::Cylinder { radius, .. } | Shape::Capsule { radius, .. } => Some(Self::round(radius)),
            Shape::Box { half } => {
                let side = |along: Vector3<f64>| half.dot(&(element.pose.rotation.inverse() * along).abs());
                Some(Self::box_of(side(axis.into_inner()), side(way.cross(axis))))
            }
            Shape::Ball { .. } => None,
        }
    }

    /// A disc of a radius in m.
    pub(super) fn round(radius: f64) -> Self {
        let second = PI * radius * radius * radius * radius / 4.0;
        Self {
            area: PI * radius * radius,
            driven: second,
            sideways: second,
            torsion: 2.0 * second,
            shear: 6.0 * (1.0 + POISSON) / (7.0 + 6.0 * POISSON),
        }
    }

    /// A rectangle with half a side along the driven axis and half of the other one, m.
    fn box_of(along: f64, across: f64) -> Self {
        let area = 4.0 * along * across;
        let (long, short) = (along.max(across), along.min(across));
        let slim = short / long;
        // Roark's Formulas for Stress and Strain, table 10.1.
        let torsion = long
            * short
            * short
            * short
            * (16.0 / 3.0 - 3.36 * slim * (1.0 - slim * slim * slim * slim / 12.0));
        Self {
            area,
            driven: area * across * across / 3.0,
            sideways: area * along * along / 3.0,
            torsion,
            shear: 10.0 * (1.0 + POISSON) / (12.0 + 11.0 * POISSON),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Section;

    /// A bar of 2 by 2, and one of 8 by 2: second moments b h^3 / 12, and torsion constants of Saint-Venant (0.1406 a^4, and 0.281 b h^3).
    #[test]
    fn bars_have_the_values_of_the_tables() {
        let near = |found: f64, due: f64| assert!((found / due - 1.0).abs() < 3e-3, "{found} {due}");
        let square = Section::box_of(1.0, 1.0);
        near(square.area, 4.0);
        near(square.driven, 16.0 / 12.0);
        near(square.torsion, 0.1406 * 16.0);
        // It is driven about the long side: across that it is thin.
        let strip = Section::box_of(4.0, 1.0);
        near(strip.driven, 8.0 * 8.0 / 12.0);
        near(strip.sideways, 2.0 * 512.0 / 12.0);
        near(strip.torsion, 0.2808 * 8.0 * 8.0);
        assert_eq!(Section::box_of(1.0, 4.0).driven, strip.sideways);
        assert_eq!(Section::box_of(1.0, 4.0).torsion, strip.torsion);
    }
}
