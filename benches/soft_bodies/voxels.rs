//! Bodies of voxels: particles at the corners of boxes, with springs between the corners.
//!
//! Each voxel has 12 springs along edges, 12 along face diagonals and 4 along space diagonals.
//! Voxels that share a corner share its particle; voxels that share an edge or a face add up their springs there.

use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// The material of a body. A lattice of springs always has a Poisson's ratio of 1/4 when it is isotropic.
#[derive(Clone, Copy)]
pub(crate) struct Material {
    /// Density, kg/m^3.
    pub(crate) density: f64,
    /// Young's modulus, Pa.
    pub(crate) young: f64,
}

/// A spring, or a distance constraint, between two particles.
pub(crate) struct Spring {
    /// The two particles.
    pub(crate) ends: [usize; 2],
    /// Rest length now, m.
    pub(crate) rest: f64,
    /// Stiffness, N/m.
    pub(crate) stiffness: f64,
}

/// A spring whose rest length changes with time.
struct Muscle {
    spring: usize,
    /// Rest length without activation, m.
    natural: f64,
    /// Share of the front signal and of the back signal in the strain.
    shares: [f64; 2],
    /// Phase of the leg, rad.
    phase: f64,
}

/// A body of particles and springs.
pub(crate) struct Body {
    /// Positions, m.
    pub(crate) positions: Vec<Vector3<f64>>,
    /// Velocities, m/s.
    pub(crate) velocities: Vec<Vector3<f64>>,
    /// Masses, kg.
    pub(crate) masses: Vec<f64>,
    /// Inverse masses, 1/kg; zero for a particle that is held.
    pub(crate) inverse_masses: Vec<f64>,
    /// Springs, in an order in which neighbours in the list share no particle where possible.
    pub(crate) springs: Vec<Spring>,
    muscles: Vec<Muscle>,
}

/// A box of voxels: its first corner and its size, both in voxels.
pub(crate) type Block = ([usize; 3], [usize; 3]);

/// The stiffness (N/m) of one spring in one voxel, for the spring that spans the axes in `spans`.
///
/// A lattice of springs that strains uniformly has the elastic tensor
/// `C_ijkl = sum(k L^2 n_i n_j n_k n_l) / V` over the springs of one voxel of volume `V`.
/// An isotropic one has `C_1122 = mu`, `C_1111 = 3 mu`, and `E = 2.5 mu`.
/// This sets the face diagonals from `C_1122` and the edges from `C_1111`. Space diagonals are free; they get `0.12 E h`.
/// A cube of side `h` has `0.14 E h` on edges and `0.12 E h` on all diagonals.
/// A bar under axial load is then as stiff as `E A / L` exactly.
fn voxel_stiffness(size: &Vector3<f64>, young: f64, spans: [bool; 3]) -> f64 {
    let volume = size.product();
    let shear = young / 2.5;
    let squared = size.component_mul(size);
    let space = 0.12 * young * libm::cbrt(volume);
    let face = |i: usize, j: usize| {
        let from_shear = shear * volume / (4.0 * squared[i] * squared[j]);
        (from_shear - space / squared.sum()) * (squared[i] + squared[j])
    };
    let axes: Vec<usize> = (0..3).filter(|&axis| spans[axis]).collect();
    match axes[..] {
        [i] => {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let diagonals = face(i, j) / (squared[i] + squared[j])
                + face(i, k) / (squared[i] + squared[k])
                + space / squared.sum();
            0.75 * shear * volume / squared[i] - squared[i] * diagonals
        }
        [i, j] => face(i, j),
        _ => space,
    }
}

impl Body {
    /// Builds a body from boxes of voxels that do not overlap. `size` is the size of one voxel in m.
    pub(crate) fn new(blocks: &[Block], size: Vector3<f64>, material: Material) -> Self {
        let mut corners = BTreeMap::new();
        let mut lengths = BTreeMap::new();
        for voxel in blocks.iter().flat_map(voxels) {
            let corner = |bits: usize| [0, 1, 2].map(|axis| voxel[axis] + (bits >> axis & 1));
            for a in 0..8 {
                *corners.entry(corner(a)).or_insert(0.0) += material.density * size.product() / 8.0;
                for b in a + 1..8 {
                    let spans = [0, 1, 2].map(|axis| (a ^ b) >> axis & 1 == 1);
                    let (low, high) = (corner(a).min(corner(b)), corner(a).max(corner(b)));
                    *lengths.entry((low, high)).or_insert(0.0) +=
                        voxel_stiffness(&size, material.young, spans);
                }
            }
        }
        let index: BTreeMap<_, _> = corners.keys().enumerate().map(|(i, &corner)| (corner, i)).collect();
        let place = |corner: &[usize; 3]| size.component_mul(&Vector3::from(corner.map(|i| i as f64)));
        let springs = lengths.iter().map(|((low, high), &stiffness)| Spring {
            ends: [index[low], index[high]],
            rest: (place(high) - place(low)).norm(),
            stiffness,
        });
        let masses: Vec<f64> = corners.values().copied().collect();
        Self {
            positions: corners.keys().map(place).collect(),
            velocities: vec![Vector3::zeros(); masses.len()],
            inverse_masses: masses.iter().map(|mass| 1.0 / mass).collect(),
            springs: in_colours(springs.collect(), masses.len()),
            masses,
            muscles: Vec::new(),
        }
    }

