//! Networks of fully joined layers, for batches, with what each weight is worth.

use serde::{Deserialize, Serialize};

use super::products::{Matrix, Rows, product};
use super::tanh::tanh;
use super::{GREATEST, packed};
use crate::derive::random::Stream;

/// What a hidden node makes of its sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Hidden {
    Tanh,
    /// The sum, or zero if it is negative.
    Rectified,
}

/// A network on one flat list of weights: of each node a bias, and one for each input. Each but the bias counts divided by the root of
/// the number of inputs of its layer. Outputs are sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Layers {
    sizes: Vec<usize>,
    hidden: Hidden,
    #[serde(with = "packed")]
    pub(super) weights: Vec<f32>,
}

/// What the nodes of each layer come to for a batch, the inputs first: a row for each node, a column for each sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Values {
    layers: Vec<Matrix>,
}

impl Values {
    /// The outputs.
    pub(super) fn outputs(&self) -> &[f32] {
        self.layers.last().map_or(&[], |outputs| &outputs.of)
    }
}

/// The weights of a layer.
#[derive(Clone, Copy)]
struct Weights<'w> {
    /// Where they begin among all.
    begin: usize,
    of: &'w [f32],
    inputs: usize,
    /// What each but a bias is multiplied with.
    scale: f32,
}

impl<'w> Weights<'w> {
    /// A row for each node, without its bias.
    fn rows(self) -> Rows<'w> {
        Rows { of: self.of, stride: self.inputs + 1, skip: 1 }
    }
}

impl Layers {
    /// A network of these sizes, the inputs first, with weights that are drawn: of hidden nodes with a deviation of 1, of outputs with
    /// one of `last`. Biases are zero.
    pub(super) fn drawn(sizes: Vec<usize>, hidden: Hidden, last: f32, random: &mut Stream) -> Self {
        // Half of the sums of rectified nodes are zero: the others are larger (He and others 2015).
        let gain = if hidden == Hidden::Rectified { std::f64::consts::SQRT_2 } else { 1.0 };
        let outputs = sizes.len().saturating_sub(2);
        let mut weights = Vec::new();
        for (layer, two) in sizes.windows(2).enumerate() {
            let deviation = if layer == outputs { f64::from(last) } else { gain };
            for _ in 0..two[1] {
                weights.push(0.0);
                weights.extend((0..two[0]).map(|_| random.normal(0.0, deviation) as f32));
            }
        }
        Self { sizes, hidden, weights }
    }

    /// How many weights it has.
    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// The sizes of its layers, the inputs first.
    pub(super) fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// How many inputs it has.
    pub(super) fn inputs(&self) -> usize {
        self.sizes.first().copied().unwrap_or(0)
    }

    /// The weights of each layer.
    fn layers(&self) -> Vec<Weights<'_>> {
        let mut begin = 0;
        let one = |two: &[usize]| {
            let (inputs, length) = (two[0], (two[0] + 1) * two[1]);
            let of = &self.weights[begin..begin + length];
            let own = Weights { begin, of, inputs, scale: 1.0 / (inputs.max(1) as f32).sqrt() };
            begin += length;
            own
        };
        self.sizes.windows(2).map(one).collect()
    }

    /// What all nodes come to for a batch of inputs: a row for each input, a column for each sample.
    pub(super) fn forward(&self, inputs: Vec<f32>, samples: usize) -> Values {
        let mut layers = vec![Matrix { rows: self.inputs(), columns: samples, of: inputs }];
        let all = self.layers();
        for (number, weights) in all.iter().enumerate() {
            let mut out = product(weights.rows(), &layers[number]);
            for (row, own) in
                out.of.chunks_exact_mut(samples).zip(weights.of.chunks_exact(weights.inputs + 1))
            {
                let bias = own[0];
                row.iter_mut().for_each(|x| *x = bias + weights.scale * *x);
            }
            match self.hidden {
                _ if number + 1 == all.len() => {}
                Hidden::Tanh => tanh(&mut out.of),
                Hidden::Rectified => out.of.iter_mut().for_each(|x| *x = x.max(0.0)),
            }
            layers.push(out);
        }
        Values { layers }
    }

    /// The outputs for a batch.
    pub(super) fn outputs(&self, inputs: Vec<f32>, samples: usize) -> Vec<f32> {
        self.forward(inputs, samples).layers.pop().unwrap_or_default().of
    }

    /// The outputs for one sample.
    pub(super) fn answer(&self, inputs: &[f32]) -> Vec<f32> {
        self.outputs(inputs.to_vec(), 1)
    }

    /// What each weight is worth, where `worth` says that of the outputs.
    pub(super) fn of_weights(&self, values: &Values, worth: Vec<f32>) -> Vec<f32> {
        let mut gradients = vec![0.0; self.len()];
        self.behind(values, worth, false, |weights, inputs, worth| {
            let own = &mut gradients[weights.begin..weights.begin + weights.of.len()];
            let of_inputs = product(worth.all(), &inputs.all().transposed());
            let rows = own.chunks_exact_mut(weights.inputs + 1).zip(worth.of.chunks_exact(worth.columns));
            for (node, (own, worth)) in rows.enumerate() {
                own[0] = worth.iter().sum();
                let found = of_inputs.of.iter().skip(node * weights.inputs);
                own[1..].iter_mut().zip(found).for_each(|(own, found)| *own = weights.scale * found);
            }
        });
        gradients
    }

    /// What each input is worth.
    pub(super) fn of_inputs(&self, values: &Values, worth: Vec<f32>) -> Vec<f32> {
        self.behind(values, worth, true, |_, _, _| {})
    }

    /// Goes from the outputs to the inputs, and tells each layer what its sums are worth.
    fn behind(
        &self,
        values: &Values,
        worth: Vec<f32>,
        with_inputs: bool,
        mut tell: impl FnMut(Weights<'_>, &Matrix, &Matrix),
    ) -> Vec<f32> {
        let samples = values.layers.first().map_or(0, |inputs| inputs.columns);
        let outputs = self.sizes.last().copied().unwrap_or(0);
        let mut worth = Matrix { rows: outputs, columns: samples, of: worth };
        for (number, weights) in self.layers().into_iter().enumerate().rev() {
            let inputs = &values.layers[number];
            tell(weights, inputs, &worth);
            if number == 0 && !with_inputs {
                return Vec::new();
            }
            let mut before = product(weights.rows().transposed().all(), &worth);
            for (worth, y) in before.of.iter_mut().zip(&inputs.of) {
                *worth *= weights.scale
                    * match self.hidden {
                        _ if number == 0 => 1.0,
                        Hidden::Tanh => 1.0 - y * y,
                        Hidden::Rectified => f32::from(u8::from(*y > 0.0)),
                    };
            }
            worth = before;
        }
        worth.of
    }

    /// Moves the weights towards those of another network, by this share.
    pub(super) fn follow(&mut self, other: &Self, share: f32) {
        for (own, other) in self.weights.iter_mut().zip(&other.weights) {
            *own += share * (other - *own);
        }
    }

    /// Brings the weights of a policy back to where they may be.
    pub(super) fn hold(&mut self) {
        self.weights.iter_mut().for_each(|weight| *weight = weight.clamp(-GREATEST, GREATEST));
    }

    /// Whether all weights are finite.
    pub(super) fn is_sound(&self) -> bool {
        self.weights.iter().all(|weight| weight.is_finite())
    }
}
