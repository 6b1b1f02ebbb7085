//! Soft actor-critic: an actor that draws what it does, two critics that say what that is worth, and a temperature that keeps the actor
//! drawing (Haarnoja and others 2018, "Soft actor-critic algorithms and applications").

use serde::{Deserialize, Serialize};

use super::adam::Adam;
use super::layers::{Hidden, Layers};
use super::replay::Batch;
use super::tanh::tanh;
use super::{Rates, Replay, together};
use crate::derive::random::Stream;

/// Where the logarithm of a deviation of the actor is held.
const LOG_DEVIATION: (f32, f32) = (-5.0, 2.0);
/// Where the logarithm of the temperature is held.
const LOG_TEMPERATURE: (f32, f32) = (-10.0, 3.0);
/// The deviation of the first weights of outputs: an actor begins near the middle of what it may do.
const FIRST_OUTPUTS: f32 = 0.1;
/// Keeps the logarithm finite where an action is at an end of its range.
const LEAST: f32 = 1e-6;
/// Half the logarithm of twice pi.
const HALF_LOG_TAU: f32 = 0.918_938_5;

/// How it learns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActorCriticSettings {
    /// What every learner is told.
    pub rates: Rates,
    /// The entropy that the temperature holds, of each action.
    pub entropy: f32,
}

/// The networks of a soft actor-critic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActorCritic {
    /// Its outputs are the middle of each action before `tanh`, then the logarithm of each deviation.
    actor: Layers,
    actions: usize,
    critics: [Critic; 2],
    log_temperature: f32,
    steps: [Adam; 2],
}

/// What says how much decisions are worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Critic {
    own: Layers,
    /// What the own network follows slowly.
    target: Layers,
    steps: Adam,
}

impl Critic {
    /// Learns what decisions are worth.
    fn learn(&mut self, input: Vec<f32>, worth: &[f32], rates: Rates) {
        let samples = worth.len();
        let values = self.own.forward(input, samples);
        let share = 2.0 / samples as f32;
        let wrong =
            values.outputs().iter().zip(worth).map(|(value, worth)| share * (value - worth)).collect();
        let gradients = self.own.of_weights(&values, wrong);
        self.steps.step(&mut self.own.weights, &gradients, rates.learning_rate);
        self.target.follow(&self.own, rates.target_rate);
    }

    /// What decisions are worth, and what each of their actions is.
    fn judge(&self, input: &[f32], inputs: usize, samples: usize) -> (Vec<f32>, Vec<f32>) {
        let values = self.own.forward(input.to_vec(), samples);
        let worth = self.own.of_inputs(&values, vec![1.0; samples]);
        (values.outputs().to_vec(), worth[inputs * samples..].to_vec())
    }
}

/// What an actor draws for a batch.
struct Drawn {
    /// Between -1 and 1: a row for each action.
    actions: Vec<f32>,
    /// The normal numbers that were drawn for them.
    noise: Vec<f32>,
    deviations: Vec<f32>,
    /// Whether the deviation is held at an end.
    held: Vec<bool>,
    /// The logarithm of how likely each sample was.
    log_likelihoods: Vec<f32>,
}

impl ActorCritic {
    /// Networks for so many inputs and actions.
    #[must_use]
    pub fn new(
        inputs: usize,
        hidden: &[usize],
        actions: usize,
        critic: &[usize],
        random: &mut Stream,
    ) -> Self {
        let actor = [&[inputs], hidden, &[2 * actions]].concat();
        let actor = Layers::drawn(actor, Hidden::Tanh, FIRST_OUTPUTS, random);
        let sizes = [&[inputs + actions], critic, &[1]].concat();
        let mut critic = || {
            let own = Layers::drawn(sizes.clone(), Hidden::Rectified, 1.0, random);
            Critic { target: own.clone(), steps: Adam::new(own.len()), own }
        };
        let critics = [critic(), critic()];
        let steps = [Adam::new(actor.len()), Adam::new(1)];
        Self { actor, actions, critics, log_temperature: 0.0, steps }
    }

    /// The weights of the network that answers with the middle of each action.
    #[must_use]
    pub fn policy(&self) -> Vec<f64> {
        // Those of the deviations are the last ones.
        self.actor.weights.iter().take(self.policy_length()).map(|weight| f64::from(*weight)).collect()
    }

    /// Begins with the weights of a policy.
    pub fn begin_with(&mut self, policy: &[f64]) {
        for (own, weight) in self.actor.weights.iter_mut().zip(policy) {
            *own = *weight as f32;
        }
    }

    fn policy_length(&self) -> usize {
        let last = self.actor.sizes().iter().rev().nth(1).copied().unwrap_or(0) + 1;
        self.actor.len() - self.actions * last
    }

    /// What the actor comes to for what is known.
    #[cfg(test)]
    pub(crate) fn actor_answer(&self, known: &[f32]) -> Vec<f32> {
        self.actor.answer(known)
    }

    /// Draws what is done: each action before `tanh`.
    #[must_use]
    pub fn explore(&self, known: &[f32], random: &mut Stream) -> Vec<f32> {
        let outputs = self.actor.answer(known);
        let (middles, deviations) = outputs.split_at(self.actions.min(outputs.len()));
        let draw = |(middle, log): (&f32, &f32)| {
            let deviation = libm::expf(log.clamp(LOG_DEVIATION.0, LOG_DEVIATION.1));
            middle + deviation * random.normal(0.0, 1.0) as f32
        };
        middles.iter().zip(deviations).map(draw).collect()
    }

