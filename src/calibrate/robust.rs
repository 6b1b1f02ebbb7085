//! The middle of repeated measurements, which a few wrong ones do not move, and how well it is known.

use super::finding::Figure;
use super::reality::{CONFIDENCE, t_quantile};
use super::statistics::{mean_and_deviation, median};
use crate::derive::random::Stream;

/// Beyond so many deviations a value does not count at all (Tukey's biweight, 95 % as efficient as the mean for
/// many values). Of a few values the deviation itself is little known: see [`reach`].
const BIWEIGHT: f64 = 4.685;
/// What is this share off the middle counts, however near the others are: readings that are rounded may all be the same.
const NEAR: f64 = 0.02;
/// Where most readings are equal, so many steps of the scale away others still count.
const READINGS: f64 = 2.5;
/// How often values are drawn again.
const DRAWS: usize = 2000;

/// The middle of some values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Centre {
    /// The value that is nearest to most.
    pub(super) value: f64,
    /// Where it lies nine times of ten, if two values or more say so and differ.
    pub(super) interval: Option<(f64, f64)>,
    /// Which values are so far off that they do not count.
    pub(super) far: Vec<usize>,
}

impl Centre {
    /// Of values, in a stream of random numbers with a name.
    pub(super) fn of(values: &[f64], name: &str) -> Self {
        let middle = median(values.iter().copied());
        let reach = reach(values, middle);
        let far: Vec<usize> =
            values.iter().enumerate().filter(|(_, x)| (*x - middle).abs() >= reach).map(|(i, _)| i).collect();
        let near: Vec<f64> = values.iter().copied().filter(|x| (x - middle).abs() < reach).collect();
        let value = biweight(&near, middle, reach);
        Self { value, interval: interval(&near, value, reach, name), far }
    }

    /// Half the width of the interval: by which the last digit goes.
    pub(super) fn error(&self) -> Option<f64> {
        self.interval.map(|(low, high)| 0.5 * (high - low))
    }

    /// The ends of the interval, each with the digits that it supports.
    pub(super) fn figures(&self, unit: &'static str) -> Option<(Figure, Figure)> {
        let (low, high) = self.interval?;
        // A digit more than the value has: both ends would else often be that value.
        let end = |x: f64| Figure::of(x, self.error().map(|error| error / 10.0), unit);
        Some((end(low), end(high)))
    }

    /// Sentences on values that do not count; `value` shows one.
    pub(super) fn warnings(&self, section: &str, what: &str, value: impl Fn(usize) -> String) -> Vec<String> {
        if self.far.is_empty() {
            return Vec::new();
        }
        let all: Vec<String> = self.far.iter().map(|i| format!("{what} {} ({})", i + 1, value(*i))).collect();
        let verb =
            if all.len() == 1 { "is far from the others and does" } else { "are far from the others and do" };
        vec![format!("`{section}`: {} {verb} not count. Measure again.", all.join(", "))]
    }

    /// Of a quotient of two that are positive, and known apart from each other: what is not known of either is not known of it.
    pub(super) fn over(&self, other: &Self) -> Self {
        let value = self.value / other.value;
        let share = |centre: &Self| Some(centre.error()? / centre.value);
        let error = share(self).zip(share(other)).map(|(own, others)| value * libm::hypot(own, others));
        let interval = error.map(|error| ((value - error).max(0.0), value + error));
        Self { value, interval, far: self.far.clone() }
    }

    /// Of values whose middle another quantity follows from, which grows with it.
    pub(super) fn map(&self, of: impl Fn(f64) -> f64) -> Self {
        let interval = self.interval.map(|(low, high)| (of(low), of(high)));
        Self { value: of(self.value), interval, far: self.far.clone() }
    }
}

/// How far from the middle a value counts nothing. Three values say so little of how they scatter that only what is very
/// far off is left out.
fn reach(values: &[f64], middle: f64) -> f64 {
    let many = values.len();
    if many < 3 {
        return f64::INFINITY;
    }
    let off = || values.iter().map(|x| (x - middle).abs());
    let least = NEAR * middle.abs();
    match 1.4826 * median(off()) {
        0.0 if off().all(|off| off == 0.0) => f64::INFINITY,
        // Most are equal, as they are rounded: the next readings of such a scale count, too.
        0.0 => least.max(READINGS * resolution(values)),
        deviation => least.max(BIWEIGHT * (1.0 + 4.0 / (many as f64 - 2.0)) * deviation),
    }
}

/// The coarsest power of ten of which all values are whole multiples: to this readings are rounded.
fn resolution(values: &[f64]) -> f64 {
    let is_whole = |unit: f64| {
        values.iter().all(|x| {
            let steps = libm::round(x / unit);
            steps != 0.0 && (x / unit - steps).abs() < 1e-6
        })
    };
    (-12..=12)
        .rev()
        .map(|power| libm::pow(10.0, f64::from(power)))
        .find(|unit| is_whole(*unit))
        .unwrap_or(0.0)
}

/// The middle from which values count the less the farther they are, found from one that is near it.
fn biweight(values: &[f64], near: f64, reach: f64) -> f64 {
    if reach.is_infinite() {
        return mean_and_deviation(values).0;
    }
    let mut value = near;
    for _ in 0..30 {
        let weight = |x: f64| {
            let far = (x - value) / reach;
            if far.abs() < 1.0 { (1.0 - far * far) * (1.0 - far * far) } else { 0.0 }
        };
        let all: f64 = values.iter().map(|x| weight(*x)).sum();
        if all == 0.0 {
            return near;
        }
        let moved = values.iter().map(|x| weight(*x) * x).sum::<f64>() / all;
        let step = (moved - value).abs();
        value = moved;
        if step <= 1e-12 * value.abs() {
            break;
        }
    }
    value
}

