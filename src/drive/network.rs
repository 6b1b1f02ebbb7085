//! The networks of policies: layers of nodes on one flat list of weights.

/// A network of fully joined layers. Hidden nodes are `tanh` of their sums; outputs are sums.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Network {
    /// The sizes of its layers, the inputs first and the outputs last.
    sizes: Vec<usize>,
}

impl Network {
    pub(super) fn new(inputs: usize, hidden: &[usize], outputs: usize) -> Self {
        Self { sizes: [&[inputs], hidden, &[outputs]].concat() }
    }

    /// How many inputs it has.
    pub(super) fn inputs(&self) -> usize {
        self.sizes.first().copied().unwrap_or(0)
    }

    /// How many weights it has: of each node a bias and one weight for each input of its layer.
    pub(super) fn weights(&self) -> usize {
        self.sizes.windows(2).map(|layer| (layer[0] + 1) * layer[1]).sum()
    }

    /// The outputs. Weights are those of the first node of the first layer, its bias first, then of the next node, and so on. Each but the bias
    /// counts divided by the root of the number of inputs of its layer, so that weights of about one suit layers of any size.
    pub(super) fn answer(&self, weights: &[f64], inputs: &[f64]) -> Vec<f64> {
        let mut values = inputs.to_vec();
        let mut weights = weights.iter().copied();
        let layers = self.sizes.len() - 1;
        for (number, layer) in self.sizes.windows(2).enumerate() {
            let scale = 1.0 / libm::sqrt(layer[0].max(1) as f64);
            let is_last = number + 1 == layers;
            let node = |_| {
                let bias = weights.next().unwrap_or(0.0);
                // In a fixed order, so that the bits are.
                let mut sum = 0.0;
                for value in &values {
                    sum += weights.next().unwrap_or(0.0) * value;
                }
                let sum = bias + sum * scale;
                if is_last { sum } else { libm::tanh(sum) }
            };
            values = (0..layer[1]).map(node).collect();
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::random::Stream;
    use crate::learn::{ActorCritic, QLearning};

    #[test]
    fn a_small_network_answers_what_is_worked_out_by_hand() {
        let network = Network::new(2, &[2], 1);
        assert_eq!((network.inputs(), network.weights()), (2, 9));
        let weights = [0.1, 1.0, -2.0, -0.3, 0.5, 0.0, 0.2, 3.0, -1.0];
        let (x, y) = (0.4, -0.7);
        let root = libm::sqrt(2.0);
        let first = libm::tanh(0.1 + (x - 2.0 * y) / root);
        let second = libm::tanh(-0.3 + 0.5 * x / root);
        let by_hand = 0.2 + (3.0 * first - second) / root;
        let [answer] = network.answer(&weights, &[x, y])[..] else { panic!("one output") };
        assert!((answer - by_hand).abs() < 1e-14);
        // Without hidden layers it is linear.
        let linear = Network::new(2, &[], 1);
        let [answer] = linear.answer(&[1.0, 2.0, 3.0], &[x, y])[..] else { panic!("one output") };
        assert!((answer - (1.0 + (2.0 * x + 3.0 * y) / root)).abs() < 1e-14);
    }

    /// What learners learn in `f32`, a policy answers: both have their weights in one order.
    #[test]
    fn learned_weights_are_those_of_the_network() {
        let mut random = Stream::named(11, "weights");
        let known = [0.3, -0.8, 1.2];
        let own: Vec<f32> = known.iter().map(|x| *x as f32).collect();
        let mut actor = ActorCritic::new(3, &[5, 4], 2, &[6], &mut random);
        let network = Network::new(3, &[5, 4], 2);
        let weights: Vec<f64> = (0..network.weights()).map(|_| random.normal(0.0, 1.0)).collect();
        assert_eq!(actor.policy().len(), weights.len());
        actor.begin_with(&weights);
        let learned = actor.actor_answer(&own);
        for (answer, learned) in network.answer(&weights, &known).iter().zip(&learned) {
            assert!((answer - f64::from(*learned)).abs() < 1e-5, "{answer} {learned}");
        }
        let mut values = QLearning::new(3, &[5, 4], vec![3, 2], &mut random);
        let network = Network::new(3, &[5, 4], 5);
        for _ in 0..20 {
            let weights: Vec<f64> = (0..network.weights()).map(|_| random.normal(0.0, 1.0)).collect();
            values.begin_with(&weights);
            let answer = network.answer(&weights, &known);
            let greatest = |of: &[f64]| (0..of.len()).max_by(|a, b| of[*a].total_cmp(&of[*b])).unwrap();
            let best = [greatest(&answer[..3]), greatest(&answer[3..])];
            assert_eq!(values.explore(&own, 0.0, &mut random), best);
        }
    }

    #[test]
    fn a_network_without_inputs_answers_its_biases() {
        assert_eq!(Network::new(0, &[], 2).answer(&[0.5, -0.5], &[]), [0.5, -0.5]);
    }
}