    /// Holds every particle at x = 0 where it is.
    pub(crate) fn clamp_start(&mut self) {
        for (position, inverse_mass) in self.positions.iter().zip(&mut self.inverse_masses) {
            if position.x < 1e-9 {
                *inverse_mass = 0.0;
            }
        }
    }

    /// Makes the springs in a box into muscles. `low` and `high` are the corners of the box in m.
    ///
    /// A spring's strain goes with the square of its direction's vertical part.
    /// It mixes the front and back signals by where the spring's middle is along x.
    pub(crate) fn add_leg_muscles(&mut self, low: Vector3<f64>, high: Vector3<f64>, phase: f64) {
        let inside = |p: &Vector3<f64>| (0..3).all(|i| p[i] > low[i] - 1e-9 && p[i] < high[i] + 1e-9);
        for (index, spring) in self.springs.iter().enumerate() {
            let [a, b] = spring.ends.map(|end| self.positions[end]);
            let vertical = (a.z - b.z) / spring.rest;
            if inside(&a) && inside(&b) && vertical != 0.0 {
                let front = ((a.x + b.x) / 2.0 - low.x) / (high.x - low.x);
                let shares = [front, 1.0 - front].map(|share| share * vertical * vertical);
                self.muscles.push(Muscle { spring: index, natural: spring.rest, shares, phase });
            }
        }
    }

    /// Sets the muscles' rest lengths for the time `t` (s): a sine of 1 Hz, with the front a quarter period behind the back.
    /// `strain` is the amplitude; it grows from zero in the first second.
    pub(crate) fn drive(&mut self, t: f64, strain: f64) {
        let amplitude = strain * t.min(1.0);
        let mut signals = (f64::NAN, [0.0; 2]);
        for muscle in &self.muscles {
            if signals.0 != muscle.phase {
                let angle = 2.0 * PI * t + muscle.phase;
                signals = (muscle.phase, [libm::sin(angle - FRAC_PI_2), libm::sin(angle)]);
            }
            let [front, back] = signals.1;
            let strain = amplitude * (muscle.shares[0] * front + muscle.shares[1] * back);
            self.springs[muscle.spring].rest = muscle.natural * (1.0 + strain);
        }
    }

    /// Centre of mass, m.
    pub(crate) fn centre(&self) -> Vector3<f64> {
        let moment: Vector3<f64> = self.positions.iter().zip(&self.masses).map(|(p, m)| p * *m).sum();
        moment / self.masses.iter().sum::<f64>()
    }

    /// The highest speed of a particle, m/s. It is not a number if one of them is not.
    pub(crate) fn top_speed(&self) -> f64 {
        let squares = self.velocities.iter().map(Vector3::norm_squared);
        squares
            .fold(0.0, |top: f64, square| if square > top || square.is_nan() { square } else { top })
            .sqrt()
    }
}

/// The voxels of a box.
fn voxels((first, count): &Block) -> impl Iterator<Item = [usize; 3]> {
    let (first, [nx, ny, nz]) = (*first, *count);
    (0..nx * ny * nz).map(move |i| [first[0] + i / (ny * nz), first[1] + i / nz % ny, first[2] + i % nz])
}

/// Orders springs by colour, so that springs of one colour share no particle. This spares the processor from waiting.
fn in_colours(springs: Vec<Spring>, particles: usize) -> Vec<Spring> {
    let mut used = vec![0u128; particles];
    let mut coloured: Vec<(u32, Spring)> = Vec::with_capacity(springs.len());
    for spring in springs {
        let [a, b] = spring.ends;
        let colour = (used[a] | used[b]).trailing_ones();
        used[a] |= 1 << colour;
        used[b] |= 1 << colour;
        coloured.push((colour, spring));
    }
    coloured.sort_by_key(|(colour, _)| *colour);
    coloured.into_iter().map(|(_, spring)| spring).collect()
}
