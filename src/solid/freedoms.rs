//! The degrees of freedom of a mesh, and the sums of forces and stiffnesses over its elements.

use nalgebra::DVector;

use super::factor::BlockRow;
use super::mesh::Mesh;

/// How the half that is not meshed moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Parity {
    /// As the mirror image does: bending.
    Even,
    /// The other way: sideways bending, and twisting.
    Odd,
}

/// Where each degree of freedom is in a row of blocks: one block for each layer of the mesh.
#[derive(Clone, Debug)]
pub(super) struct Freedoms {
    /// Block and row, for three axes of each node; none where it is held.
    places: Vec<Option<(usize, usize)>>,
    sizes: Vec<usize>,
}

impl Freedoms {
    /// Those of a mesh. Of a layer, the plane in its middle comes first: it does not touch the next layer.
    pub(super) fn new(mesh: &Mesh, parity: Parity) -> Self {
        let mut sizes = vec![0; mesh.planes.len().saturating_sub(1) / 2];
        let mut places = vec![None; 3 * mesh.nodes.len()];
        for (plane, nodes) in mesh.planes.iter().enumerate().skip(1) {
            let block = (plane - 1) / 2;
            for &node in nodes {
                for axis in 0..3 {
                    let is_held = mesh.is_in_mirror(node) && (axis == 1) == (parity == Parity::Even);
                    if !is_held {
                        places[3 * node + axis] = Some((block, sizes[block]));
                        sizes[block] += 1;
                    }
                }
            }
        }
        Self { places, sizes }
    }

    /// A vector of zeros.
    pub(super) fn zeros(&self) -> Vec<DVector<f64>> {
        self.sizes.iter().map(|&rows| DVector::zeros(rows)).collect()
    }

    /// Adds a number in the row of a node and an axis, if it is free there.
    pub(super) fn put(&self, vector: &mut [DVector<f64>], (node, axis): (usize, usize), value: f64) {
        if let Some((block, row)) = self.places[3 * node + axis] {
            vector[block][row] += value;
        }
    }

    /// The degrees of freedom with their node and axis, and their number in a vector.
    pub(super) fn values<'a>(
        &'a self,
        vector: &'a [DVector<f64>],
    ) -> impl Iterator<Item = ((usize, usize), f64)> + 'a {
        let at = |(place, at): (usize, &Option<(usize, usize)>)| {
            at.map(|(block, row)| ((place / 3, place % 3), vector[block][row]))
        };
        self.places.iter().enumerate().filter_map(at)
    }
}

/// Forces and stiffnesses, summed over elements: the slope and the curvature of an energy.
pub(super) struct Assembled<'f> {
    freedoms: &'f Freedoms,
    /// N, and N m for each rad.
    pub(super) forces: Vec<DVector<f64>>,
    /// N/m
    pub(super) stiffness: BlockRow,
}

impl<'f> Assembled<'f> {
    /// Nothing yet.
    pub(super) fn new(freedoms: &'f Freedoms) -> Self {
        Self { freedoms, forces: freedoms.zeros(), stiffness: BlockRow::zeros(&freedoms.sizes) }
    }

    /// Adds an element: `force` has three numbers for each of its nodes, and `stiffness` gives those of a row and a column.
    pub(super) fn add(&mut self, nodes: &[usize], force: &[f64], stiffness: impl Fn(usize, usize) -> f64) {
        let freedoms = self.freedoms;
        let places: Vec<Option<(usize, usize)>> =
            nodes.iter().flat_map(|node| freedoms.places[3 * node..3 * node + 3].iter().copied()).collect();
        for (i, place) in places.iter().enumerate() {
            let Some((block, row)) = *place else { continue };
            self.forces[block][row] += force[i];
            for (j, other) in places.iter().enumerate() {
                match *other {
                    Some((same, column)) if same == block => {
                        self.stiffness.own[block][(row, column)] += stiffness(i, j);
                    }
                    Some((before, column)) if before + 1 == block => {
                        self.stiffness.before[block][(row, column)] += stiffness(i, j);
                    }
                    _ => {}
                }
            }
        }
    }
}
