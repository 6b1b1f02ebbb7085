//! The speed of a bend as a function of the bend, from curves of the bend over time.
//!
//! Differences of neighbouring points would be mostly noise, and smoothing the curve first rounds off its ends.
//! So nothing is differentiated: the table itself (straight lines between its rows, as a simulation
//! reads it) is integrated, and its rows are varied until the motion that follows is nearest to the points
//! of all runs together (output-error method, Levenberg-Marquardt). Logarithms of speeds are
//! varied, which keeps them positive, and so the bend monotone. A point that is far off counts less (Huber).
//! Each run has a delay, a bend at rest and a bend at which it ends of its own.

use nalgebra::{DMatrix, DVector};

use super::monotone::course;
use super::reality::{CONFIDENCE, t_quantile};
use super::robust::quantiles;
use super::statistics::{mean_and_deviation, median};
use crate::derive::random::Stream;

/// How many rows a table may have.
const SIZES: [usize; 8] = [1, 2, 3, 4, 5, 6, 8, 10];
/// More rows must make the residual smaller by this share, or they say nothing.
const GAIN: f64 = 0.01;
/// Where a residual begins to count less, in standard deviations (Huber).
const HUBER: f64 = 1.345;
/// With fewer points for each number that is fitted, nobody can tell a wrong one, or how well the numbers are known.
const LEAST_POINTS: usize = 3;
/// A point within this share of the way from an end is one of rest, or cannot be told from one.
const REST: f64 = 0.05;
/// From how many times the speed on its way a fit to few points begins anew.
const GUESSES: [f64; 4] = [0.5, 0.7, 1.4, 2.0];
/// A residual of more deviations is no scatter.
const FAR: f64 = 6.0;
/// Bends nearer than this are one, rad.
const SAME: f64 = 1e-6;
/// Intervals go no further than to this power of e from their speed: two runs that have nothing in common say nothing.
const FURTHEST: f64 = 3.0;
/// How often runs are made again from the fit and its residuals.
const DRAWS: usize = 100;
/// Turns of the method: with new weights, and within.
const TURNS: (usize, usize) = (6, 12);

/// A curve of a growing bend over time, rad and s, ascending in time.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) points: Vec<(f64, f64)>,
}

/// A fitted table of speeds, and the motions that follow from it.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// Bend and speed, ascending; one row is a constant speed. rad, rad/s.
    pub(super) rows: Vec<(f64, f64)>,
    /// Where each speed lies nine times of ten, rad/s.
    pub(super) within: Vec<(f64, f64)>,
    /// Points that are so far off that they hardly count: the run, and the place in it.
    pub(super) far: Vec<(usize, usize)>,
    /// For each run its delay, and the bends where it begins and ends.
    pub(super) motions: Vec<Motion>,
    /// How fast each run is by itself, as a share of the speed of all; nothing of a single one.
    pub(super) alone: Vec<f64>,
    /// Whether there are too few points to tell how well anything is known.
    pub(super) is_thin: bool,
}

/// What a run has of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    delay: f64,
    begin: f64,
    end: f64,
}

impl Motion {
    /// The largest bend of a run, whatever its side, rad.
    pub(super) fn most(&self) -> f64 {
        self.begin.abs().max(self.end.abs())
    }

    /// How far a run that crosses the straight position goes on the side on which it goes less far, rad; 0 for others.
    pub(super) fn on_the_other_side(&self) -> f64 {
        if self.begin * self.end < 0.0 { self.begin.abs().min(self.end.abs()) } else { 0.0 }
    }

    /// How near a run comes to rest, rad.
    pub(super) fn least(&self) -> f64 {
        if self.begin * self.end > 0.0 { self.begin.abs().min(self.end.abs()) } else { 0.0 }
    }
}

impl Fit {
    /// The bend of a run at a time.
    pub(super) fn bend(&self, motion: &Motion, time: f64) -> f64 {
        bend(&Pieces::of(&self.rows), motion, time)
    }
}

fn bend(pieces: &Pieces, motion: &Motion, time: f64) -> f64 {
    // The bend where it ends wins: a clamp whose ends have changed places would panic.
    pieces.bend(time - motion.delay).max(motion.begin).min(motion.end)
}

/// The motion through a table of speeds that is at its first row at the time 0.
struct Pieces {
    /// Bend, speed, and the time at which a motion is there.
    rows: Vec<(f64, f64, f64)>,
}

