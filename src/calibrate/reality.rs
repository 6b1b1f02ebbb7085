//! How fast a robot will really be, from those that were built of its kind.
//!
//! What was measured is so many times what was simulated. Such ratios are positive and spread by
//! factors, so their logarithms are taken as normally distributed; a few of them say little of their
//! spread, which Student's t allows for. Where robots of a kind were all about as fast, whatever was simulated, one speed for all is
//! nearer to them: each of them, left out, says which of the two the others tell better.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// The share of robots whose speed lies in the interval of a [`Prediction`].
pub const CONFIDENCE: f64 = 0.9;

/// What is this share off is the same.
const ROUNDING: f64 = 1e-9;

/// A robot that was built.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// Its name.
    pub name: String,
    /// How fast it was in the simulation.
    pub simulated: f64,
    /// How fast it was, in the same unit.
    pub measured: f64,
    /// How long it is, in any one unit, if that is known.
    pub length: Option<f64>,
}

impl Built {
    /// Whether two are told with the same numbers, and so are one robot under two names.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs();
        let lengths = self.length.zip(other.length).is_none_or(|(a, b)| near(a, b));
        near(self.simulated, other.simulated) && near(self.measured, other.measured) && lengths
    }
}

/// What a speed is taken to depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// What was measured is so many times what was simulated.
    Ratio,
    /// All robots of a kind are about as fast, whatever was simulated.
    Constant,
}

/// What is to be expected by one law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The speed that half of such robots exceed.
    pub speed: f64,
    /// From where to where the speed of a share [`CONFIDENCE`] of such robots lies; none from one prototype,
    /// which says nothing of how they differ.
    pub interval: Option<(f64, f64)>,
    /// How many prototypes lie in the interval that the others alone give, where that is one: from three on.
    pub held: Option<usize>,
    /// How far the others alone are off for each, as a factor in the mean; none from one prototype.
    pub off: Option<f64>,
}

/// What a robot of a kind that was built before will do, in the unit of the simulated speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// By the ratio of measured and simulated speeds.
    pub ratio: Estimate,
    /// By one speed for all, where the prototypes alone are nearer to it.
    pub constant: Option<Estimate>,
    /// The prototypes that this rests on, each once.
    pub prototypes: Vec<String>,
    /// The names of those that repeat another's numbers, and do not count.
    pub repeated: Vec<String>,
    /// The simulated speeds that were built, least and greatest, if this one lies outside of them.
    pub beyond: Option<(f64, f64)>,
}

/// Predicts the real speed of a robot that was simulated, from robots of the same kind that were built. All speeds are in
/// one unit, whichever; robots whose speeds are not both positive and finite have no ratio and are left out. Nothing, if
/// none is left or the simulated speed is not positive and finite.
#[must_use]
pub fn predict(built: &[Built], simulated: f64) -> Option<Prediction> {
    let is_speed = |x: f64| x.is_finite() && x > 0.0;
    let (mut each, mut repeated): (Vec<&Built>, Vec<String>) = (Vec::new(), Vec::new());
    for one in built.iter().filter(|one| is_speed(one.simulated) && is_speed(one.measured)) {
        if each.iter().any(|other| other.is_same(one)) {
            repeated.push(one.name.clone());
        } else {
            each.push(one);
        }
    }
    if each.is_empty() || !is_speed(simulated) {
        return None;
    }
    let pairs: Vec<(f64, f64)> = each.iter().map(|one| (one.simulated, one.measured)).collect();
    let by = |law: Law| estimate(&pairs, law, simulated);
    let (ratio, constant) = (by(Law::Ratio)?, by(Law::Constant)?);
    let nearer = constant.off.zip(ratio.off).is_some_and(|(constant, ratio)| constant < ratio);
    let (low, high) =
        pairs.iter().fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), (s, _)| (l.min(*s), h.max(*s)));
    Some(Prediction {
        ratio,
        constant: nearer.then_some(constant),
        prototypes: each.iter().map(|one| one.name.clone()).collect(),
        repeated,
        beyond: (simulated < low || simulated > high).then_some((low, high)),
    })
}

