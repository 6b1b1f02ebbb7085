//! Whether linear inequalities can hold together.

/// `sum of coefficient times variable <= bound`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// A coefficient for each variable; those at the end that are zero may be left out.
    pub coefficients: Vec<f64>,
    /// The most that the sum may be.
    pub bound: f64,
}

/// With more inequalities than this, nothing is claimed.
const MOST: usize = 3000;

/// How much an inequality must be broken by, against rounding.
const CLEARLY: f64 = 1e-6;

impl Row {
    fn coefficient(&self, variable: usize) -> f64 {
        self.coefficients.get(variable).copied().unwrap_or(0.0)
    }

    /// The sum of two rows, each times a positive factor.
    fn combined(&self, factor: f64, other: &Self, times: f64) -> Self {
        let length = self.coefficients.len().max(other.coefficients.len());
        let sum = |i| {
            let x = self.coefficient(i) * factor + other.coefficient(i) * times;
            if x.abs() < 1e-12 { 0.0 } else { x }
        };
        Self {
            coefficients: (0..length).map(sum).collect(),
            bound: self.bound * factor + other.bound * times,
        }
        .scaled()
    }

    /// The same inequality with a largest coefficient of one.
    fn scaled(mut self) -> Self {
        let largest = self.coefficients.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        if largest > 0.0 {
            self.coefficients.iter_mut().for_each(|c| *c /= largest);
            self.bound /= largest;
        }
        self
    }

    /// Whether it says that nothing is less than zero.
    fn contradicts(&self) -> bool {
        self.coefficients.iter().all(|c| *c == 0.0) && self.bound < -CLEARLY
    }
}

/// Whether the inequalities certainly exclude each other (after Fourier and Motzkin:
/// one variable after the other is eliminated).
#[must_use]
pub fn contradictory(rows: &[Row]) -> bool {
    let mut rows: Vec<Row> = rows.to_vec();
    loop {
        if rows.iter().any(Row::contradicts) {
            return true;
        }
        let variables = rows.iter().map(|r| r.coefficients.len()).max().unwrap_or(0);
        let cost = |v: usize| {
            let above = rows.iter().filter(|r| r.coefficient(v) > 0.0).count();
            let below = rows.iter().filter(|r| r.coefficient(v) < 0.0).count();
            (above * below, above + below)
        };
        let open = (0..variables).map(|v| (cost(v), v)).filter(|((_, uses), _)| *uses > 0).min();
        let Some((_, variable)) = open else { return false };
        rows = without(rows, variable);
        if rows.len() > MOST {
            return false;
        }
    }
}

/// What the rows say of the other variables.
fn without(rows: Vec<Row>, variable: usize) -> Vec<Row> {
    let (using, mut left): (Vec<Row>, Vec<Row>) =
        rows.into_iter().partition(|r| r.coefficient(variable) != 0.0);
    let (above, below): (Vec<Row>, Vec<Row>) = using.into_iter().partition(|r| r.coefficient(variable) > 0.0);
    for a in &above {
        for b in &below {
            let mut row = a.combined(-b.coefficient(variable), b, a.coefficient(variable));
            if let Some(gone) = row.coefficients.get_mut(variable) {
                *gone = 0.0;
            }
            // Most combinations say nothing new.
            if !left.iter().any(|r| r.coefficients == row.coefficients && r.bound <= row.bound) {
                left.push(row);
            }
            if left.len() > MOST {
                return left;
            }
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(coefficients: &[f64], bound: f64) -> Row {
        Row { coefficients: coefficients.to_vec(), bound }
    }

    #[test]
    fn a_sum_that_is_too_small_for_its_summands() {
        // x + y <= 3, x >= 4, y >= 0.
        let rows = [row(&[1.0, 1.0], 3.0), row(&[-1.0], -4.0), row(&[0.0, -1.0], 0.0)];
        assert!(contradictory(&rows));
        for i in 0..3 {
            let fewer: Vec<Row> =
                rows.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, r)| r.clone()).collect();
            assert!(!contradictory(&fewer), "without row {i}");
        }
    }

    #[test]
    fn what_needs_all_three_of_them() {
        // x <= y, y <= z, z <= x - 1.
        let rows = [row(&[1.0, -1.0], 0.0), row(&[0.0, 1.0, -1.0], 0.0), row(&[-1.0, 0.0, 1.0], -1.0)];
        assert!(contradictory(&rows));
        assert!(!contradictory(rows.get(..2).unwrap()));
    }

    #[test]
    fn what_meets_in_one_point_holds() {
        assert!(!contradictory(&[row(&[1.0], 2.0), row(&[-1.0], -2.0)]));
        assert!(!contradictory(&[]));
    }

    proptest::proptest! {
        /// Inequalities that a point fulfils never contradict each other.
        #[test]
        fn never_contradictory_with_a_witness(
            point in proptest::collection::vec(0i32..5, 4),
            rows in proptest::collection::vec((proptest::collection::vec(-3i32..4, 4), 0i32..3), 1..7),
        ) {
            let rows: Vec<Row> = rows.into_iter().map(|(coefficients, slack)| {
                let sum: i32 = coefficients.iter().zip(&point).map(|(c, x)| c * x).sum();
                Row { coefficients: coefficients.into_iter().map(f64::from).collect(), bound: f64::from(sum + slack) }
            }).collect();
            proptest::prop_assert!(!contradictory(&rows));
        }
    }
}