/// Where the middle lies nine times of ten: as far on both sides as what comes out where values are drawn again from themselves
/// scatters (bootstrap), times Student's t for so few. Quantiles of the draws would be too near for three or four values.
fn interval(values: &[f64], value: f64, reach: f64, name: &str) -> Option<(f64, f64)> {
    let many = values.len();
    if many < 2 || values.iter().all(|x| *x == values[0]) {
        return None;
    }
    let mut random = Stream::named(0, name);
    let mut drawn = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS {
        let again: Vec<f64> = (0..many).filter_map(|_| values.get(random.below(many)).copied()).collect();
        drawn.push(biweight(&again, value, reach));
    }
    let (_, scatter) = mean_and_deviation(&drawn);
    let n = many as f64;
    // Values that are drawn from themselves scatter less than new ones would.
    let wide = t_quantile(CONFIDENCE, many - 1) * scatter * (n / (n - 1.0)).sqrt();
    // What is positive in each measurement is not negative in the middle.
    let least = if values.iter().all(|x| *x > 0.0) { 0.0 } else { f64::NEG_INFINITY };
    Some(((value - wide).max(least), value + wide))
}

/// Between which values a share [`CONFIDENCE`] of some lies.
pub(super) fn quantiles(values: &mut [f64]) -> Option<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let at = |share: f64| values.get(libm::round(share * last as f64) as usize).copied();
    Some((at(0.5 * (1.0 - CONFIDENCE))?, at(0.5 * (1.0 + CONFIDENCE))?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_far_off_does_not_count_and_is_told() {
        let good = [0.0501, 0.0498, 0.0500, 0.0503, 0.0499, 0.0500];
        let clean = Centre::of(&good, "a");
        let bad = Centre::of(&[&good[..], &[0.070, 0.072, 0.069]].concat(), "a");
        assert_eq!(bad.far, [6, 7, 8]);
        assert!((bad.value - clean.value).abs() < 1e-4, "{bad:?}, {clean:?}");
        // Three tilts, one of which is no tilt: the two that agree count.
        let slopes = [31.0_f64, 32.0, 80.0].map(|tilt| libm::tan(tilt.to_radians()));
        let found = Centre::of(&slopes, "b");
        assert_eq!(found.far, [2]);
        assert!((found.value - 0.613).abs() < 0.002, "{found:?}");
        // Two values say nothing of which is wrong; three that scatter are left as they are.
        assert!(Centre::of(&[1.0, 9.0], "c").far.is_empty());
        assert!(Centre::of(&[10.0, 10.1, 11.0], "c").far.is_empty());
        assert_eq!(Centre::of(&[5.0, 5.0, 5.0], "c"), Centre { value: 5.0, interval: None, far: vec![] });
        assert_eq!(Centre::of(&[5.0; 9].map(|x| x), "c").interval, None);
        assert_eq!(Centre::of(&[7.0], "c").interval, None);
        // A scale of a tenth of a gram: the last reading is as good as the others.
        let rounded = Centre::of(&[&[10.0; 9][..], &[10.1]].concat(), "c");
        assert!(rounded.far.is_empty() && (rounded.value - 10.01).abs() < 0.005, "{rounded:?}");
        // However well the others agree, what is far from them does not count.
        for (values, far) in [
            (&[8.3, 8.3, 8.3, 8.3, 16.6][..], 4),
            (&[8.3, 8.3, 8.4, 8.3, 10.3], 4),
            (&[8.3, 8.3, 8300.0], 2),
            (&[0.6, 0.6, 0.6, 0.6, 1.0], 4),
        ] {
            let found = Centre::of(values, "c");
            assert_eq!(found.far, [far], "{values:?}");
            assert!((found.value - values[0]).abs() < 0.05, "{found:?}");
        }
    }

    #[test]
    fn a_draw_is_the_same_each_time() {
        let values = [1.0, 1.2, 0.9, 1.1];
        assert_eq!(Centre::of(&values, "x"), Centre::of(&values, "x"));
        assert_ne!(Centre::of(&values, "x").interval, Centre::of(&values, "y").interval);
    }

    /// Nine of ten intervals hold the truth, of few values and of many, also where every tenth value is wrong.
    #[test]
    fn intervals_hold_what_they_say() {
        for (many, wrong, least) in [(3, 0, 0.85), (5, 0, 0.86), (9, 0, 0.86), (30, 0, 0.86), (20, 2, 0.85)] {
            let mut random = Stream::named(1, &format!("{many} {wrong}"));
            let tries = 300;
            let held = (0..tries).filter(|trial| {
                let values: Vec<f64> =
                    (0..many).map(|i| if i < wrong { 25.0 } else { random.normal(10.0, 1.0) }).collect();
                let (low, high) = Centre::of(&values, &trial.to_string()).interval.unwrap();
                (low..=high).contains(&10.0)
            });
            let share = held.count() as f64 / f64::from(tries);
            assert!((least..=0.96).contains(&share), "{many} values, {wrong} wrong: {share}");
        }
    }

    #[test]
    fn a_quotient_is_as_uncertain_as_both() {
        let centre = |value: f64, error: f64| Centre {
            value,
            interval: Some((value - error, value + error)),
            far: vec![],
        };
        let over = centre(6.0, 0.9).over(&centre(2.0, 0.4));
        let (low, high) = over.interval.unwrap();
        // 15 % and 20 % make 25 %.
        assert!(
            (over.value - 3.0).abs() < 1e-12 && (low - 2.25).abs() < 1e-12 && (high - 3.75).abs() < 1e-12
        );
        assert_eq!(centre(6.0, 0.9).over(&Centre { interval: None, ..centre(2.0, 0.0) }).interval, None);
    }
}