/// What (simulated, measured) speeds make of a simulated speed by a law, and how well they do for each other.
fn estimate(pairs: &[(f64, f64)], law: Law, simulated: f64) -> Option<Estimate> {
    let (speed, interval) = spread(pairs, law, simulated)?;
    let others = |left_out: usize| -> Vec<(f64, f64)> {
        pairs.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, pair)| *pair).collect()
    };
    let each: Vec<(f64, Option<bool>)> = pairs
        .iter()
        .enumerate()
        .filter_map(|(i, (own, measured))| {
            let (speed, interval) = spread(&others(i), law, *own)?;
            // Where the others agree to the last digit, rounding is no difference.
            let slack = ROUNDING * measured;
            let within = interval.map(|(low, high)| (low - slack..=high + slack).contains(measured));
            Some((libm::log(measured / speed), within))
        })
        .collect();
    let squares: f64 = each.iter().map(|(log, _)| log * log).sum();
    let off = (!each.is_empty()).then(|| libm::exp((squares / each.len() as f64).sqrt()));
    let within: Option<Vec<bool>> = each.iter().map(|(_, within)| *within).collect();
    let held = within.filter(|all| !all.is_empty()).map(|all| all.iter().filter(|within| **within).count());
    Some(Estimate { speed, interval, held, off })
}