impl Pieces {
    fn of(rows: &[(f64, f64)]) -> Self {
        let mut out: Vec<(f64, f64, f64)> = Vec::with_capacity(rows.len());
        for (bend, speed) in rows {
            let time = out.last().map_or(0.0, |(b, v, t)| t + passage(bend - b, *v, *speed));
            out.push((*bend, *speed, time));
        }
        Self { rows: out }
    }

    fn bend(&self, time: f64) -> f64 {
        let after = self.rows.partition_point(|row| row.2 < time);
        match (after.checked_sub(1).and_then(|i| self.rows.get(i)), self.rows.get(after)) {
            (Some((b, v, t)), Some((c, w, _))) => {
                // The speed grows with the bend: an exponential.
                let rate = (w - v) / (c - b);
                let passed = time - t;
                if (rate * passed).abs() < 1e-9 {
                    b + v * passed
                } else {
                    b + v * libm::expm1(rate * passed) / rate
                }
            }
            (Some((b, v, t)), None) | (None, Some((b, v, t))) => b + v * (time - t),
            (None, None) => 0.0,
        }
    }
}

/// How long it takes through a piece in which the speed changes with the bend from `v` to `w`.
fn passage(length: f64, v: f64, w: f64) -> f64 {
    let rate = (w - v) / length;
    if (w - v).abs() < 1e-9 * v { length / v } else { libm::log(w / v) / rate }
}

/// Fits a table of speeds to curves; each must rise and have points enough. Nothing, if there is none. `name` is that of a
/// stream of random numbers.
pub(super) fn fit(runs: &[Run], name: &str) -> Option<Fit> {
    let rounding = rounding(runs);
    let found = chosen(runs, rounding)?;
    let fit = found.finish(runs);
    let alone = alone(runs, &fit, rounding);
    let within = found.within(runs, &fit, name);
    Some(Fit { within: widened(&within, &fit.rows, &alone), alone, ..fit })
}

/// How fast each run is by itself, on the middle of its way, as a share of the speed that was fitted to all.
fn alone(runs: &[Run], fit: &Fit, rounding: f64) -> Vec<f64> {
    if runs.len() < 2 {
        return Vec::new();
    }
    let share = |(run, motion): (&Run, &Motion)| {
        let own = chosen(std::slice::from_ref(run), rounding)?;
        let own = own.rows(&own.numbers);
        let ratio = |place: f64| {
            let bend = motion.begin + place * (motion.end - motion.begin);
            libm::log(super::lines::at(&own, bend) / super::lines::at(&fit.rows, bend))
        };
        Some(libm::exp((2..=8).map(|tenth| ratio(f64::from(tenth) / 10.0)).sum::<f64>() / 7.0))
    };
    runs.iter().zip(&fit.motions).map(share).collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// Intervals that know how runs differ: points of a run tell nothing of what was another from run to run. The speed of all
/// is then as uncertain as the mean of so few (Student's t, of logarithms).
fn widened(within: &[(f64, f64)], rows: &[(f64, f64)], alone: &[f64]) -> Vec<(f64, f64)> {
    let logs: Vec<f64> = alone.iter().map(|share| libm::log(*share)).collect();
    let (_, deviation) = mean_and_deviation(&logs);
    let many = logs.len() as f64;
    let half = match logs.len() {
        0 | 1 => 0.0,
        runs => t_quantile(CONFIDENCE, runs - 1) * deviation / many.sqrt(),
    };
    let wide = libm::exp(half.min(FURTHEST));
    within.iter().zip(rows).map(|((low, high), (_, v))| (low.min(v / wide), high.max(v * wide))).collect()
}

/// The standard deviation of what rounding took from the bends, rad: that of the largest step that divides all of them.
fn rounding(runs: &[Run]) -> f64 {
    let mut bends: Vec<f64> = runs.iter().flat_map(|run| &run.points).map(|(_, bend)| *bend).collect();
    bends.sort_by(f64::total_cmp);
    let gaps = bends.windows(2).filter_map(|pair| Some(pair.last()? - pair.first()?));
    let step = gaps.fold(0.0, |step, gap| {
        // Euclid's method.
        let (mut large, mut small) = (gap.max(step), gap.min(step));
        while small > SAME {
            (large, small) = (small, large % small);
        }
        large
    });
    step / 12_f64.sqrt()
}

/// The table with as many rows as the points can bear.
fn chosen(runs: &[Run], rounding: f64) -> Option<Trial> {
    let rests = runs.iter().map(Run::rest).collect::<Option<Vec<_>>>()?;
    let low = rests.iter().map(|m| m.begin).fold(f64::INFINITY, f64::min);
    let high = rests.iter().map(|m| m.end).fold(f64::NEG_INFINITY, f64::max);
    let points: usize = runs.iter().map(|run| run.points.len()).sum();
    if points == 0 || low >= high {
        return None;
    }
    let speed = median(runs.iter().zip(&rests).map(|(run, rest)| run.mean_speed(rest)));
    let mut trial = Trial::begin(runs, &rests, (low, speed), rounding);
    let mut tried: Vec<(f64, f64, Trial)> = Vec::new();
    for size in SIZES {
        // A row needs some points of its own.
        if size > 1 && (points < 6 * size || trial.telling < LEAST_POINTS * size) {
            break;
        }
        trial = trial.with_rows(size, (low, high));
        trial.improve(runs);
        if size == 1 && trial.is_thin(points) {
            // Of few points the way between two of them is no good guess of the speed.
            for guess in GUESSES {
                let mut other = Trial::begin(runs, &rests, (low, guess * speed), rounding);
                other.improve(runs);
                if other.judge(runs).0 < trial.judge(runs).0 {
                    trial = other;
                }
            }
        }
        let (rms, score) = trial.judge(runs);
        tried.push((rms, score, trial.clone()));
    }
    // Schwarz's criterion says how many rows the points can bear; of those that are as good, the fewest.
    let best = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(rms, ..)| *rms)?;
    let few = tried.into_iter().find(|(rms, ..)| *rms <= best * (1.0 + GAIN))?;
    Some(few.2)
}

