//! Covariance matrix adaptation: a normal distribution of curves that follows the better half of its
//! samples (Hansen, "The CMA evolution strategy: a tutorial", 2016), with the Cholesky factor of the
//! covariance in place of its root (Krause, Arbonès and Igel 2016), which needs no eigenvalues: only
//! operations that give the same bits everywhere.

use grammar_lang::ir::{CmaEs, Schedule};
use nalgebra::{Cholesky, DMatrix, DVector};

use super::super::schedule::{Course, Iteration, Plan, Stand};
use super::super::state::{Distribution, Tuning};
use super::super::{End, Failure};
use super::judging::{Counted, When};
use super::{Progress, Tuner, best};
use crate::derive::Candidate;
use crate::drive::Parameters;

/// Samples of a generation, at least: two to follow and two to leave.
const FEWEST: usize = 4;
/// And at most: they are all in memory at once.
const MOST: usize = 10_000;

/// A sample: where it lies, as shares of the ranges; and how good it is.
struct Sample {
    shares: Vec<f64>,
    fitness: f64,
}

impl Tuner<'_> {
    /// A distribution around curves.
    pub(super) fn distribution(&self, mean: &Parameters, spread: f64, course: Course) -> Distribution {
        let mean = self.evaluator.drive.shares(mean);
        Distribution { course, restarts: 0, ..Distribution::around(mean, spread) }
    }

    /// Goes on by a generation.
    pub(super) fn evolve(
        &mut self,
        schedule: &Schedule,
        cma_es: &CmaEs,
        tuning: &mut Tuning,
        state: &mut Distribution,
        spent: &mut u64,
    ) -> Result<Progress, Failure> {
        if let Some(end) = self.bounds.exhausted(*spent) {
            return Ok(Progress::Cut(end));
        }
        self.spent = self.bounds.share(*spent);
        let Some(Iteration { moves, .. }) = self.plan_of(schedule, state).begin()? else {
            let is_judged = self.judge_offered(tuning, spent, When::AtTheEnd)?;
            return if is_judged { Ok(Progress::Done) } else { self.stopped() };
        };
        let mut random = self.stream(&format!("generation {}", state.course.iteration));
        let points = state.sample(moves.clamp(FEWEST, MOST), &mut || random.normal(0.0, 1.0));
        let (mut candidates, points): (Vec<Parameters>, Vec<Vec<f64>>) =
            points.iter().map(|point| self.evaluator.drive.at_shares(point, &mut random)).unzip();
        // Nothing is simulated that could not be counted.
        candidates.truncate(self.bounds.left(*spent));
        let Some(values) = self.evaluator.evaluate(self.bounds.stop, &candidates) else {
            return self.stopped();
        };
        self.prepare_checks(tuning, &candidates, &values);
        // A generation is made whole or not at all.
        let (mut now, mut counted) = (tuning.clone(), *spent);
        let drawn = points.len();
        let mut samples = Vec::with_capacity(drawn);
        for ((candidate, shares), evaluated) in candidates.iter().zip(points).zip(values) {
            if let Some(end) = self.bounds.exhausted(counted) {
                if !end.is_early() {
                    (*tuning, *spent) = (now, counted);
                }
                return Ok(Progress::Cut(end));
            }
            let each = evaluated.each.clone();
            let fitness = match self.count(&mut now, candidate, evaluated, &mut counted)? {
                Counted::Stopped => return self.stopped(),
                counted => counted.fitness(),
            };
            if let Some(fitness) = fitness {
                self.offer(&mut now, candidate, fitness, &each);
            }
            samples.push(Sample { shares, fitness: fitness.unwrap_or(f64::NEG_INFINITY) });
        }
        if samples.len() < drawn {
            (*tuning, *spent) = (now, counted);
            return Ok(Progress::Cut(End::Budget));
        }
        if !self.judge_offered(&mut now, &mut counted, When::Underway)? {
            return self.stopped();
        }
        let mut next = state.clone();
        let is_sound = next.follow(samples);
        next.course.complete(best(&now));
        self.spent = self.bounds.share(counted);
        let is_over = self.plan_of(schedule, &next).stops()?;
        if is_over && !self.judge_offered(&mut now, &mut counted, When::AtTheEnd)? {
            return self.stopped();
        }
        (*tuning, *spent, *state) = (now, counted, next);
        if is_over {
            return Ok(Progress::Done);
        }
        if !is_sound || self.plan_of(schedule, state).restarts(cma_es.restart.as_ref())? {
            self.restart(cma_es, state);
        }
        Ok(Progress::More)
    }

    /// Begins anew elsewhere, with the course of the search as it is.
    fn restart(&self, cma_es: &CmaEs, state: &mut Distribution) {
        let restarts = state.restarts + 1;
        let mean = self.evaluator.drive.draw(&mut self.stream(&format!("restart {restarts}")));
        let mean = self.evaluator.drive.shares(&mean);
        let course = std::mem::take(&mut state.course);
        *state = Distribution { course, restarts, ..Distribution::around(mean, cma_es.spread) };
    }

    fn plan_of<'p>(&'p self, schedule: &'p Schedule, state: &'p Distribution) -> Plan<'p> {
        let stand = Stand::Distribution(state.spread());
        let Candidate { rules, derivation, .. } = self.candidate();
        Plan { rules, derivation, schedule, course: &state.course, stand, around: self.around() }
    }
}

