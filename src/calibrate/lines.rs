//! Straight lines between few rows that say what many points say.

/// Drops rows while straight lines between those that are left stay within `tolerance` of all, or
/// until at most `most` are left. Both ends stay. The rows ascend in x.
pub(super) fn reduce(rows: &[(f64, f64)], tolerance: f64, most: usize) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..rows.len()).collect();
    // What dropping a kept row would cost: the farthest that its neighbours' line is from a point between them.
    let cost = |kept: &[usize], i: usize| match (kept.get(i.wrapping_sub(1)), kept.get(i + 1)) {
        (Some(a), Some(b)) => deviation(rows, *a, *b),
        _ => f64::INFINITY,
    };
    let mut costs: Vec<f64> = (0..kept.len()).map(|i| cost(&kept, i)).collect();
    loop {
        let cheapest = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map(|(i, c)| (i, *c));
        match cheapest {
            Some((i, c)) if c.is_finite() && (c <= tolerance || kept.len() > most) => {
                kept.remove(i);
                costs.remove(i);
                for near in [i.wrapping_sub(1), i] {
                    if let Some(slot) = costs.get_mut(near) {
                        *slot = cost(&kept, near);
                    }
                }
            }
            _ => return kept,
        }
    }
}

fn deviation(rows: &[(f64, f64)], a: usize, b: usize) -> f64 {
    let (Some(from), Some(to), Some(between)) = (rows.get(a), rows.get(b), rows.get(a + 1..b)) else {
        return 0.0;
    };
    between.iter().map(|(x, y)| (on_line(*from, *to, *x) - y).abs()).fold(0.0, f64::max)
}

fn on_line(a: (f64, f64), b: (f64, f64), x: f64) -> f64 {
    if b.0 > a.0 { a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0) } else { a.1 }
}

/// What a table says: straight lines between its rows, its ends beyond them.
pub(super) fn at(rows: &[(f64, f64)], x: f64) -> f64 {
    let after = rows.partition_point(|row| row.0 < x);
    match (after.checked_sub(1).and_then(|i| rows.get(i)), rows.get(after)) {
        (Some(a), Some(b)) => on_line(*a, *b, x),
        (Some(end), None) | (None, Some(end)) => end.1,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn rows_on_a_line_go_and_corners_stay() {
        let rows = [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 2.0), (4.0, 2.0)];
        assert_eq!(reduce(&rows, 0.01, 16), [0, 2, 4]);
        assert_eq!(reduce(&rows, -1.0, 16), [0, 1, 2, 3, 4], "nothing goes below the tolerance");
        assert_eq!(reduce(&rows, -1.0, 2), [0, 4], "but there are never more than asked for");
        assert_eq!((at(&rows, -1.0), at(&rows, 0.5), at(&rows, 9.0)), (0.0, 0.5, 2.0));
        assert_eq!(reduce(&[], 1.0, 2), [0; 0]);
    }

    proptest! {
        #[test]
        fn what_is_left_says_the_same(
            values in proptest::collection::vec(-10.0f64..10.0, 2..60), tolerance in 0.0f64..4.0
        ) {
            let rows: Vec<(f64, f64)> = values.iter().enumerate().map(|(i, y)| (i as f64, *y)).collect();
            let kept: Vec<(f64, f64)> = reduce(&rows, tolerance, 100).into_iter().map(|i| rows[i]).collect();
            prop_assert_eq!((kept.first(), kept.last()), (rows.first(), rows.last()));
            for (x, y) in &rows {
                prop_assert!((at(&kept, *x) - y).abs() <= tolerance + 1e-9);
            }
        }
    }
}
