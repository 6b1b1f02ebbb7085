//! Closed curves over a cycle.

use serde::{Deserialize, Serialize};

/// A Bezier curve of one value over a cycle from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Control points times their binomial coefficients.
    weighted: Vec<f64>,
}

impl Curve {
    /// The Bezier curve with these control points; `None` unless there are 2 to 64.
    #[must_use]
    pub fn bezier(points: &[f64]) -> Option<Self> {
        if !(2..=64).contains(&points.len()) {
            return None;
        }
        let degree = points.len() - 1;
        let mut binomial = 1.0;
        let weighted = points
            .iter()
            .enumerate()
            .map(|(i, p)| {
                let weighted = p * binomial;
                binomial = binomial * (degree - i) as f64 / (i + 1) as f64;
                weighted
            })
            .collect();
        Some(Self { weighted })
    }

    /// The curve with every value multiplied.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { weighted: self.weighted.iter().map(|w| w * factor).collect() }
    }

    /// The value at a place of the cycle; places outside 0 to 1 come round again.
    #[must_use]
    pub fn at(&self, place: f64) -> f64 {
        let place = if (0.0..=1.0).contains(&place) { place } else { place - libm::floor(place) };
        // From the end that is farther away.
        let rest = 1.0 - place;
        if place <= 0.5 {
            fold(place, rest, self.weighted.iter().rev())
        } else {
            fold(rest, place, self.weighted.iter())
        }
    }

    /// The values at several places, each as [`at`](Self::at) gives it: side by side, as one waits for another
    /// in a sum only.
    pub(super) fn over(&self, places: &mut [f64]) {
        const SIDE: usize = 8;
        let (chunks, rest) = places.as_chunks_mut::<SIDE>();
        for chunk in chunks {
            let (mut sums, mut scales) = ([0.0; SIDE], [1.0; SIDE]);
            let near = chunk.map(|p| if (0.0..=1.0).contains(&p) { p } else { p - libm::floor(p) });
            let low = near.map(|p| p <= 0.5);
            let large: [f64; SIDE] = std::array::from_fn(|n| if low[n] { 1.0 - near[n] } else { near[n] });
            let ratio: [f64; SIDE] =
                std::array::from_fn(|n| (if low[n] { near[n] } else { 1.0 - near[n] }) / large[n]);
            for (i, (forth, back)) in self.weighted.iter().zip(self.weighted.iter().rev()).enumerate() {
                for n in 0..SIDE {
                    sums[n] = sums[n] * ratio[n] + if low[n] { back } else { forth };
                    scales[n] *= if i > 0 { large[n] } else { 1.0 };
                }
            }
            *chunk = std::array::from_fn(|n| sums[n] * scales[n]);
        }
        rest.iter_mut().for_each(|place| *place = self.at(*place));
    }
}

/// Horner's scheme on the ratio of a place's distances from the two ends, which is at most one.
fn fold<'w>(small: f64, large: f64, points: impl Iterator<Item = &'w f64>) -> f64 {
    let ratio = small / large;
    let (mut sum, mut scale) = (0.0, 1.0);
    for (i, weighted) in points.enumerate() {
        sum = sum * ratio + weighted;
        if i > 0 {
            scale *= large;
        }
    }
    sum * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    /// De Casteljau's construction: slow and beyond doubt.
    fn reference(points: &[f64], u: f64) -> f64 {
        let mut row = points.to_vec();
        while row.len() > 1 {
            row = row.windows(2).map(|w| w[0] + (w[1] - w[0]) * u).collect();
        }
        row[0]
    }

    proptest::proptest! {
        #[test]
        fn agrees_with_de_casteljau(points in proptest::collection::vec(-2.5f64..2.5, 2..20), u in 0.0f64..1.0) {
            let curve = Curve::bezier(&points).unwrap();
            proptest::prop_assert!((curve.at(u) - reference(&points, u)).abs() < 1e-9);
        }

        #[test]
        fn many_at_once_are_as_one_by_one(
            points in proptest::collection::vec(-2.5f64..2.5, 2..20),
            places in proptest::collection::vec(-2.0f64..3.0, 0..30),
        ) {
            let curve = Curve::bezier(&points).unwrap();
            let mut all = places.clone();
            curve.over(&mut all);
            for (value, place) in all.iter().zip(places) {
                proptest::prop_assert_eq!(value.to_bits(), curve.at(place).to_bits());
            }
        }
    }

    #[test]
    fn order_fifteen_closes_with_equal_slopes() {
        let points: Vec<f64> = [0.3, -1.2, 2.0, 0.9, 0.3].iter().flat_map(|p| [*p; 3]).collect();
        let curve = Curve::bezier(&points).unwrap();
        let h = 1e-6;
        assert!((curve.at(0.0) - curve.at(1.0)).abs() < 1e-12);
        assert!(((curve.at(h) - curve.at(0.0)) / h).abs() < 1e-3);
        assert!(((curve.at(1.0) - curve.at(1.0 - h)) / h).abs() < 1e-3);
    }
}