impl Distribution {
    /// A round distribution.
    fn around(mean: Vec<f64>, sigma: f64) -> Self {
        let n = mean.len();
        Self {
            course: Course::default(),
            mean,
            sigma,
            covariance: DMatrix::<f64>::identity(n, n).as_slice().to_vec(),
            sigma_path: vec![0.0; n],
            path: vec![0.0; n],
            generation: 0,
            restarts: 0,
        }
    }

    /// The standard deviation of the samples, as a share of the ranges, in the mean of squares.
    pub(in super::super) fn spread(&self) -> f64 {
        let n = self.mean.len();
        let trace: f64 = self.covariance.iter().step_by(n + 1).sum();
        self.sigma * libm::sqrt(trace / n.max(1) as f64)
    }

    fn covariance(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(self.mean.len(), self.mean.len(), &self.covariance)
    }

    /// Draws samples with standard normal numbers; they may lie beyond the ranges.
    fn sample(&self, count: usize, normal: &mut impl FnMut() -> f64) -> Vec<Vec<f64>> {
        let n = self.mean.len();
        let factor =
            Cholesky::new(self.covariance()).map_or_else(|| DMatrix::identity(n, n), |cholesky| cholesky.l());
        let one = |_| {
            let z = DVector::from_fn(n, |_, _| normal());
            let step = &factor * z * self.sigma;
            self.mean.iter().zip(step.iter()).map(|(mean, step)| mean + step).collect()
        };
        (0..count).map(one).collect()
    }

