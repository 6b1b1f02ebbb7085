//! The factorisation of a symmetric matrix whose blocks couple only with their neighbours: exact, and without fill-in.

use nalgebra::{DMatrix, DVector};

/// A symmetric matrix of blocks in a row.
#[derive(Clone, Debug)]
pub(super) struct BlockRow {
    /// The blocks on the diagonal.
    pub(super) own: Vec<DMatrix<f64>>,
    /// The block of the rows of one and the columns of the one before; that of the first is empty.
    pub(super) before: Vec<DMatrix<f64>>,
}

impl BlockRow {
    /// Zeros, for blocks of these sizes.
    pub(super) fn zeros(sizes: &[usize]) -> Self {
        let own = sizes.iter().map(|&n| DMatrix::zeros(n, n)).collect();
        let before = (0..sizes.len())
            .map(|k| DMatrix::zeros(sizes[k], if k == 0 { 0 } else { sizes[k - 1] }))
            .collect();
        Self { own, before }
    }
}

/// A matrix as the product of a triangular one and its transpose.
#[derive(Clone, Debug)]
pub(super) struct BlockFactor {
    own: Vec<DMatrix<f64>>,
    before: Vec<DMatrix<f64>>,
}

impl BlockFactor {
    /// None if the matrix is not positive definite.
    pub(super) fn new(matrix: BlockRow) -> Option<Self> {
        let mut factor = Self { own: Vec::new(), before: Vec::new() };
        for (mut own, before) in matrix.own.into_iter().zip(matrix.before) {
            let mut coupling = before;
            if let Some(last) = factor.own.last() {
                // Columns of zeros at the beginning stay zeros: the first half of a layer does not touch the next layer.
                let mut across = coupling.transpose();
                let first = across.row_iter().take_while(|row| row.iter().all(|x| *x == 0.0)).count();
                let rest = across.nrows() - first;
                let triangle = last.view((first, first), (rest, rest));
                triangle.solve_lower_triangular_mut(&mut across.rows_mut(first, rest));
                coupling = across.transpose();
                let used = coupling.columns(first, rest);
                own.gemm(-1.0, &used, &across.rows(first, rest), 1.0);
            }
            factor.own.push(own.cholesky()?.unpack());
            factor.before.push(coupling);
        }
        Some(factor)
    }

    /// The solution for a right-hand side.
    pub(super) fn solve(&self, mut right: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
        for k in 0..right.len() {
            if k > 0 {
                let (done, rest) = right.split_at_mut(k);
                rest[0].gemv(-1.0, &self.before[k], &done[k - 1], 1.0);
            }
            self.own[k].solve_lower_triangular_mut(&mut right[k]);
        }
        for k in (0..right.len()).rev() {
            self.own[k].tr_solve_lower_triangular_mut(&mut right[k]);
            if k > 0 {
                let (before, now) = right.split_at_mut(k);
                before[k - 1].gemv_tr(-1.0, &self.before[k], &now[0], 1.0);
            }
        }
        right
    }
}
