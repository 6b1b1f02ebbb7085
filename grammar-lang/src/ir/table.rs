//! Measured functions.

use serde::{Deserialize, Serialize};

/// A function as rows of what was measured, SI: straight lines in between, and beyond the ends what stands there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Table {
    /// What it was asked and what it answers; the former ascends strictly. There is at least one row.
    pub rows: Vec<[f64; 2]>,
}

impl Table {
    /// The answer to a question.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        between(&self.rows, x, 0, 1)
    }

    /// What has to be asked for an answer, where the answers [are ordered](Self::is_monotonic).
    #[must_use]
    pub fn inverse(&self, y: f64) -> f64 {
        let falls = matches!((self.rows.first(), self.rows.last()), (Some(a), Some(b)) if a[1] > b[1]);
        if falls {
            let turned: Vec<[f64; 2]> = self.rows.iter().rev().copied().collect();
            return between(&turned, y, 1, 0);
        }
        between(&self.rows, y, 1, 0)
    }

    /// Whether the answers only grow, or only fall, from row to row.
    #[must_use]
    pub fn is_monotonic(&self) -> bool {
        let steps = || self.rows.windows(2).map(|pair| pair[1][1] - pair[0][1]);
        steps().all(|step| step > 0.0) || steps().all(|step| step < 0.0)
    }

    /// The least and the greatest question.
    #[must_use]
    pub fn domain(&self) -> (f64, f64) {
        let ends = self.rows.first().zip(self.rows.last());
        ends.map_or((0.0, 0.0), |(first, last)| (first[0], last[0]))
    }

    /// The least and the greatest answer.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        let answers = || self.rows.iter().map(|row| row[1]);
        (answers().fold(f64::INFINITY, f64::min), answers().fold(f64::NEG_INFINITY, f64::max))
    }
}

/// Reads rows that ascend in column `from`.
fn between(rows: &[[f64; 2]], x: f64, from: usize, to: usize) -> f64 {
    let next = rows.partition_point(|row| row[from] <= x);
    match (next.checked_sub(1).and_then(|before| rows.get(before)), rows.get(next)) {
        (Some(a), Some(b)) => a[to] + (b[to] - a[to]) * ((x - a[from]) / (b[from] - a[from])),
        (Some(end), None) | (None, Some(end)) => end[to],
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    #[test]
    fn lies_on_straight_lines_between_rows_and_holds_beyond_them() {
        let table = Table { rows: vec![[-1.0, -2.0], [0.0, 0.0], [2.0, 1.0]] };
        let answers = [-3.0, -1.0, -0.5, 0.0, 1.0, 2.0, 9.0].map(|x| table.at(x));
        assert_eq!(answers, [-2.0, -2.0, -1.0, 0.0, 0.5, 1.0, 1.0]);
    }

    #[test]
    fn inverse_undoes_what_grows_and_what_falls() {
        for sign in [1.0, -1.0] {
            let rows = vec![[-1.0, -2.0 * sign], [0.0, 0.0], [2.0, 1.0 * sign]];
            let table = Table { rows };
            assert!(table.is_monotonic());
            for x in [-1.0, -0.3, 0.0, 0.7, 2.0] {
                assert!((table.inverse(table.at(x)) - x).abs() < 1e-12);
            }
        }
        assert!(!Table { rows: vec![[0.0, 0.0], [1.0, 1.0], [2.0, 1.0]] }.is_monotonic());
    }
}
