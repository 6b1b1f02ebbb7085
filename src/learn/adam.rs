//! Adam: steps along gradients, scaled by their size of late (Kingma and Ba 2015).

use serde::{Deserialize, Serialize};

use super::packed;

const FIRST: f32 = 0.9;
const SECOND: f32 = 0.999;
const LEAST: f32 = 1e-8;

/// The moments of the gradients of some weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Adam {
    #[serde(with = "packed")]
    first: Vec<f32>,
    #[serde(with = "packed")]
    second: Vec<f32>,
    /// How often it has stepped.
    steps: u32,
}

impl Adam {
    /// For so many weights.
    pub(super) fn new(weights: usize) -> Self {
        Self { first: vec![0.0; weights], second: vec![0.0; weights], steps: 0 }
    }

    /// Moves weights against their gradients.
    pub(super) fn step(&mut self, weights: &mut [f32], gradients: &[f32], rate: f32) {
        self.steps = self.steps.saturating_add(1);
        let age = |kept: f32| 1.0 - libm::pow(f64::from(kept), f64::from(self.steps)) as f32;
        let (first_age, second_age) = (age(FIRST), age(SECOND));
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((weight, gradient), (first, second)) in weights.iter_mut().zip(gradients).zip(moments) {
            *first = FIRST * *first + (1.0 - FIRST) * gradient;
            *second = SECOND * *second + (1.0 - SECOND) * gradient * gradient;
            let step = rate * (*first / first_age) / ((*second / second_age).sqrt() + LEAST);
            *weight -= step;
        }
    }
}
