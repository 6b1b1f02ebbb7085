//! How fast a robot will really be, from those that were built of its kind.
//!
//! What was measured is so many times what was simulated. Such ratios are positive and spread by
//! factors, so their logarithms are taken as normally distributed; a few of them say little of their
//! spread, which Student's t allows for.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// The share of robots whose speed lies in the interval of a [`Prediction`].
pub const CONFIDENCE: f64 = 0.9;

/// What a robot of a kind that was built before will do, in the unit of the simulated speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The speed that half of such robots exceed.
    pub speed: f64,
    /// From where to where the speed of a share [`CONFIDENCE`] of such robots lies; none from one prototype,
    /// which says nothing of how they differ.
    pub interval: Option<(f64, f64)>,
    /// How many prototypes this rests on.
    pub prototypes: usize,
}

/// Predicts the real speed of a robot that was simulated, from (simulated, measured) speeds of robots
/// of the same kind that were built. All speeds are in one unit, whichever; pairs that are not both positive
/// and finite have no ratio and are left out. Nothing, if no pair is left or the simulated speed
/// is not positive and finite.
#[must_use]
pub fn predict(built: &[(f64, f64)], simulated: f64) -> Option<Prediction> {
    let is_speed = |x: f64| x.is_finite() && x > 0.0;
    if !is_speed(simulated) {
        return None;
    }
    let pairs = built.iter().filter(|(s, m)| is_speed(*s) && is_speed(*m));
    let ratios: Vec<f64> = pairs.map(|(s, m)| libm::log(m / s)).collect();
    let prototypes = ratios.len();
    let n = prototypes as f64;
    if prototypes == 0 {
        return None;
    }
    let mean = ratios.iter().sum::<f64>() / n;
    let at = |log: f64| simulated * libm::exp(log);
    let interval = (prototypes > 1).then(|| {
        let variance = ratios.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0);
        // The mean is uncertain, too, and the next robot is one more draw.
        let spread = t_quantile(CONFIDENCE, prototypes - 1) * (variance * (1.0 + 1.0 / n)).sqrt();
        (at(mean - spread), at(mean + spread))
    });
    Some(Prediction { speed: at(mean), interval, prototypes })
}

/// The t that a share `within` of Student's distribution does not exceed in size, found by halving.
///
/// `degrees` of freedom are at least 1; `within` lies from 0 to less than 1.
pub(super) fn t_quantile(within: f64, degrees: usize) -> f64 {
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if share_within(middle, degrees) < within {
            low = middle;
        } else {
            high = middle;
        }
    }
    libm::tan(low) * (degrees as f64).sqrt()
}

/// The share of Student's distribution between -t and t, for the angle whose tangent is t over the root of the
/// degrees (Abramowitz and Stegun 26.7.3 and 26.7.4).
fn share_within(angle: f64, degrees: usize) -> f64 {
    let (sin, cos) = libm::sincos(angle);
    let mut term = if degrees.is_multiple_of(2) { 1.0 } else { cos };
    let mut sum = if degrees == 1 { 0.0 } else { term };
    let mut k = if degrees.is_multiple_of(2) { 2.0 } else { 3.0 };
    while k < degrees as f64 {
        term *= cos * cos * (k - 1.0) / k;
        sum += term;
        k += 2.0;
    }
    if degrees.is_multiple_of(2) { sin * sum } else { FRAC_2_PI * (angle + sin * sum) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PNEUMATIC: [(f64, f64); 4] = [(35.6, 5.0), (75.1, 6.0), (35.6, 5.0), (56.3, 6.0)];
    const TENDON: [(f64, f64); 3] = [(43.4, 15.0), (137.3, 28.0), (164.3, 36.0)];

    #[test]
    fn students_t_is_that_of_the_tables() {
        for (within, degrees, t) in [
            (0.9, 1, 6.313752),
            (0.9, 2, 2.919986),
            (0.9, 3, 2.353363),
            (0.9, 4, 2.131847),
            (0.95, 1, 12.706205),
            (0.95, 5, 2.570582),
            (0.95, 10, 2.228139),
            (0.99, 7, 3.499483),
            (0.9, 30, 1.697261),
            (0.95, 1000, 1.962339),
        ] {
            let found = t_quantile(within, degrees);
            assert!((found - t).abs() < 2e-6, "{within}, {degrees}: {found} is not {t}");
        }
    }

    #[test]
    fn the_prototypes_of_the_thesis_predict_the_next() {
        let told = |built: &[(f64, f64)]| {
            let p = predict(built, 50.0).unwrap();
            let (low, high) = p.interval.unwrap();
            format!("{:.2}, {:.2} to {:.2}, from {}", p.speed, low, high, p.prototypes)
        };
        insta::assert_snapshot!([told(&PNEUMATIC), told(&TENDON)].join("\n"));
        let ratios = |built: &[(f64, f64)]| predict(built, 1.0).unwrap().speed;
        assert!((0.08..0.14).contains(&ratios(&PNEUMATIC)));
        assert!((0.20..0.35).contains(&ratios(&TENDON)));
    }

    #[test]
    fn few_prototypes_say_little() {
        assert_eq!(predict(&[], 10.0), None);
        let one = predict(&[(40.0, 10.0)], 20.0).unwrap();
        assert_eq!((one.interval, one.prototypes), (None, 1));
        assert!((one.speed - 5.0).abs() < 1e-12);
        assert_eq!(predict(&[(0.0, 1.0), (1.0, 0.0), (f64::NAN, 1.0)], 10.0), None, "no ratios");
        assert_eq!(predict(&PNEUMATIC, 0.0), None);
        assert_eq!(predict(&PNEUMATIC, f64::INFINITY), None);
        let two = predict(&TENDON[..2], 20.0).unwrap().interval.unwrap();
        let three = predict(&TENDON, 20.0).unwrap().interval.unwrap();
        assert!(two.1 / two.0 > three.1 / three.0, "two say less than three: {two:?}, {three:?}");
    }

    /// Standard normal numbers from a stream that is the same everywhere.
    fn normals(count: usize) -> Vec<f64> {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        (0..count)
            .map(|_| (-2.0 * libm::log(uniform())).sqrt() * libm::cos(std::f64::consts::TAU * uniform()))
            .collect()
    }

    #[test]
    fn nine_of_ten_robots_are_in_the_interval() {
        for n in [2, 3, 4, 8] {
            let draws = normals(4000 * (n + 1));
            let inside = draws.chunks_exact(n + 1).filter(|draw| {
                let speed = |z: f64| libm::exp(-1.5 + 0.3 * z);
                let built: Vec<(f64, f64)> = draw[..n].iter().map(|z| (1.0, speed(*z))).collect();
                let (low, high) = predict(&built, 1.0).unwrap().interval.unwrap();
                (low..=high).contains(&speed(draw[n]))
            });
            let share = inside.count() as f64 / 4000.0;
            assert!((share - CONFIDENCE).abs() < 0.02, "{n} prototypes: {share}");
        }
    }

    proptest! {
        #[test]
        fn the_unit_and_the_order_do_not_matter(factor in 0.01f64..100.0, speed in 1.0f64..200.0) {
            let mut scaled = TENDON.map(|(s, m)| (s * factor, m * factor));
            scaled.reverse();
            let (a, b) = (predict(&TENDON, speed).unwrap(), predict(&scaled, speed * factor).unwrap());
            let near = |a: f64, b: f64| (a * factor - b).abs() <= 1e-9 * b;
            let ((l, h), (m, i)) = (a.interval.unwrap(), b.interval.unwrap());
            prop_assert!(near(a.speed, b.speed) && near(l, m) && near(h, i));
        }
    }
}