    /// Draws for a batch, by what its actor came to.
    fn draw(&self, outputs: &[f32], samples: usize, random: &mut Stream) -> Drawn {
        let (middles, logs) = outputs.split_at(self.actions * samples);
        let noise: Vec<f32> = middles.iter().map(|_| random.normal(0.0, 1.0) as f32).collect();
        let held = logs.iter().map(|log| !(LOG_DEVIATION.0..=LOG_DEVIATION.1).contains(log)).collect();
        let logs: Vec<f32> = logs.iter().map(|log| log.clamp(LOG_DEVIATION.0, LOG_DEVIATION.1)).collect();
        let deviations: Vec<f32> = logs.iter().map(|log| libm::expf(*log)).collect();
        let mut actions: Vec<f32> =
            middles.iter().zip(&deviations).zip(&noise).map(|((m, d), e)| m + d * e).collect();
        tanh(&mut actions);
        let mut log_likelihoods = vec![0.0; samples];
        let rows = |values| <[f32]>::chunks_exact(values, samples);
        for ((actions, noise), logs) in rows(&actions).zip(rows(&noise)).zip(rows(&logs)) {
            for (((sum, a), e), log) in log_likelihoods.iter_mut().zip(actions).zip(noise).zip(logs) {
                *sum += -0.5 * e * e - log - HALF_LOG_TAU - libm::logf(1.0 - a * a + LEAST);
            }
        }
        Drawn { actions, noise, deviations, held, log_likelihoods }
    }

    /// Learns from decisions that are drawn from a replay.
    pub fn learn(
        &mut self,
        replay: &Replay,
        ends: &[usize],
        settings: ActorCriticSettings,
        random: &mut Stream,
    ) {
        let rates = settings.rates;
        let inputs = self.actor.inputs();
        let batch = replay.draw(ends, (inputs, self.actions), rates.batch, random);
        self.learn_worth(&batch, rates, random);
        self.learn_acting(&batch, settings, random);
    }

    /// Both critics learn what decisions are worth: what was gained, and what the next decision is worth by the lesser target.
    fn learn_worth(&mut self, batch: &Batch, rates: Rates, random: &mut Stream) {
        let samples = batch.samples;
        let next = self.actor.forward(batch.next.clone(), samples);
        let drawn = self.draw(next.outputs(), samples, random);
        let after = [batch.next.as_slice(), &drawn.actions].concat();
        let [first, second] = &mut self.critics;
        let target = |critic: &Critic| critic.target.outputs(after.clone(), samples);
        let (one, other) = together(|| target(first), || target(second));
        let temperature = libm::expf(self.log_temperature);
        let lesser = one.iter().zip(&other).zip(&drawn.log_likelihoods);
        let worth: Vec<f32> = batch
            .gained
            .iter()
            .zip(lesser)
            .map(|(gained, ((one, other), log))| {
                gained + rates.discount * (one.min(*other) - temperature * log)
            })
            .collect();
        let decided = [batch.known.as_slice(), &batch.done].concat();
        together(
            || first.learn(decided.clone(), &worth, rates),
            || second.learn(decided.clone(), &worth, rates),
        );
    }

    /// The actor learns to do what the lesser critic finds worth most, and to keep drawing; the temperature learns how much that counts.
    fn learn_acting(&mut self, batch: &Batch, settings: ActorCriticSettings, random: &mut Stream) {
        let (samples, inputs) = (batch.samples, self.actor.inputs());
        let values = self.actor.forward(batch.known.clone(), samples);
        let drawn = self.draw(values.outputs(), samples, random);
        let decided = [batch.known.as_slice(), &drawn.actions].concat();
        let [first, second] = &self.critics;
        let ((one, of_one), (other, of_other)) =
            together(|| first.judge(&decided, inputs, samples), || second.judge(&decided, inputs, samples));
        let temperature = libm::expf(self.log_temperature);
        let share = 1.0 / samples as f32;
        let length = drawn.actions.len();
        let mut worth = vec![0.0; 2 * length];
        for place in 0..length {
            let column = place % samples;
            let of_action = if one[column] <= other[column] { of_one[place] } else { of_other[place] };
            let action = drawn.actions[place];
            // Of -log(1 - a^2) and of -worth, by the action before `tanh`.
            let before = share * (temperature * 2.0 * action - of_action * (1.0 - action * action));
            worth[place] = before;
            if !drawn.held[place] {
                worth[length + place] =
                    before * drawn.deviations[place] * drawn.noise[place] - share * temperature;
            }
        }
        let gradients = self.actor.of_weights(&values, worth);
        let [actor, warmth] = &mut self.steps;
        actor.step(&mut self.actor.weights, &gradients, settings.rates.learning_rate);
        self.actor.hold();
        let entropy = settings.entropy * self.actions as f32;
        let mean = drawn.log_likelihoods.iter().sum::<f32>() * share;
        let mut log = [self.log_temperature];
        warmth.step(&mut log, &[-temperature * (mean + entropy)], settings.rates.learning_rate);
        self.log_temperature = log[0].clamp(LOG_TEMPERATURE.0, LOG_TEMPERATURE.1);
    }

    /// Whether it still consists of numbers.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let critics = self.critics.iter().all(|critic| critic.own.is_sound() && critic.target.is_sound());
        critics && self.actor.is_sound() && self.log_temperature.is_finite()
    }
}