    /// Moves towards the better half of the samples, where they were evaluated: within the ranges. Whether
    /// there is still a distribution to draw from.
    fn follow(&mut self, mut samples: Vec<Sample>) -> bool {
        let n = self.mean.len();
        let dimensions = n as f64;
        // Stable: of equals the first drawn comes first.
        samples.sort_by(|a, b| b.fitness.total_cmp(&a.fitness));
        let parents = samples.len() / 2;
        let raw: Vec<f64> = (0..parents)
            .map(|i| libm::log((samples.len() as f64 + 1.0) / 2.0) - libm::log(i as f64 + 1.0))
            .collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
        let mass = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        // The rates of the tutorial's table 1.
        let rate_sigma = (mass + 2.0) / (dimensions + mass + 5.0);
        let damping = 1.0 + 2.0 * (libm::sqrt((mass - 1.0) / (dimensions + 1.0)) - 1.0).max(0.0) + rate_sigma;
        let rate_path = (4.0 + mass / dimensions) / (dimensions + 4.0 + 2.0 * mass / dimensions);
        let rate_one = 2.0 / ((dimensions + 1.3) * (dimensions + 1.3) + mass);
        let rate_many = (1.0 - rate_one)
            .min(2.0 * (mass - 2.0 + 1.0 / mass) / ((dimensions + 2.0) * (dimensions + 2.0) + mass));
        let normal_length =
            libm::sqrt(dimensions) * (1.0 - 0.25 / dimensions + 1.0 / (21.0 * dimensions * dimensions));

        let mean = DVector::from_column_slice(&self.mean);
        let steps: Vec<DVector<f64>> = samples[..parents]
            .iter()
            .map(|sample| (DVector::from_column_slice(&sample.shares) - &mean) / self.sigma)
            .collect();
        let mut step = DVector::zeros(n);
        for (weight, one) in weights.iter().zip(&steps) {
            step += one * *weight;
        }
        let covariance = self.covariance();
        let Some(factor) = Cholesky::new(covariance.clone()) else { return false };
        let Some(round) = factor.l_dirty().solve_lower_triangular(&step) else { return false };
        self.generation += 1;
        let kept = libm::sqrt(rate_sigma * (2.0 - rate_sigma) * mass);
        let sigma_path = DVector::from_column_slice(&self.sigma_path) * (1.0 - rate_sigma) + round * kept;
        let age = 1.0 - libm::pow(1.0 - rate_sigma, 2.0 * self.generation as f64);
        let is_steady =
            sigma_path.norm() / libm::sqrt(age) < (1.4 + 2.0 / (dimensions + 1.0)) * normal_length;
        let mut path = DVector::from_column_slice(&self.path) * (1.0 - rate_path);
        if is_steady {
            path += &step * libm::sqrt(rate_path * (2.0 - rate_path) * mass);
        }
        let lost = if is_steady { 0.0 } else { rate_one * rate_path * (2.0 - rate_path) };
        let mut next = covariance * (1.0 - rate_one - rate_many + lost) + &path * path.transpose() * rate_one;
        for (weight, one) in weights.iter().zip(&steps) {
            next += one * one.transpose() * (rate_many * *weight);
        }
        self.mean = (mean + step * self.sigma).iter().map(|x| x.clamp(0.0, 1.0)).collect();
        let change = (rate_sigma / damping) * (sigma_path.norm() / normal_length - 1.0);
        // At most by a factor in a generation, and no wider than the ranges.
        self.sigma = (self.sigma * libm::exp(change.min(1.0))).min(1.0);
        self.covariance = next.as_slice().to_vec();
        self.sigma_path = sigma_path.as_slice().to_vec();
        self.path = path.as_slice().to_vec();
        self.spread().is_finite() && self.spread() > 0.0 && Cholesky::new(next).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::random::Stream;

    fn minimise(f: impl Fn(&[f64]) -> f64, n: usize, generations: usize) -> f64 {
        let mut random = Stream::named(1, "evolution");
        let mut state = Distribution::around(vec![0.2; n], 0.3);
        let mut least = f64::INFINITY;
        for _ in 0..generations {
            let samples = state.sample(12, &mut || random.normal(0.0, 1.0)).into_iter().map(|shares| {
                let shares: Vec<f64> = shares.iter().map(|x: &f64| x.clamp(0.0, 1.0)).collect();
                let value = f(&shares);
                least = least.min(value);
                Sample { shares, fitness: -value }
            });
            let samples = samples.collect();
            assert!(state.follow(samples));
        }
        least
    }

    #[test]
    fn it_finds_the_middle_of_a_bowl_and_of_a_long_valley() {
        let bowl = |x: &[f64]| x.iter().map(|x| (x - 0.7) * (x - 0.7)).sum();
        assert!(minimise(bowl, 8, 120) < 1e-9);
        // A thousand times as steep across as along, and askew.
        let valley = |x: &[f64]| {
            let (a, b) = (x[0] - 0.6 + (x[1] - 0.4), x[0] - 0.6 - (x[1] - 0.4));
            1e6 * a * a + b * b + (x[2] - 0.5) * (x[2] - 0.5)
        };
        assert!(minimise(valley, 3, 300) < 1e-9);
    }

    #[test]
    fn it_stays_at_a_bound_where_the_best_lies_beyond() {
        let beyond = |x: &[f64]| x.iter().map(|x| (x - 2.0) * (x - 2.0)).sum();
        assert!((minimise(beyond, 6, 150) - 6.0).abs() < 1e-9);
    }

    #[test]
    fn the_spread_is_that_of_its_samples() {
        let mut random = Stream::named(2, "spread");
        let state = Distribution::around(vec![0.5; 4], 0.25);
        let samples = state.sample(4000, &mut || random.normal(0.0, 1.0));
        let squares: f64 = samples.iter().flatten().map(|x| (x - 0.5) * (x - 0.5)).sum();
        assert!((libm::sqrt(squares / 16_000.0) - state.spread()).abs() < 0.005);
    }
}
