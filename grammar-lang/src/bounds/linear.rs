//! Whether linear inequalities can hold together.

use std::collections::BTreeMap;

/// `sum of coefficient times variable <= bound`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The variables with their coefficients, in order; none is zero.
    coefficients: Vec<(usize, f64)>,
    /// The most that the sum may be.
    bound: f64,
}

/// With more inequalities of the same variables than this, nothing is claimed.
const MOST: usize = 3000;

/// How much an inequality must be broken by, against rounding.
const CLEARLY: f64 = 1e-6;

impl Row {
    /// The variables, in order, with their coefficients, and the most that the sum may be.
    #[must_use]
    pub fn new(coefficients: impl IntoIterator<Item = (usize, f64)>, bound: f64) -> Self {
        Self { coefficients: coefficients.into_iter().filter(|(_, c)| *c != 0.0).collect(), bound }
    }

    /// How much is left of the bound where each variable is as small as it can be, with what one more
    /// of each takes; nothing where a variable takes from the sum, or is not known to be bounded.
    #[must_use]
    pub fn room(&self, least: &[f64]) -> Option<(f64, &[(usize, f64)])> {
        let mut room = self.bound;
        for (variable, coefficient) in &self.coefficients {
            room -= coefficient * least.get(*variable).filter(|_| *coefficient > 0.0)?;
        }
        Some((room, &self.coefficients))
    }

    /// The variables that it is about.
    pub fn variables(&self) -> impl Iterator<Item = usize> {
        self.coefficients.iter().map(|(variable, _)| *variable)
    }

    fn coefficient(&self, variable: usize) -> f64 {
        let place = self.coefficients.binary_search_by_key(&variable, |(v, _)| *v);
        place.ok().and_then(|i| self.coefficients.get(i)).map_or(0.0, |(_, c)| *c)
    }

    /// What two rows, one with a variable above and one with it below, say without it.
    fn without(&self, variable: usize, other: &Self) -> Self {
        let (factor, times) = (-other.coefficient(variable), self.coefficient(variable));
        let mut coefficients = Vec::with_capacity(self.coefficients.len() + other.coefficients.len());
        let (mut mine, mut theirs) =
            (self.coefficients.iter().peekable(), other.coefficients.iter().peekable());
        loop {
            let next = mine.peek().into_iter().chain(theirs.peek()).map(|(v, _)| *v).min();
            let Some(next) = next else { break };
            let a = mine.next_if(|(v, _)| *v == next).map_or(0.0, |(_, c)| *c);
            let b = theirs.next_if(|(v, _)| *v == next).map_or(0.0, |(_, c)| *c);
            let x = a * factor + b * times;
            if next != variable && x.abs() >= 1e-12 {
                coefficients.push((next, x));
            }
        }
        Self { coefficients, bound: self.bound * factor + other.bound * times }.scaled()
    }

    /// The same inequality with a largest coefficient of one.
    fn scaled(mut self) -> Self {
        let largest = self.coefficients.iter().fold(0.0f64, |m, (_, c)| m.max(c.abs()));
        if largest > 0.0 {
            self.coefficients.iter_mut().for_each(|(_, c)| *c /= largest);
            self.bound /= largest;
        }
        self
    }

    /// Whether it says that nothing is less than zero.
    fn contradicts(&self) -> bool {
        self.coefficients.is_empty() && self.bound < -CLEARLY
    }
}

/// Whether the inequalities certainly exclude each other.
#[must_use]
pub fn contradictory(rows: &[Row]) -> bool {
    let alone: Vec<&[Row]> = rows.iter().map(std::slice::from_ref).collect();
    connected(&alone).into_iter().any(|some| {
        let some = some.into_iter().filter_map(|i| rows.get(i));
        Open::of(some).is_none_or(Open::contradictory)
    })
}

/// The numbers of the sets of rows that share variables, or share them with sets that do: what one
/// group says has nothing to do with what another says.
#[must_use]
pub fn connected(sets: &[&[Row]]) -> Vec<Vec<usize>> {
    let mut union = Union::default();
    for rows in sets {
        union.join(rows.iter().flat_map(Row::variables));
    }
    let (mut groups, mut alone): (BTreeMap<usize, Vec<usize>>, Vec<Vec<usize>>) = Default::default();
    for (i, rows) in sets.iter().enumerate() {
        match rows.iter().flat_map(Row::variables).next() {
            Some(variable) => groups.entry(union.root(variable)).or_default().push(i),
            None => alone.push(vec![i]),
        }
    }
    groups.into_values().chain(alone).collect()
}

/// Which numbers belong together.
#[derive(Default)]
struct Union {
    above: Vec<usize>,
}

impl Union {
    /// The number that stands for all that belong to this one.
    fn root(&mut self, of: usize) -> usize {
        self.above.extend(self.above.len()..of + 1);
        let mut here = of;
        while let Some(above) = self.above.get(here).copied().filter(|above| *above != here) {
            let further = self.above.get(above).copied().unwrap_or(above);
            if let Some(shorter) = self.above.get_mut(here) {
                *shorter = further;
            }
            here = further;
        }
        here
    }

