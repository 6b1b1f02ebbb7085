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