/// The speed and its interval.
fn spread(pairs: &[(f64, f64)], law: Law, simulated: f64) -> Option<(f64, Option<(f64, f64)>)> {
    let scale = |own: f64| if law == Law::Ratio { own } else { 1.0 };
    let logs: Vec<f64> = pairs.iter().map(|(own, measured)| libm::log(measured / scale(*own))).collect();
    let n = logs.len() as f64;
    if logs.is_empty() {
        return None;
    }
    let mean = logs.iter().sum::<f64>() / n;
    let at = |log: f64| scale(simulated) * libm::exp(log);
    let interval = (logs.len() > 1).then(|| {
        let variance = logs.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0);
        // The mean is uncertain, too, and the next robot is one more draw.
        let spread = t_quantile(CONFIDENCE, logs.len() - 1) * (variance * (1.0 + 1.0 / n)).sqrt();
        (at(mean - spread), at(mean + spread))
    });
    Some((at(mean), interval))
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

    fn built(all: &[(f64, f64)]) -> Vec<Built> {
        let one = |(i, (simulated, measured)): (usize, &(f64, f64))| Built {
            name: format!("r{i}"),
            simulated: *simulated,
            measured: *measured,
            length: Some(i as f64),
        };
        all.iter().enumerate().map(one).collect()
    }

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
    fn prototypes_that_agree_predict_each_other() {
        let prediction = predict(&built(&[(0.4, 4.0), (0.8, 8.0), (1.2, 12.0)]), 1.0).unwrap();
        assert_eq!((prediction.ratio.held, prediction.constant), (Some(3), None));
    }

    #[test]
    fn the_prototypes_of_the_thesis_predict_the_next() {
        let told = |all: &[(f64, f64)]| {
            let p = predict(&built(all), 50.0).unwrap();
            let line = |law: &str, e: Estimate| {
                let (low, high) = e.interval.unwrap();
                let (off, held) = (e.off.unwrap(), e.held.unwrap());
                format!(
                    "{law} {:.2}, {low:.2} to {high:.2}, off by {off:.2}, holds {held} of {}",
                    e.speed,
                    all.len()
                )
            };
            let constant = p.constant.map_or("the ratio is nearer".to_owned(), |e| line("constant", e));
            format!("{}; {constant}", line("ratio", p.ratio))
        };
        insta::assert_snapshot!([told(&PNEUMATIC), told(&TENDON)].join("\n"));
        let ratios = |all: &[(f64, f64)]| predict(&built(all), 1.0).unwrap().ratio.speed;
        assert!((0.08..0.14).contains(&ratios(&PNEUMATIC)));
        assert!((0.20..0.35).contains(&ratios(&TENDON)));
    }

    #[test]
    fn few_prototypes_say_little() {
        assert_eq!(predict(&[], 10.0), None);
        let one = predict(&built(&[(40.0, 10.0)]), 20.0).unwrap();
        assert_eq!(
            (one.ratio.interval, one.ratio.held, one.ratio.off, one.constant),
            (None, None, None, None)
        );
        assert!((one.ratio.speed - 5.0).abs() < 1e-12);
        assert_eq!(predict(&built(&[(0.0, 1.0), (1.0, 0.0), (f64::NAN, 1.0)]), 10.0), None, "no ratios");
        assert_eq!(predict(&built(&PNEUMATIC), 0.0), None);
        assert_eq!(predict(&built(&PNEUMATIC), f64::INFINITY), None);
        let two = predict(&built(&TENDON[..2]), 20.0).unwrap().ratio;
        let three = predict(&built(&TENDON), 20.0).unwrap().ratio;
        assert!(two.held.is_none() && two.off.is_some() && three.held.is_some());
        let (two, three) = (two.interval.unwrap(), three.interval.unwrap());
        assert!(two.1 / two.0 > three.1 / three.0, "two say less than three: {two:?}, {three:?}");
    }

    #[test]
    fn a_robot_counts_once_and_what_was_not_built_is_told() {
        let thesis = built(&PNEUMATIC);
        let mut twice = thesis.clone();
        // Of one of them, the length was not noted.
        twice.extend(thesis.iter().enumerate().map(|(i, one)| Built {
            name: format!("again_{i}"),
            length: one.length.filter(|_| i != 1),
            ..one.clone()
        }));
        let (once, again) = (predict(&thesis, 50.0).unwrap(), predict(&twice, 50.0).unwrap());
        assert_eq!((once.ratio, once.constant), (again.ratio, again.constant));
        assert_eq!(again.repeated, ["again_0", "again_1", "again_2", "again_3"]);
        // Two robots of the thesis have the same speeds, and other lengths: both count.
        assert_eq!(once.prototypes.len(), 4);
        assert_eq!(once.beyond, None);
        assert_eq!(predict(&thesis, 10.0).unwrap().beyond, Some((35.6, 75.1)));
        assert_eq!(predict(&thesis, 75.2).unwrap().beyond, Some((35.6, 75.1)));
    }

    #[test]
    fn the_law_that_the_robots_follow_is_found() {
        let ratio = predict(&built(&[(10.0, 2.1), (40.0, 7.9), (90.0, 18.5)]), 30.0).unwrap();
        assert!(ratio.constant.is_none() && (ratio.ratio.speed - 6.0).abs() < 0.3, "{ratio:?}");
        let constant = predict(&built(&[(10.0, 5.1), (40.0, 4.9), (90.0, 5.2)]), 30.0).unwrap();
        assert!((constant.constant.unwrap().speed - 5.0).abs() < 0.2, "{constant:?}");
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
                let robots: Vec<(f64, f64)> = draw[..n].iter().map(|z| (1.0, speed(*z))).collect();
                let (low, high) = predict(&built(&robots), 1.0).unwrap().ratio.interval.unwrap();
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
            let (a, b) = (predict(&built(&TENDON), speed).unwrap(), predict(&built(&scaled), speed * factor).unwrap());
            let near = |a: f64, b: f64| (a * factor - b).abs() <= 1e-9 * b;
            let ((l, h), (m, i)) = (a.ratio.interval.unwrap(), b.ratio.interval.unwrap());
            prop_assert!(near(a.ratio.speed, b.ratio.speed) && near(l, m) && near(h, i));
            prop_assert_eq!(a.constant.is_some(), b.constant.is_some());
        }
    }
}
