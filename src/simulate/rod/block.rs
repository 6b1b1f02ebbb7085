//! Triangular solves and products of blocks with six rows.
//!
//! A step needs thousands of them. Those of nalgebra serve all sizes, and their loops stay loops. Here all lengths are fixed, and what
//! stands side by side in a row is computed side by side, so the compiler uses the vectors of the processor. Sums are in the order in
//! which nalgebra makes them: the results have the same bits (see the tests).

use nalgebra::Matrix6;

/// Six rows.
pub(super) type Rows<const N: usize> = [[f64; N]; 6];

/// Zeros.
pub(super) const fn zeros<const N: usize>() -> Rows<N> {
    [[0.0; N]; 6]
}

/// A matrix by rows.
#[inline(always)]
pub(super) fn rows_of(matrix: &Matrix6<f64>) -> Rows<6> {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix.data.0[column][row]))
}

/// The product of a transposed block and another one: a row for each column of the first.
#[inline(always)]
pub(super) fn transposed_product<const M: usize, const N: usize>(
    left: &Rows<M>,
    right: &Rows<N>,
) -> [[f64; N]; M] {
    let mut product = [[0.0; N]; M];
    for (left, right) in left.iter().zip(right) {
        for (sums, left) in product.iter_mut().zip(left) {
            for (sum, right) in sums.iter_mut().zip(right) {
                *sum += left * right;
            }
        }
    }
    product
}

/// Subtracts a block.
#[inline(always)]
pub(super) fn subtract<const N: usize>(from: &mut Rows<N>, by: &Rows<N>) {
    for (from, by) in from.iter_mut().zip(by) {
        for (from, by) in from.iter_mut().zip(by) {
            *from -= by;
        }
    }
}

/// The lower triangle of which a positive definite matrix is the square.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// By columns; what is above the diagonal is not read.
    columns: [[f64; 6]; 6],
}

impl Triangle {
    /// Zeros.
    pub(super) fn zeros() -> Self {
        Self { columns: [[0.0; 6]; 6] }
    }

    /// The factor of Cholesky of a matrix, of which the lower half is read. None if it is not positive definite.
    #[inline(always)]
    pub(super) fn new(matrix: &Matrix6<f64>) -> Option<Self> {
        let mut triangle = Self { columns: matrix.data.0 };
        let is_definite = triangle.eliminate::<0>()
            && triangle.eliminate::<1>()
            && triangle.eliminate::<2>()
            && triangle.eliminate::<3>()
            && triangle.eliminate::<4>()
            && triangle.eliminate::<5>();
        is_definite.then_some(triangle)
    }

    /// Finishes a column, and subtracts its square from what is right of it. False if its diagonal is not positive.
    ///
    /// A constant for the column makes all lengths constant: each column is a few instructions without a loop.
    #[inline(always)]
    fn eliminate<const COLUMN: usize>(&mut self) -> bool {
        let mut own = self.columns[COLUMN];
        if own[COLUMN].is_nan() || own[COLUMN] <= 0.0 {
            return false;
        }
        own[COLUMN] = own[COLUMN].sqrt();
        for row in COLUMN + 1..6 {
            own[row] /= own[COLUMN];
        }
        self.columns[COLUMN] = own;
        for right in COLUMN + 1..6 {
            for row in right..6 {
                self.columns[right][row] -= own[right] * own[row];
            }
        }
        true
    }

    /// Solves `triangle x = rows` for each column, in place.
    #[inline(always)]
    pub(super) fn solve<const N: usize>(&self, rows: &mut Rows<N>) {
        self.substitute::<0, N>(rows);
        self.substitute::<1, N>(rows);
        self.substitute::<2, N>(rows);
        self.substitute::<3, N>(rows);
        self.substitute::<4, N>(rows);
        self.substitute::<5, N>(rows);
    }

    /// Finishes a row, and subtracts what it does to those below.
    #[inline(always)]
    fn substitute<const ROW: usize, const N: usize>(&self, rows: &mut Rows<N>) {
        let column = &self.columns[ROW];
        for value in &mut rows[ROW] {
            *value /= column[ROW];
        }
        let found = rows[ROW];
        for below in ROW + 1..6 {
            for (value, found) in rows[below].iter_mut().zip(found) {
                *value -= found * column[below];
            }
        }
    }

    /// Solves `transposed triangle x = vector`, in place.
    #[inline(always)]
    pub(super) fn solve_transposed(&self, vector: &mut [f64; 6]) {
        for (row, column) in self.columns.iter().enumerate().rev() {
            let mut sum = 0.0;
            for below in row + 1..6 {
                sum += column[below] * vector[below];
            }
            vector[row] = (vector[row] - sum) / column[row];
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, Matrix6, Vector6};

    use super::{Rows, Triangle, rows_of, transposed_product};

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
    }

    /// The same bits as nalgebra, which serves all sizes.
    #[test]
    fn blocks_are_what_nalgebra_makes_of_them() {
        let mut state = 1_u64;
        for _ in 0..100 {
            let some = Matrix6::from_fn(|_, _| random(&mut state));
            let other = Matrix6::from_fn(|_, _| random(&mut state));
            let vector = Vector6::from_fn(|_, _| random(&mut state));
            let matrix = some * some.transpose() + Matrix6::identity() * 0.1;
            let theirs = Cholesky::new(matrix).unwrap().l();
            let own = Triangle::new(&matrix).unwrap();
            for row in 0..6 {
                for column in 0..=row {
                    assert_eq!(own.columns[column][row], theirs[(row, column)]);
                }
            }
            let mut rows: Rows<6> = rows_of(&other);
            own.solve(&mut rows);
            assert_eq!(rows, rows_of(&theirs.solve_lower_triangular(&other).unwrap()));
            let mut along = vector.data.0[0];
            own.solve_transposed(&mut along);
            assert_eq!(along, theirs.tr_solve_lower_triangular(&vector).unwrap().data.0[0]);
            assert_eq!(transposed_product(&rows_of(&some), &rows_of(&other)), rows_of(&some.tr_mul(&other)));
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_triangle() {
        for spoilt in [0.0, -1.0, f64::NAN] {
            let mut matrix = Matrix6::identity();
            matrix[(3, 3)] = spoilt;
            assert!(Triangle::new(&matrix).is_none());
        }
    }
}
