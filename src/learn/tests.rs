//! Gradients against differences, and that both learners find what is worth most where that is known.

use super::layers::{Hidden, Layers};
use super::*;
use crate::derive::random::Stream;

/// A batch of numbers: a row for each input.
fn batch(inputs: usize, samples: usize, random: &mut Stream) -> Vec<f32> {
    (0..inputs * samples).map(|_| random.normal(0.0, 1.0) as f32).collect()
}

#[test]
fn gradients_are_what_differences_are() {
    // Numbers of samples and nodes that leave blocks half full.
    for (hidden, samples) in [(Hidden::Tanh, 1), (Hidden::Rectified, 11), (Hidden::Tanh, 19)] {
        let mut random = Stream::named(3, "gradients");
        let mut network = Layers::drawn(vec![5, 7, 6, 3], hidden, 1.0, &mut random);
        for weight in &mut network.weights {
            *weight += 0.1 * random.normal(0.0, 1.0) as f32;
        }
        let inputs = batch(5, samples, &mut random);
        let worth = batch(3, samples, &mut random);
        let sum = |network: &Layers, inputs: &[f32]| -> f64 {
            let values = network.forward(inputs.to_vec(), samples);
            values.outputs().iter().zip(&worth).map(|(y, w)| f64::from(*y) * f64::from(*w)).sum()
        };
        let values = network.forward(inputs.clone(), samples);
        let gradients = network.of_weights(&values, worth.clone());
        let of_inputs = network.of_inputs(&values, worth.clone());
        // Where a rectified node bends within the step, there is no one slope.
        let is_slope = |at: &dyn Fn(f32) -> f64, found: f32| {
            let step = 1e-3_f32;
            let slope = |from: f32, to: f32| (at(to) - at(from)) / f64::from(to - from);
            let (before, after) = (slope(-step, 0.0), slope(0.0, step));
            let close = |a: f64, b: f64| (a - b).abs() < 0.02 * (1.0 + b.abs());
            !close(before, after) || close(f64::from(found), 0.5 * (before + after))
        };
        for (place, gradient) in gradients.iter().enumerate() {
            let at = |step: f32| {
                let mut other = network.clone();
                other.weights[place] += step;
                sum(&other, &inputs)
            };
            assert!(is_slope(&at, *gradient), "weight {place} of {hidden:?}");
        }
        for place in 0..inputs.len() {
            let at = |step: f32| {
                let mut other = inputs.clone();
                other[place] += step;
                sum(&network, &other)
            };
            assert!(is_slope(&at, of_inputs[place]), "input {place} of {hidden:?}");
        }
    }
}

#[test]
fn a_batch_answers_as_each_sample_does() {
    let mut random = Stream::named(5, "batch");
    let network = Layers::drawn(vec![4, 9, 2], Hidden::Tanh, 1.0, &mut random);
    let samples = 13;
    let inputs = batch(4, samples, &mut random);
    let all = network.forward(inputs.clone(), samples);
    for column in 0..samples {
        let own: Vec<f32> = inputs.chunks(samples).map(|row| row[column]).collect();
        let together: Vec<f32> = all.outputs().chunks(samples).map(|row| row[column]).collect();
        assert_eq!(network.answer(&own), together);
    }
}

const RATES: Rates = Rates { learning_rate: 0.01, discount: 0.8, batch: 64, target_rate: 0.02 };

/// A place on a line that moves as it is told. It gains what it is near the middle of: a learner that looks ahead goes there.
fn episode(mut act: impl FnMut(f32) -> (f32, f32), start: f32) -> Episode {
    let mut at = start;
    let mut episode = Episode { known: vec![at], ..Episode::default() };
    for _ in 0..20 {
        let (done, way) = act(at);
        at = (at + 0.3 * way).clamp(-2.0, 2.0);
        episode.known.push(at);
        episode.done.push(done);
        episode.gained.push(1.0 - (at - 0.5).abs());
    }
    episode
}

fn mean_gain(act: impl Fn(f32) -> f32) -> f32 {
    let starts = [-1.8_f32, -0.7, 0.2, 1.1, 1.9];
    let gains = starts.map(|start| {
        let own = episode(|at| (0.0, act(at)), start);
        own.gained.iter().rev().take(10).sum::<f32>() / 10.0
    });
    gains.iter().sum::<f32>() / 5.0
}

#[test]
fn an_actor_goes_where_it_gains_most_and_both_times_the_same() {
    let learned = || {
        let mut random = Stream::named(7, "actor");
        let mut agent = ActorCritic::new(1, &[16], 1, &[32, 32], &mut random);
        let mut replay = Replay::default();
        let settings = ActorCriticSettings { rates: RATES, entropy: -1.0 };
        for _ in 0..60 {
            let start = (4.0 * random.unit() - 2.0) as f32;
            let mut own = random.clone();
            let one = episode(
                |at| {
                    let done = libm::tanhf(agent.explore(&[at], &mut own)[0]);
                    (done, done)
                },
                start,
            );
            random = own;
            replay.add(one, 800);
            let ends = replay.ends();
            for _ in 0..20 {
                agent.learn(&replay, &ends, settings, &mut random);
            }
        }
        assert!(agent.is_sound() && replay.len() <= 800);
        agent
    };
    let agent = learned();
    assert_eq!(agent, learned());
    let act = |at: f32| libm::tanhf(agent.actor_answer(&[at])[0]);
    let gain = mean_gain(act);
    assert!(gain > 0.9, "{gain}");
    // A checkpoint holds it to the bit.
    let text = serde_json::to_string(&agent).unwrap();
    assert_eq!(serde_json::from_str::<ActorCritic>(&text).unwrap(), agent);
}

#[test]
fn a_q_network_goes_where_it_gains_most() {
    let mut random = Stream::named(9, "values");
    let mut agent = QLearning::new(1, &[18, 9], vec![3], &mut random);
    let mut replay = Replay::default();
    for number in 0..120 {
        let start = (4.0 * random.unit() - 2.0) as f32;
        let mut own = random.clone();
        let chance = 0.9_f64 - 0.01 * f64::from(number);
        let one = episode(
            |at| {
                let place = agent.explore(&[at], chance.max(0.05), &mut own)[0];
                (place as f32, place as f32 - 1.0)
            },
            start,
        );
        random = own;
        replay.add(one, 2000);
        let ends = replay.ends();
        for _ in 0..20 {
            agent.learn(&replay, &ends, RATES, &mut random);
        }
    }
    let act = |at: f32| agent.explore(&[at], 0.0, &mut Stream::named(0, ""))[0] as f32 - 1.0;
    let gain = mean_gain(act);
    assert!(gain > 0.8, "{gain}");
}
