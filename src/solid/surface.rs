//! What acts on surfaces: air in a hole, and windings and sheets that hardly stretch.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::shape::{THREE, face};

pub(super) type Nodes = [Vector3<f64>; 9];
pub(super) type FaceForces = SMatrix<f64, 27, 1>;
pub(super) type FaceStiffness = SMatrix<f64, 27, 27>;

/// What a vector makes of another by the cross product.
fn cross(v: &Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// The share of a face in the volume that a closed surface encloses, `1/3 x . n dA`; `scale` times its slope and curvature are added.
pub(super) fn volume(
    nodes: &Nodes,
    scale: f64,
    forces: &mut FaceForces,
    stiffness: &mut FaceStiffness,
) -> f64 {
    let mut volume = 0.0;
    for (s, ws) in THREE {
        for (t, wt) in THREE {
            let (n, ns, nt) = face(s, t);
            let (x, xs, xt) = places(nodes, &n, &ns, &nt);
            let weight = ws * wt / 3.0;
            volume += weight * x.dot(&xs.cross(&xt));
            let weight = weight * scale;
            let (st, tx, xs_) = (xs.cross(&xt), xt.cross(&x), x.cross(&xs));
            let (cx, cs, ct) = (cross(&x), cross(&xs), cross(&xt));
            for a in 0..9 {
                let force = (st * n[a] + tx * ns[a] + xs_ * nt[a]) * weight;
                for i in 0..3 {
                    forces[3 * a + i] += force[i];
                }
                for b in 0..9 {
                    let block = (cs * nt[b] - ct * ns[b]) * n[a]
                        + (ct * n[b] - cx * nt[b]) * ns[a]
                        + (cx * ns[b] - cs * n[b]) * nt[a];
                    for i in 0..3 {
                        for j in 0..3 {
                            stiffness[(3 * a + i, 3 * b + j)] += weight * block[(i, j)];
                        }
                    }
                }
            }
        }
    }
    volume
}

/// Along which direction of a face its fibres lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fibres {
    /// Around the actuator: they only pull.
    Around,
    /// Along the actuator, in a sheet that is glued on: it also pushes.
    Along,
}

/// The energy of fibres in a face, `c / 2 (stretch - 1)^2` for each area; slope and curvature are added. `c` is in N/m.
pub(super) fn fibres(
    rest: &Nodes,
    nodes: &Nodes,
    (direction, c): (Fibres, f64),
    forces: &mut FaceForces,
    stiffness: &mut FaceStiffness,
) -> f64 {
    let mut energy = 0.0;
    for (s, ws) in THREE {
        for (t, wt) in THREE {
            let (n, ns, nt) = face(s, t);
            let (_, rs, rt) = places(rest, &n, &ns, &nt);
            let (_, xs, xt) = places(nodes, &n, &ns, &nt);
            let area = ws * wt * rs.cross(&rt).norm();
            let (long, now, slopes) = match direction {
                Fibres::Around => (rs.norm(), xs, ns),
                Fibres::Along => (rt.norm(), xt, nt),
            };
            let stretch = now.norm() / long;
            if direction == Fibres::Around && stretch <= 1.0 {
                continue;
            }
            energy += 0.5 * c * area * (stretch - 1.0) * (stretch - 1.0);
            let along = now / now.norm();
            let force = along * (c * area * (stretch - 1.0) / long);
            let pull = along * along.transpose();
            let block = (pull + (Matrix3::identity() - pull) * ((stretch - 1.0) / stretch))
                * (c * area / (long * long));
            for a in 0..9 {
                for i in 0..3 {
                    forces[3 * a + i] += force[i] * slopes[a];
                }
                for b in 0..9 {
                    for i in 0..3 {
                        for j in 0..3 {
                            stiffness[(3 * a + i, 3 * b + j)] += block[(i, j)] * slopes[a] * slopes[b];
                        }
                    }
                }
            }
        }
    }
    energy
}

/// Where a point of a face is, and how that changes along its two directions.
fn places(
    nodes: &Nodes,
    n: &[f64; 9],
    ns: &[f64; 9],
    nt: &[f64; 9],
) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let sum = |weights: &[f64; 9]| nodes.iter().zip(weights).map(|(x, w)| x * *w).sum();
    (sum(n), sum(ns), sum(nt))
}