    /// These belong together.
    fn join(&mut self, all: impl IntoIterator<Item = usize>) {
        let mut all = all.into_iter();
        let Some(first) = all.next() else { return };
        for other in all {
            let (a, b) = (self.root(first), self.root(other));
            if let Some(above) = self.above.get_mut(a.max(b)) {
                *above = a.min(b);
            }
        }
    }
}

/// How often a variable is used by the open rows.
#[derive(Clone, Debug, Default)]
struct Uses {
    above: usize,
    below: usize,
    /// The rows that use it or have used it.
    rows: Vec<usize>,
}

/// Inequalities from which one variable after the other is eliminated (after Fourier and Motzkin).
#[derive(Debug, Default)]
struct Open {
    rows: BTreeMap<usize, Row>,
    /// How many rows there have been.
    next: usize,
    uses: BTreeMap<usize, Uses>,
    /// The rows by their coefficients.
    known: BTreeMap<Vec<(usize, u64)>, usize>,
}

fn key(row: &Row) -> Vec<(usize, u64)> {
    row.coefficients.iter().map(|(v, c)| (*v, c.to_bits())).collect()
}

impl Open {
    /// `None` if one of the rows cannot hold.
    fn of<'r>(rows: impl Iterator<Item = &'r Row>) -> Option<Self> {
        let mut open = Self::default();
        for row in rows {
            open.add(row.clone())?;
        }
        Some(open)
    }

    /// Adds a row, unless others say as much; `None` if it cannot hold.
    fn add(&mut self, row: Row) -> Option<()> {
        if row.coefficients.is_empty() {
            return (!row.contradicts()).then_some(());
        }
        let key = key(&row);
        if let Some(same) = self.known.get(&key).and_then(|number| self.rows.get_mut(number)) {
            same.bound = same.bound.min(row.bound);
            return Some(());
        }
        for (variable, c) in &row.coefficients {
            let uses = self.uses.entry(*variable).or_default();
            *(if *c > 0.0 { &mut uses.above } else { &mut uses.below }) += 1;
            uses.rows.push(self.next);
        }
        self.known.insert(key, self.next);
        self.rows.insert(self.next, row);
        self.next += 1;
        Some(())
    }

    fn remove(&mut self, number: usize) -> Option<Row> {
        let row = self.rows.remove(&number)?;
        self.known.remove(&key(&row));
        for (variable, c) in &row.coefficients {
            if let Some(uses) = self.uses.get_mut(variable) {
                *(if *c > 0.0 { &mut uses.above } else { &mut uses.below }) -= 1;
            }
        }
        Some(row)
    }

    /// Whether the rows exclude each other.
    fn contradictory(mut self) -> bool {
        loop {
            if self.rows.len() > MOST {
                return false;
            }
            // What costs least goes first; no variable comes back.
            let cost = |(v, u): (&usize, &Uses)| (u.above * u.below, u.above + u.below, *v);
            let Some((_, _, variable)) = self.uses.iter().map(cost).min() else { return false };
            if self.eliminate(variable).is_none() {
                return true;
            }
        }
    }

    /// Says without a variable what the rows say of the others; `None` if that cannot hold.
    fn eliminate(&mut self, variable: usize) -> Option<()> {
        let uses = self.uses.remove(&variable).unwrap_or_default();
        let using: Vec<Row> = uses.rows.into_iter().filter_map(|number| self.remove(number)).collect();
        let (above, below): (Vec<Row>, Vec<Row>) =
            using.into_iter().partition(|r| r.coefficient(variable) > 0.0);
        for a in &above {
            for b in &below {
                self.add(a.without(variable, b))?;
                if self.rows.len() > MOST {
                    return Some(());
                }
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(coefficients: &[f64], bound: f64) -> Row {
        Row::new(coefficients.iter().copied().enumerate(), bound)
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
                Row::new(coefficients.into_iter().map(f64::from).enumerate(), f64::from(sum + slack))
            }).collect();
            proptest::prop_assert!(!contradictory(&rows));
        }
    }

    #[test]
    fn what_shares_no_variable_is_looked_at_alone() {
        // Far more than are looked at together.
        let many = |bound: f64| -> Vec<Row> {
            let pair = |v: usize| [Row::new([(v, 1.0)], bound), Row::new([(v, -1.0)], 0.0)];
            (0..2 * MOST).flat_map(pair).collect()
        };
        assert!(!contradictory(&many(1.0)));
        assert!(contradictory(&many(-1.0)));
        let (rows, over) = (many(1.0), [row(&[1.0, 1.0, 1.0], 0.0)]);
        let sets: Vec<&[Row]> = rows.iter().map(std::slice::from_ref).chain([&over[..]]).collect();
        assert_eq!(connected(&sets).len(), 2 * MOST - 2);
    }
}
