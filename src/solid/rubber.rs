//! The energy of rubber in a hexahedron: neo-Hookean, with the change of volume taken at fewer points.
//!
//! `W = G / 2 (J^(-2/3) tr(F^T F) - 3) + K / 2 (J - 1)^2` (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008,
//! 6.5). The second term is taken at eight points where the first takes 27: an element of 27 nodes does not lock then, even
//! if the material keeps its volume (Hughes, The Finite Element Method, 1987, 4.4).

use nalgebra::{Matrix3, SMatrix};

use super::shape::{THREE, TWO, solid};

/// How stiff a material is (Pa).
#[derive(Clone, Copy, Debug)]
pub(super) struct Moduli {
    pub(super) shear: f64,
    pub(super) bulk: f64,
}

impl Moduli {
    /// Those of a material with a Young's modulus (Pa) and a Poisson's ratio.
    pub(super) fn new(young: f64, poisson: f64) -> Self {
        Self { shear: young / (2.0 * (1.0 + poisson)), bulk: young / (3.0 * (1.0 - 2.0 * poisson)) }
    }
}

/// A point of a hexahedron: slopes of its functions at rest (1/m), and the volume that it stands for (m^3).
#[derive(Clone, Debug)]
pub(super) struct GaussPoint {
    slopes: [[f64; 3]; 27],
    volume: f64,
}

/// The points of a hexahedron: those for the change of shape, and those for the change of volume.
#[derive(Clone, Debug)]
pub(super) struct Points {
    shape: Vec<GaussPoint>,
    volume: Vec<GaussPoint>,
}

/// Forces (N) and stiffnesses (N/m) of the 81 degrees of freedom of a hexahedron.
pub(super) type Forces = SMatrix<f64, 81, 1>;
pub(super) type Stiffness = SMatrix<f64, 81, 81>;

impl Points {
    /// Of a hexahedron with these nodes at rest.
    pub(super) fn new(nodes: &[[f64; 3]; 27]) -> Self {
        let at = |rule: &[(f64, f64)]| {
            let mut points = Vec::new();
            for u in rule {
                for t in rule {
                    for s in rule {
                        points.push(point(nodes, [s.0, t.0, u.0], s.1 * t.1 * u.1));
                    }
                }
            }
            points
        };
        Self { shape: at(&THREE), volume: at(&TWO) }
    }

    /// The energy (J) of a hexahedron whose nodes are here; its slope and its curvature are added. None if it is turned inside out.
    pub(super) fn energy(
        &self,
        nodes: &[[f64; 3]; 27],
        moduli: Moduli,
        forces: &mut Forces,
        stiffness: &mut Stiffness,
    ) -> Option<f64> {
        let mut energy = 0.0;
        for point in &self.shape {
            let f = gradient(&point.slopes, nodes);
            let jacobian = f.determinant();
            if jacobian <= 0.0 {
                return None;
            }
            let g = f.try_inverse()?.transpose();
            let scale = moduli.shear * libm::pow(jacobian, -2.0 / 3.0);
            let trace = f.norm_squared();
            energy += point.volume * 0.5 * (scale * trace - 3.0 * moduli.shear);
            let stress = scale * (f - g * (trace / 3.0));
            let tangent = |i: usize, j: usize, k: usize, l: usize| {
                let same = if i == k && j == l { 1.0 } else { 0.0 };
                scale
                    * (same - 2.0 / 3.0 * (g[(k, l)] * f[(i, j)] + g[(i, j)] * f[(k, l)])
                        + 2.0 / 9.0 * trace * g[(i, j)] * g[(k, l)]
                        + trace / 3.0 * g[(i, l)] * g[(k, j)])
            };
            add(point, &stress, &tangent, forces, stiffness);
        }
        for point in &self.volume {
            let f = gradient(&point.slopes, nodes);
            let jacobian = f.determinant();
            if jacobian <= 0.0 {
                return None;
            }
            let g = f.try_inverse()?.transpose();
            energy += point.volume * 0.5 * moduli.bulk * (jacobian - 1.0) * (jacobian - 1.0);
            let pressure = moduli.bulk * (jacobian - 1.0) * jacobian;
            let stress = g * pressure;
            let rise = moduli.bulk * (2.0 * jacobian - 1.0) * jacobian;
            let tangent = |i: usize, j: usize, k: usize, l: usize| {
                rise * g[(i, j)] * g[(k, l)] - pressure * g[(i, l)] * g[(k, j)]
            };
            add(point, &stress, &tangent, forces, stiffness);
        }
        Some(energy)
    }
}

fn point(nodes: &[[f64; 3]; 27], at: [f64; 3], weight: f64) -> GaussPoint {
    let own = solid(at[0], at[1], at[2]);
    // How places at rest change with the element's own coordinates.
    let map = Matrix3::from_fn(|i, j| (0..27).map(|n| nodes[n][i] * own[n][j]).sum::<f64>());
    // The nodes of a section may be numbered either way round: volumes are positive.
    let volume = map.determinant().abs() * weight;
    let back = map.try_inverse().unwrap_or_else(Matrix3::zeros);
    let slopes = own.map(|own| std::array::from_fn(|j| (0..3).map(|k| own[k] * back[(k, j)]).sum()));
    GaussPoint { slopes, volume }
}

/// The deformation gradient.
fn gradient(slopes: &[[f64; 3]; 27], nodes: &[[f64; 3]; 27]) -> Matrix3<f64> {
    let mut f = Matrix3::zeros();
    for (slope, node) in slopes.iter().zip(nodes) {
        for i in 0..3 {
            for j in 0..3 {
                f[(i, j)] += node[i] * slope[j];
            }
        }
    }
    f
}

/// Adds what a stress and its slope do to the nodes.
fn add(
    point: &GaussPoint,
    stress: &Matrix3<f64>,
    tangent: &dyn Fn(usize, usize, usize, usize) -> f64,
    forces: &mut Forces,
    stiffness: &mut Stiffness,
) {
    let slopes = &point.slopes;
    for (a, slope) in slopes.iter().enumerate() {
        for i in 0..3 {
            forces[3 * a + i] += point.volume * (0..3).map(|j| stress[(i, j)] * slope[j]).sum::<f64>();
        }
    }
    let mut whole = SMatrix::<f64, 9, 9>::zeros();
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                for l in 0..3 {
                    whole[(3 * i + j, 3 * k + l)] = point.volume * tangent(i, j, k, l);
                }
            }
        }
    }
    // The slope of the stress with each degree of freedom, then that of the forces.
    let mut rises = SMatrix::<f64, 9, 81>::zeros();
    for (b, slope) in slopes.iter().enumerate() {
        for k in 0..3 {
            for ij in 0..9 {
                rises[(ij, 3 * b + k)] = (0..3).map(|l| whole[(ij, 3 * k + l)] * slope[l]).sum();
            }
        }
    }
    for column in 0..81 {
        let rise: [f64; 9] = std::array::from_fn(|ij| rises[(ij, column)]);
        let mut out = stiffness.column_mut(column);
        for (a, slope) in slopes.iter().enumerate() {
            for i in 0..3 {
                out[3 * a + i] +=
                    slope[0] * rise[3 * i] + slope[1] * rise[3 * i + 1] + slope[2] * rise[3 * i + 2];
            }
        }
    }
}
