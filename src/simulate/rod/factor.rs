//! The factorisation of a block matrix whose blocks couple along a tree: exact, and without fill-in.
//!
//! Blocks are numbered with parents before children. Eliminated from the last to the first, each block changes that of its parent
//! alone (George and Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, chapter 4).

use nalgebra::Matrix6;

use super::block::{Rows, Triangle, rows_of, subtract, transposed_product, zeros};

/// A symmetric matrix: a block of six by six for each body, and one for each body and its parent.
#[derive(Clone, Debug)]
pub(super) struct TreeMatrix {
    /// The parent of each body; the root names itself.
    parents: Vec<usize>,
    /// The blocks on the diagonal.
    pub(super) own: Vec<Matrix6<f64>>,
    /// The block of a body's row and its parent's column; that of the root is not used.
    pub(super) coupling: Vec<Matrix6<f64>>,
}

impl TreeMatrix {
    /// Zeros.
    pub(super) fn new(parents: Vec<usize>) -> Self {
        let zeros = vec![Matrix6::zeros(); parents.len()];
        Self { parents, own: zeros.clone(), coupling: zeros }
    }

    /// Zeros again.
    pub(super) fn clear(&mut self) {
        self.own.fill(Matrix6::zeros());
        self.coupling.fill(Matrix6::zeros());
    }
}

/// A matrix as the product of a triangular one and its transpose.
#[derive(Clone, Debug)]
pub(super) struct TreeFactor {
    parents: Vec<usize>,
    /// The triangles on the diagonal.
    own: Vec<Triangle>,
    /// The blocks beside them, in the column of the parent.
    coupling: Vec<Rows<6>>,
}

impl TreeFactor {
    /// Room for the factor of a matrix.
    pub(super) fn new(matrix: &TreeMatrix) -> Self {
        let parents = matrix.parents.clone();
        let (own, coupling) = (vec![Triangle::zeros(); parents.len()], vec![zeros(); parents.len()]);
        Self { parents, own, coupling }
    }

    /// Factorises a matrix, which is left as it came to be on the way. False if it is not positive definite.
    #[inline(always)]
    pub(super) fn factorise(&mut self, matrix: &mut TreeMatrix) -> bool {
        for body in (0..self.parents.len()).rev() {
            let Some(triangle) = Triangle::new(&matrix.own[body]) else { return false };
            if body > 0 {
                let mut coupling = rows_of(&matrix.coupling[body]);
                triangle.solve(&mut coupling);
                // It is symmetric: whether by rows or by columns is all the same.
                subtract(
                    &mut matrix.own[self.parents[body]].data.0,
                    &transposed_product(&coupling, &coupling),
                );
                self.coupling[body] = coupling;
            }
            self.own[body] = triangle;
        }
        true
    }

    /// The half of a solution that goes from the leaves to the root, in place.
    #[inline(always)]
    pub(super) fn forward(&self, vectors: &mut [[f64; 6]]) {
        for body in (0..self.parents.len()).rev() {
            let mut own = vectors[body].map(|value| [value]);
            self.own[body].solve(&mut own);
            vectors[body] = own.map(|[value]| value);
            if body > 0 {
                let [for_parent] = transposed_product(&own, &self.coupling[body]);
                for (value, by) in vectors[self.parents[body]].iter_mut().zip(for_parent) {
                    *value -= by;
                }
            }
        }
    }

    /// The same of several columns at once, along a path on which each body stands before its parent; the room is empty again.
    #[inline(always)]
    pub(super) fn forward_rows<const N: usize>(
        &self,
        path: &[usize],
        room: &mut [Rows<N>],
    ) -> Vec<(usize, Rows<N>)> {
        let mut rows = Vec::with_capacity(path.len());
        for &body in path {
            let mut own = std::mem::replace(&mut room[body], zeros());
            self.own[body].solve(&mut own);
            if body > 0 {
                subtract(&mut room[self.parents[body]], &transposed_product(&self.coupling[body], &own));
            }
            rows.push((body, own));
        }
        rows
    }

    /// The half of a solution that goes from the root to the leaves, in place.
    #[inline(always)]
    pub(super) fn backward(&self, vectors: &mut [[f64; 6]]) {
        for body in 0..self.parents.len() {
            let mut own = vectors[body];
            if body > 0 {
                let parent = vectors[self.parents[body]];
                for (value, row) in own.iter_mut().zip(&self.coupling[body]) {
                    let products = std::array::from_fn::<f64, 6, _>(|column| row[column] * parent[column]);
                    let [first, rest @ ..] = products;
                    *value -= rest.into_iter().fold(first, |sum, product| sum + product);
                }
            }
            self.own[body].solve_transposed(&mut own);
            vectors[body] = own;
        }
    }

    /// The bodies from one to the root.
    pub(super) fn path(&self, body: usize) -> impl Iterator<Item = usize> {
        let parents = &self.parents;
        std::iter::successors(Some(body), move |&body| (body > 0).then(|| parents[body]))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, Matrix6};

    use super::{TreeFactor, TreeMatrix, zeros};

    /// Both halves solve what a dense matrix of the same numbers solves.
    #[test]
    fn a_tree_is_solved_as_its_dense_matrix_is() {
        let parents = vec![0, 0, 1, 1, 0, 4, 5];
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let mut matrix = TreeMatrix::new(parents.clone());
        let size = 6 * parents.len();
        let mut dense = DMatrix::zeros(size, size);
        for (body, &parent) in parents.iter().enumerate() {
            let some = Matrix6::from_fn(|_, _| random());
            matrix.own[body] = some * some.transpose() + Matrix6::identity() * 20.0;
            dense.view_mut((6 * body, 6 * body), (6, 6)).copy_from(&matrix.own[body]);
            if body > 0 {
                matrix.coupling[body] = Matrix6::from_fn(|_, _| random());
                dense.view_mut((6 * body, 6 * parent), (6, 6)).copy_from(&matrix.coupling[body]);
                dense.view_mut((6 * parent, 6 * body), (6, 6)).copy_from(&matrix.coupling[body].transpose());
            }
        }
        let right: Vec<[f64; 6]> = parents.iter().map(|_| std::array::from_fn(|_| random())).collect();
        let mut factor = TreeFactor::new(&matrix);
        assert!(factor.factorise(&mut matrix.clone()));
        let mut found = right.clone();
        factor.forward(&mut found);
        factor.backward(&mut found);
        let right = DVector::from_iterator(size, right.iter().flat_map(|part| part.iter().copied()));
        let expected = dense.cholesky().unwrap().solve(&right);
        for (body, part) in found.iter().enumerate() {
            for row in 0..6 {
                assert!((part[row] - expected[6 * body + row]).abs() < 1e-12);
            }
        }
        // A vector that begins at one body goes along its path.
        let mut whole = vec![[0.0; 6]; parents.len()];
        whole[6] = [1.0; 6];
        let mut room = vec![zeros::<3>(); parents.len()];
        room[6] = [[0.0, 1.0, 0.0]; 6];
        factor.forward(&mut whole);
        let path: Vec<usize> = factor.path(6).collect();
        for (body, rows) in factor.forward_rows(&path, &mut room) {
            assert_eq!(rows.map(|row| row[1]), whole[body]);
        }
        assert!(room.iter().all(|rows| *rows == zeros()));
        assert_eq!(factor.path(6).collect::<Vec<_>>(), [6, 5, 4, 0]);
    }
}