impl Run {
    /// Its points that show it on its way; those at rest say nothing of its speed.
    pub(super) fn moving(&self) -> usize {
        let Some(Motion { begin, end, .. }) = self.rest() else { return 0 };
        let (low, high) = (begin + REST * (end - begin), end - REST * (end - begin));
        self.points.iter().filter(|(_, bend)| low < *bend && *bend < high).count()
    }

    /// Where it begins and ends, as far as its points say, and when it passes its middle.
    fn rest(&self) -> Option<Motion> {
        let bends: Vec<f64> = self.points.iter().map(|(_, bend)| *bend).collect();
        let course = course(&bends);
        let (low, high) = (*course.first()?, *course.last()?);
        let passed = |share: f64| course.partition_point(|bend| *bend < low + share * (high - low));
        // The ends of the course are those of the noise, too: the middle of the points near them is not.
        let begin = median(bends.get(..passed(0.05).max(1))?.iter().copied());
        let end = median(bends.get(passed(0.95).min(bends.len() - 1)..)?.iter().copied());
        let delay = self.points.get(passed(0.5))?.0;
        (begin < end).then_some(Motion { delay, begin, end })
    }

    /// How fast it goes from a fifth to four fifths of its way.
    fn mean_speed(&self, rest: &Motion) -> f64 {
        let bends: Vec<f64> = self.points.iter().map(|(_, bend)| *bend).collect();
        let course = course(&bends);
        let at = |share: f64| {
            let passed = course.partition_point(|bend| *bend < rest.begin + share * (rest.end - rest.begin));
            self.points.get(passed).or(self.points.last()).map_or(0.0, |p| p.0)
        };
        let (first, last) =
            (self.points.first().map_or(0.0, |p| p.0), self.points.last().map_or(0.0, |p| p.0));
        let time = (at(0.8) - at(0.2)).max(1e-3 * (last - first)).max(1e-9);
        0.6 * (rest.end - rest.begin) / time
    }
}

/// How many points of all runs say something of speeds: of each run one says when it was on its way.
pub(super) fn telling(runs: &[Run]) -> usize {
    runs.iter().map(|run| run.moving().saturating_sub(1)).sum()
}

/// A table and motions on their way to a fit.
#[derive(Clone)]
struct Trial {
    /// See [`telling`].
    telling: usize,
    /// See [`rounding`].
    rounding: f64,
    bends: Vec<f64>,
    /// Logarithms of speeds, then three numbers for each run.
    numbers: DVector<f64>,
}

