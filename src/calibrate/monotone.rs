//! The nearest course that never turns back (isotonic regression).

/// Points that were made one because they would have turned back.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pool {
    /// The first of them.
    pub(super) first: usize,
    /// The one after the last of them.
    pub(super) end: usize,
    /// Their mean.
    pub(super) mean: f64,
    weight: f64,
}

/// The ascending course that is nearest to some values in the sense of least squares: neighbours that
/// do not ascend are pooled until all do (pool adjacent violators). `weight` says what a value counts.
pub(super) fn ascending(values: &[f64], weight: impl Fn(usize) -> f64) -> Vec<Pool> {
    let mut pools: Vec<Pool> = Vec::new();
    for (i, value) in values.iter().enumerate() {
        let mut pool = Pool { first: i, end: i + 1, mean: *value, weight: weight(i) };
        while let Some(last) = pools.pop_if(|last| last.mean >= pool.mean) {
            let weight = last.weight + pool.weight;
            let mean = (last.mean * last.weight + pool.mean * pool.weight) / weight;
            pool = Pool { first: last.first, end: pool.end, mean, weight };
        }
        pools.push(pool);
    }
    pools
}

/// The same, a value for each point.
pub(super) fn course(values: &[f64]) -> Vec<f64> {
    let pools = ascending(values, |_| 1.0);
    pools.iter().flat_map(|pool| std::iter::repeat_n(pool.mean, pool.end - pool.first)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn what_descends_is_pooled() {
        assert_eq!(course(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(course(&[1.0, 3.0, 2.0, 4.0]), [1.0, 2.5, 2.5, 4.0]);
        assert_eq!(course(&[3.0, 2.0, 1.0]), [2.0, 2.0, 2.0]);
        let weighed = ascending(&[3.0, 0.0], |i| if i == 0 { 2.0 } else { 1.0 });
        assert_eq!(weighed.iter().map(|p| p.mean).collect::<Vec<_>>(), [2.0]);
    }

    proptest! {
        #[test]
        fn the_course_ascends_and_keeps_the_mean(values in proptest::collection::vec(-10.0f64..10.0, 1..40)) {
            let course = course(&values);
            prop_assert_eq!(course.len(), values.len());
            prop_assert!(course.windows(2).all(|w| w[0] <= w[1]));
            let sum = |v: &[f64]| v.iter().sum::<f64>();
            prop_assert!((sum(&course) - sum(&values)).abs() < 1e-9);
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let far = |v: &[f64]| v.iter().zip(&values).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            prop_assert!(far(&course) <= far(&sorted) + 1e-9, "no ascending course is nearer");
        }
    }
}
