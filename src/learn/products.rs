//! Products of matrices. Each sum runs in the order of the inner index, whatever the width of the machine's vectors: the bits are the same
//! everywhere.

/// How many columns are worked on at once.
const LANES: usize = 8;
/// And how many rows.
const ROWS: usize = 4;

/// A matrix, row after row.
#[derive(Clone, Debug, Default)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) of: Vec<f32>,
}

/// Rows of numbers that lie apart: of each row the first `skip` are left out.
#[derive(Clone, Copy)]
pub(super) struct Rows<'r> {
    pub(super) of: &'r [f32],
    /// How many there are in a row, with those that are left out.
    pub(super) stride: usize,
    pub(super) skip: usize,
}

impl Rows<'_> {
    /// The same, with columns for rows.
    pub(super) fn transposed(self) -> Matrix {
        let (rows, columns) = (self.stride - self.skip, self.of.len() / self.stride.max(1));
        let mut out = Matrix { rows, columns, of: vec![0.0; rows * columns] };
        for (column, row) in self.of.chunks_exact(self.stride.max(1)).enumerate() {
            for (place, value) in row.iter().skip(self.skip).enumerate() {
                out.of[place * columns + column] = *value;
            }
        }
        out
    }
}

impl Matrix {
    /// Its rows.
    pub(super) fn all(&self) -> Rows<'_> {
        Rows { of: &self.of, stride: self.columns, skip: 0 }
    }

    /// The same numbers with so many more columns of zeros that no lane is half full.
    fn padded(&self) -> Self {
        let columns = self.columns.next_multiple_of(LANES);
        let mut of = vec![0.0; self.rows * columns];
        for (to, from) in of.chunks_exact_mut(columns.max(1)).zip(self.of.chunks_exact(self.columns.max(1))) {
            to[..self.columns].copy_from_slice(from);
        }
        Self { rows: self.rows, columns, of }
    }
}

/// The product of rows with a matrix.
pub(super) fn product(left: Rows<'_>, right: &Matrix) -> Matrix {
    let padded = (!right.columns.is_multiple_of(LANES)).then(|| right.padded());
    let from = padded.as_ref().unwrap_or(right);
    let stride = left.stride.max(1);
    let columns = right.columns;
    let rows = left.of.len() / stride;
    let mut out = Matrix { rows, columns, of: vec![0.0; rows * columns] };
    if columns == 0 {
        return out;
    }
    let own: Vec<&[f32]> = left.of.chunks_exact(stride).map(|row| &row[left.skip..]).collect();
    for (out, own) in out.of.chunks_mut(ROWS * columns).zip(own.chunks(ROWS)) {
        match own {
            [a, b, c, d] => fill([a, b, c, d], from, columns, out),
            own => own
                .iter()
                .zip(out.chunks_exact_mut(columns))
                .for_each(|(a, out)| fill([a], from, columns, out)),
        }
    }
    out
}

/// The products of some rows with a matrix whose lanes are full.
fn fill<const N: usize>(rows: [&[f32]; N], right: &Matrix, columns: usize, out: &mut [f32]) {
    let depth = right.rows;
    let rows = rows.map(|row| &row[..depth]);
    for from in (0..columns).step_by(LANES) {
        let mut sums = [[0.0_f32; LANES]; N];
        let all = right.of.chunks_exact(right.columns).take(depth).enumerate();
        for (place, values) in all {
            let Some(values) = values.get(from..).and_then(|values| values.first_chunk::<LANES>()) else {
                break;
            };
            for (sums, row) in sums.iter_mut().zip(&rows) {
                let factor = row[place];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += factor * value;
                }
            }
        }
        let width = LANES.min(columns - from);
        for (out, sums) in out.chunks_exact_mut(columns).zip(&sums) {
            out[from..from + width].copy_from_slice(&sums[..width]);
        }
    }
}