impl Trial {
    fn begin(runs: &[Run], rests: &[Motion], (low, speed): (f64, f64), rounding: f64) -> Self {
        let mut numbers = vec![libm::log(speed)];
        for (_, rest) in runs.iter().zip(rests) {
            let middle = 0.5 * (rest.begin + rest.end);
            numbers.extend([rest.delay - (middle - low) / speed, rest.begin, rest.end]);
        }
        Self { telling: telling(runs), rounding, bends: vec![low], numbers: DVector::from_vec(numbers) }
    }

    fn rows(&self, numbers: &DVector<f64>) -> Vec<(f64, f64)> {
        // No speed is so far from the others that it could be told.
        let speed = |log: &f64| libm::exp(log.clamp(-20.0, 20.0));
        self.bends.iter().zip(numbers.iter()).map(|(bend, log)| (*bend, speed(log))).collect()
    }

    fn motion(&self, numbers: &DVector<f64>, run: usize) -> Motion {
        let first = self.bends.len() + 3 * run;
        let at = |i: usize| numbers.get(first + i).copied().unwrap_or(0.0);
        Motion { delay: at(0), begin: at(1), end: at(2) }
    }

    /// The same table with other rows.
    fn with_rows(&self, size: usize, (low, high): (f64, f64)) -> Self {
        let old = self.rows(&self.numbers);
        let bends: Vec<f64> = (0..size)
            .map(|i| if size == 1 { low } else { low + (high - low) * i as f64 / (size - 1) as f64 })
            .collect();
        let logs = bends.iter().map(|bend| libm::log(super::lines::at(&old, *bend)));
        let rest = self.numbers.iter().skip(self.bends.len()).copied();
        let numbers = DVector::from_vec(logs.chain(rest).collect());
        Self { bends, numbers, ..*self }
    }

    fn residuals(&self, numbers: &DVector<f64>, runs: &[Run]) -> DVector<f64> {
        let pieces = Pieces::of(&self.rows(numbers));
        let mut out = Vec::new();
        for (i, run) in runs.iter().enumerate() {
            let motion = self.motion(numbers, i);
            out.extend(run.points.iter().map(|(time, b)| b - bend(&pieces, &motion, *time)));
        }
        DVector::from_vec(out)
    }

    /// How the motions change with each number.
    fn jacobian(&self, runs: &[Run], residuals: &DVector<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(residuals.len(), self.numbers.len());
        for j in 0..self.numbers.len() {
            let mut moved = self.numbers.clone();
            let step = 1e-6 * moved[j].abs().max(1.0);
            moved[j] += step;
            out.set_column(j, &((residuals - self.residuals(&moved, runs)) / step));
        }
        out
    }

    /// Whether there are too few points for each number that is fitted to them.
    fn is_thin(&self, points: usize) -> bool {
        points < LEAST_POINTS * self.numbers.len() || self.telling < 2 * LEAST_POINTS * self.bends.len()
    }

    /// The standard deviation of residuals, whatever a few of them are. Where most are zero, as at rest, it is that of rounding.
    fn scale(&self, residuals: &DVector<f64>) -> f64 {
        (1.4826 * median(residuals.iter().map(|r| r.abs()))).max(self.rounding).max(1e-9)
    }

    fn improve(&mut self, runs: &[Run]) {
        for _ in 0..TURNS.0 {
            let residuals = self.residuals(&self.numbers, runs);
            let scale = self.scale(&residuals);
            // Few points say nothing of which of them is wrong.
            let weights = match self.is_thin(residuals.len()) {
                true => residuals.map(|_| 1.0),
                false => residuals.map(|r| weight(r, scale)),
            };
            let before = self.numbers.clone();
            self.descend(runs, &weights);
            if (&self.numbers - before).amax() < 1e-6 {
                break;
            }
        }
    }

