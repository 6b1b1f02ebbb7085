//! Double Q-learning with a deep network (van Hasselt, Guez and Silver 2016). Where several actions are decided at once, what they are
//! worth together is the mean of what each is worth (Tavakoli, Pardo and Kormushev 2018): the network has an output for each
//! value of each action.

use serde::{Deserialize, Serialize};

use super::adam::Adam;
use super::layers::{Hidden, Layers};
use super::{Rates, Replay};
use crate::derive::random::Stream;

/// The deviation of the first weights of outputs.
const FIRST_OUTPUTS: f32 = 0.1;
/// A worth that is wrong by more counts as if it were wrong by so much (Huber's loss).
const MOST_WRONG: f32 = 1.0;

/// A network that says what each value of each action is worth, and one that follows it slowly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QLearning {
    own: Layers,
    target: Layers,
    /// How many values each action has.
    values: Vec<usize>,
    steps: Adam,
}

impl QLearning {
    /// A network for so many inputs, and actions of so many values.
    #[must_use]
    pub fn new(inputs: usize, hidden: &[usize], values: Vec<usize>, random: &mut Stream) -> Self {
        let sizes = [&[inputs], hidden, &[values.iter().sum()]].concat();
        let own = Layers::drawn(sizes, Hidden::Tanh, FIRST_OUTPUTS, random);
        Self { target: own.clone(), steps: Adam::new(own.len()), own, values }
    }

    /// The weights of the network; the policy takes the value of each action that is worth most.
    #[must_use]
    pub fn policy(&self) -> Vec<f64> {
        self.own.weights.iter().map(|weight| f64::from(*weight)).collect()
    }

    /// Begins with the weights of a policy.
    pub fn begin_with(&mut self, policy: &[f64]) {
        for (own, weight) in self.own.weights.iter_mut().zip(policy) {
            *own = *weight as f32;
        }
        self.target = self.own.clone();
    }

    /// The place of the value of each action: of what is worth most or, by this chance, of any.
    #[must_use]
    pub fn explore(&self, known: &[f32], chance: f64, random: &mut Stream) -> Vec<usize> {
        let outputs = self.own.answer(known);
        let mut from = 0;
        let mut take = |count: &usize| {
            let own = outputs.get(from..from + count).unwrap_or_default();
            from += count;
            if random.unit() < chance { random.below(*count) } else { greatest(own.iter().copied()) }
        };
        self.values.iter().map(&mut take).collect()
    }

    /// Learns from decisions that are drawn from a replay.
    pub fn learn(&mut self, replay: &Replay, ends: &[usize], rates: Rates, random: &mut Stream) {
        let (samples, actions) = (rates.batch, self.values.len());
        let batch = replay.draw(ends, (self.own.inputs(), actions), samples, random);
        // The own network says what is done next, the other what that is worth.
        let next = self.own.forward(batch.next.clone(), samples);
        let judged = self.target.forward(batch.next, samples);
        let mut worth = vec![0.0; samples];
        for (column, worth) in worth.iter_mut().enumerate() {
            for (from, count) in self.groups() {
                let row = |place: usize| (from + place) * samples + column;
                let best = greatest((0..count).map(|place| next.outputs()[row(place)]));
                *worth += judged.outputs()[row(best)];
            }
            *worth = batch.gained[column] + rates.discount * *worth / actions.max(1) as f32;
        }
        let values = self.own.forward(batch.known, samples);
        let mut wrong = vec![0.0; values.outputs().len()];
        let share = 1.0 / (samples * actions.max(1)) as f32;
        for (action, (from, count)) in self.groups().enumerate() {
            for (column, worth) in worth.iter().enumerate() {
                let done = batch.done[action * samples + column] as usize;
                let place = (from + done.min(count - 1)) * samples + column;
                let error = values.outputs()[place] - worth;
                wrong[place] = share * error.clamp(-MOST_WRONG, MOST_WRONG);
            }
        }
        let gradients = self.own.of_weights(&values, wrong);
        self.steps.step(&mut self.own.weights, &gradients, rates.learning_rate);
        self.own.hold();
        self.target.follow(&self.own, rates.target_rate);
    }

    /// Of each action where its values begin among the outputs, and how many it has.
    fn groups(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let mut from = 0;
        let groups: Vec<(usize, usize)> = self
            .values
            .iter()
            .map(|count| {
                let group = (from, *count);
                from += count;
                group
            })
            .collect();
        groups.into_iter()
    }

    /// Whether it still consists of numbers.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.own.is_sound() && self.target.is_sound()
    }
}

/// The place of the greatest number, the first of equals.
fn greatest(values: impl Iterator<Item = f32>) -> usize {
    let mut best = (0, f32::NEG_INFINITY);
    for (place, value) in values.enumerate() {
        if value > best.1 {
            best = (place, value);
        }
    }
    best.0
}