    /// Levenberg and Marquardt's method.
    fn descend(&mut self, runs: &[Run], weights: &DVector<f64>) {
        let cost = |r: &DVector<f64>| r.iter().zip(weights.iter()).map(|(r, w)| w * r * r).sum::<f64>();
        let mut residuals = self.residuals(&self.numbers, runs);
        let mut damping = 1e-3;
        for _ in 0..TURNS.1 {
            let (normal, gradient) = self.normal(runs, &residuals, weights);
            let now = cost(&residuals);
            let mut better = None;
            while damping < 1e9 {
                let mut damped = normal.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] += damping * normal[(i, i)].max(1e-9);
                }
                if let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) {
                    let moved = &self.numbers + &step;
                    let after = self.residuals(&moved, runs);
                    if cost(&after) < now {
                        better = Some((moved, after));
                        break;
                    }
                }
                damping *= 4.0;
            }
            let Some((moved, after)) = better else { return };
            let gained = now - cost(&after);
            (self.numbers, residuals) = (moved, after);
            damping = (damping / 10.0).max(1e-12);
            if gained <= 1e-9 * now {
                return;
            }
        }
    }

    /// The matrix and the right side of the normal equations.
    fn normal(
        &self,
        runs: &[Run],
        residuals: &DVector<f64>,
        weights: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let jacobian = self.jacobian(runs, residuals);
        let mut weighed = jacobian.clone();
        for (mut row, weight) in weighed.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        (weighed.transpose() * &jacobian, weighed.transpose() * residuals)
    }

    /// The residual with far points counting less, and Schwarz's criterion.
    fn judge(&self, runs: &[Run]) -> (f64, f64) {
        let residuals = self.residuals(&self.numbers, runs);
        let scale = self.scale(&residuals);
        let n = residuals.len() as f64;
        let squares = residuals.iter().map(|r| weight(*r, scale) * r * r).sum::<f64>() / n;
        // Below this a residual is that of rounding, or of arithmetic.
        let squares = squares.max(self.rounding * self.rounding).max(1e-12);
        (squares.sqrt(), n * libm::log(squares) + self.numbers.len() as f64 * libm::log(n))
    }

    /// Where each speed lies nine times of ten: what comes out where each run is made again from the fit and residuals that are
    /// drawn from its own, rows chosen anew (bootstrap).
    fn within(&self, runs: &[Run], fit: &Fit, name: &str) -> Vec<(f64, f64)> {
        let mut random = Stream::named(0, name);
        let fitted =
            |run: usize, time: f64| fit.motions.get(run).map_or(0.0, |motion| fit.bend(motion, time));
        let residuals: Vec<Vec<f64>> = runs
            .iter()
            .enumerate()
            .map(|(i, run)| {
                let points = run.points.iter().enumerate().filter(|(k, _)| !fit.far.contains(&(i, *k)));
                points.map(|(_, (time, bend))| bend - fitted(i, *time)).collect()
            })
            .collect();
        let mut speeds: Vec<Vec<f64>> = vec![Vec::new(); fit.rows.len()];
        for _ in 0..DRAWS {
            let again: Vec<Run> = runs
                .iter()
                .zip(&residuals)
                .enumerate()
                .map(|(i, (run, own))| {
                    let mut drawn = || own.get(random.below(own.len())).copied().unwrap_or(0.0);
                    Run { points: run.points.iter().map(|(t, _)| (*t, fitted(i, *t) + drawn())).collect() }
                })
                .collect();
            let Some(found) = chosen(&again, self.rounding) else { continue };
            let rows = found.rows(&found.numbers);
            for (speeds, (bend, _)) in speeds.iter_mut().zip(&fit.rows) {
                speeds.push(super::lines::at(&rows, *bend));
            }
        }
        // The fit itself lies within, whatever was drawn.
        let own = |speeds: &mut Vec<f64>, speed: f64| {
            quantiles(speeds).map_or((speed, speed), |(low, high)| (low.min(speed), high.max(speed)))
        };
        speeds.iter_mut().zip(&fit.rows).map(|(speeds, (_, speed))| own(speeds, *speed)).collect()
    }

    fn finish(&self, runs: &[Run]) -> Fit {
        let residuals = self.residuals(&self.numbers, runs);
        let scale = self.scale(&residuals);
        let is_thin = self.is_thin(residuals.len());
        let places = runs.iter().enumerate().flat_map(|(i, run)| (0..run.points.len()).map(move |k| (i, k)));
        Fit {
            rows: self.rows(&self.numbers),
            within: Vec::new(),
            far: places
                .zip(residuals.iter())
                .filter(|(_, r)| !is_thin && r.abs() > FAR * scale)
                .map(|(at, _)| at)
                .collect(),
            motions: (0..runs.len()).map(|i| self.motion(&self.numbers, i)).collect(),
            alone: Vec::new(),
            is_thin,
        }
    }
}

/// What a residual counts.
fn weight(residual: f64, scale: f64) -> f64 {
    let far = residual.abs() / (HUBER * scale);
    if far > 1.0 { 1.0 / far } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between -1 and 1 from a stream that is the same everywhere; the sum of a few is nearly normal.
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            let mut sum = 0.0;
            for _ in 0..6 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            }
            sum * 2.0_f64.sqrt()
        }
    }

    /// Curves of 60 frames a second that follow from a table of speeds, in degrees, with noise.
    fn filmed(truth: &[(f64, f64)], runs: usize, deviation: f64, odd: usize) -> Vec<Run> {
        let rows: Vec<(f64, f64)> = truth.iter().map(|(b, v)| (b.to_radians(), v.to_radians())).collect();
        let pieces = Pieces::of(&rows);
        let mut noise = noise(7);
        (0..runs)
            .map(|r| {
                let motion = Motion { delay: 0.2 + 0.07 * r as f64, begin: 0.0, end: 90_f64.to_radians() };
                let points = (0..150).map(|i| {
                    let time = f64::from(i) / 60.0;
                    let slip = if odd > 0 && i as usize % odd == 3 { 25.0 } else { 0.0 };
                    (time, bend(&pieces, &motion, time) + (deviation * noise() + slip).to_radians())
                });
                Run { points: points.collect() }
            })
            .collect()
    }

    /// How far the found speeds are from the true ones on the way, as a share of the largest.
    fn error(found: &Fit, truth: &[(f64, f64)]) -> f64 {
        let rows: Vec<(f64, f64)> =
            found.rows.iter().map(|(b, v)| (b.to_degrees(), v.to_degrees())).collect();
        let most = truth.iter().map(|(_, v)| *v).fold(0.0, f64::max);
        (5..=85)
            .map(|b| {
                (super::super::lines::at(&rows, f64::from(b)) - super::super::lines::at(truth, f64::from(b)))
                    .abs()
                    / most
            })
            .fold(0.0, f64::max)
    }

    const SLOWING: [(f64, f64); 3] = [(0.0, 120.0), (60.0, 80.0), (90.0, 20.0)];

    #[test]
    fn a_table_is_found_again_without_noise() {
        let found = fit(&filmed(&SLOWING, 1, 0.0, 0), "t").unwrap();
        assert!(error(&found, &SLOWING) < 0.02, "{:?}", found.rows);
    }

    #[test]
    fn a_table_is_found_again_within_the_noise() {
        for (runs, deviation, most) in [(1, 1.0, 0.15), (3, 1.0, 0.1), (5, 2.0, 0.15)] {
            let found = fit(&filmed(&SLOWING, runs, deviation, 0), "t").unwrap();
            let error = error(&found, &SLOWING);
            assert!(error < most, "{runs} runs with {deviation} deg: {error}, {:?}", found.rows);
        }
    }

    #[test]
    fn a_constant_speed_is_one_number() {
        let truth = [(0.0, 95.0)];
        for deviation in [0.0, 0.5, 2.0] {
            let found = fit(&filmed(&truth, 3, deviation, 0), "t").unwrap();
            assert_eq!(found.rows.len(), 1, "{deviation}: {:?}", found.rows);
            let speed = found.rows[0].1.to_degrees();
            assert!((speed - 95.0).abs() < 1.5, "{deviation}: {speed}");
            let (low, high) = found.within[0];
            let wide = (high - low).to_degrees();
            assert!((speed - 95.0).abs() <= wide + 1e-3, "{speed} is not within {low} to {high}");
        }
    }

    /// Most of a film shows rest, where whole degrees leave no residual: those on the way are no outliers, and need no rows.
    #[test]
    fn what_rounding_takes_is_no_slip() {
        for (time, step) in [(0.02, 1.0), (0.033, 1.0), (0.05, 1.0), (0.033, 0.1)] {
            let read = |i: u32| {
                let bend = (95.0 * time * f64::from(i)).min(90.0);
                (time * f64::from(i), ((bend / step).round() * step).to_radians())
            };
            let found = fit(&[Run { points: (0..80).map(read).collect() }], "t").unwrap();
            assert!(found.far.is_empty(), "{time} s, {step} deg: {:?}", found.far);
            assert_eq!(found.rows.len(), 1, "{time} s, {step} deg: {:?}", found.rows);
        }
    }

    #[test]
    fn points_that_are_far_off_hardly_count() {
        let found = fit(&filmed(&SLOWING, 3, 1.0, 20), "t").unwrap();
        assert!(error(&found, &SLOWING) < 0.15, "{:?}", found.rows);
        // Every twentieth of 150 points of each run, but for slips that the noise takes back.
        assert!((20..=24).contains(&found.far.len()), "{:?}", found.far);
        assert!(found.far.iter().all(|(_, place)| place % 20 == 3), "{:?}", found.far);
    }

    /// The intervals are as wide as what other films of the same motion would give.
    #[test]
    fn intervals_are_as_wide_as_films_scatter() {
        let films = filmed(&SLOWING, 24, 1.0, 0);
        let at =
            |found: &Fit, bend: f64| super::super::lines::at(&found.rows, bend.to_radians()).to_degrees();
        let fits: Vec<Fit> = films.iter().map(|film| fit(std::slice::from_ref(film), "t").unwrap()).collect();
        for (bend, truth) in [(2.0, 118.7), (45.0, 90.0), (75.0, 50.0)] {
            let within = |found: &&Fit| {
                let ends: Vec<[(f64, f64); 2]> = found
                    .rows
                    .iter()
                    .zip(&found.within)
                    .map(|((b, _), (low, high))| [(b.to_degrees(), *low), (b.to_degrees(), *high)])
                    .collect();
                let side = |k: usize| ends.iter().map(|both| both[k]).collect::<Vec<_>>();
                let (low, high) =
                    (super::super::lines::at(&side(0), bend), super::super::lines::at(&side(1), bend));
                (low.to_degrees()..=high.to_degrees()).contains(&truth)
            };
            let held = fits.iter().filter(within).count();
            let speeds: Vec<f64> = fits.iter().map(|found| at(found, bend)).collect();
            assert!(held >= 17, "{bend} deg: {held} of 24 hold {truth}: {speeds:?}");
        }
    }

    /// Where each film has a speed of its own, nine of ten intervals hold the speed that they scatter around.
    #[test]
    fn intervals_know_how_films_differ() {
        let mut scatter = noise(11);
        let held = (0..400)
            .filter(|_| {
                let logs = [(); 3].map(|()| 0.08 * scatter());
                let mean = logs.iter().sum::<f64>() / 3.0;
                let shares = logs.map(|log| libm::exp(log - mean));
                let speed = 50.0 * libm::exp(mean);
                let (low, high) = widened(&[(speed, speed)], &[(0.0, speed)], &shares)[0];
                (low..=high).contains(&50.0)
            })
            .count();
        assert!((340..=380).contains(&held), "{held} of 400");
    }

    #[test]
    fn films_of_several_speeds_are_known_by_them() {
        let speeds = [44.0, 50.0, 57.0];
        let films: Vec<Run> = speeds.iter().flat_map(|speed| filmed(&[(0.0, *speed)], 1, 0.5, 0)).collect();
        let found = fit(&films, "t").unwrap();
        for (alone, speed) in found.alone.iter().zip(speeds) {
            assert!((alone * 50.0 / speed - 1.0).abs() < 0.05, "{:?}", found.alone);
        }
        let (low, high) = found.within[0];
        assert!(low.to_degrees() < 44.0 && high.to_degrees() > 57.0, "{low} .. {high}");
        assert!(fit(&films[..1], "t").unwrap().alone.is_empty());
    }

    #[test]
    fn a_motion_has_the_speed_that_its_table_says() {
        let rows: Vec<(f64, f64)> = SLOWING.to_vec();
        let pieces = Pieces::of(&rows);
        for i in 0..100 {
            let time = f64::from(i) * 0.012;
            let (a, b) = (pieces.bend(time), pieces.bend(time + 1e-6));
            let speed = super::super::lines::at(&rows, a);
            assert!(((b - a) / 1e-6 - speed).abs() < 1e-2, "{time}: {} is not {speed}", (b - a) / 1e-6);
        }
    }

    #[test]
    fn few_points_are_all_believed_and_say_nothing_of_themselves() {
        // 80 deg/s from 0.3 s on, up to 90 deg.
        let points = [(0.0, 0.0), (0.5, 16.0), (1.0, 56.0), (1.5, 90.0), (2.0, 90.0)];
        let run = Run { points: points.iter().map(|(t, b): &(f64, f64)| (*t, b.to_radians())).collect() };
        let found = fit(&[run], "few").unwrap();
        let [(_, speed)] = found.rows.as_slice() else { panic!("{:?}", found.rows) };
        assert!((speed.to_degrees() - 80.0).abs() < 0.5, "{}", speed.to_degrees());
        assert!(found.is_thin && found.far.is_empty());
    }
}
