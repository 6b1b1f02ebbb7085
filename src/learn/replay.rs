//! What was known, done and gained: episodes, of which the last are kept.

use std::collections::VecDeque;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::packed;
use crate::derive::random::Stream;

/// One motion as a learner sees it: `n` decisions, and what was known at each and after the last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// What was known, moment by moment: (`n` + 1) times the inputs.
    #[serde(with = "packed")]
    pub known: Vec<f32>,
    /// What was done at each decision: `n` times the actions.
    #[serde(with = "packed")]
    pub done: Vec<f32>,
    /// What was gained until the next decision: `n` rewards.
    #[serde(with = "packed")]
    pub gained: Vec<f32>,
}

/// The last episodes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Replay {
    episodes: VecDeque<Arc<Episode>>,
}

/// Decisions of a batch: a row for each feature, a column for each decision.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    pub(super) known: Vec<f32>,
    pub(super) done: Vec<f32>,
    pub(super) gained: Vec<f32>,
    /// What was known at the decision after.
    pub(super) next: Vec<f32>,
    pub(super) samples: usize,
}

impl Replay {
    /// How many decisions there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.episodes.iter().map(|episode| episode.gained.len()).sum()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds an episode, and forgets the oldest ones as long as more decisions are left than `most`.
    pub fn add(&mut self, episode: Episode, most: usize) {
        if episode.gained.is_empty() {
            return;
        }
        self.episodes.push_back(Arc::new(episode));
        let mut length = self.len();
        while length > most && self.episodes.len() > 1 {
            length -= self.episodes.pop_front().map_or(0, |oldest| oldest.gained.len());
        }
    }

    /// Where each episode ends among all decisions.
    #[must_use]
    pub fn ends(&self) -> Vec<usize> {
        let add = |end: &mut usize, episode: &Arc<Episode>| {
            *end += episode.gained.len();
            Some(*end)
        };
        self.episodes.iter().scan(0, add).collect()
    }

    /// Draws decisions, each as likely as any other.
    pub(super) fn draw(
        &self,
        ends: &[usize],
        (inputs, actions): (usize, usize),
        samples: usize,
        random: &mut Stream,
    ) -> Batch {
        let all = ends.last().copied().unwrap_or(0);
        let mut batch = Batch {
            known: vec![0.0; inputs * samples],
            done: vec![0.0; actions * samples],
            gained: vec![0.0; samples],
            next: vec![0.0; inputs * samples],
            samples,
        };
        for column in 0..samples {
            let place = random.below(all);
            let number = ends.partition_point(|end| *end <= place);
            let Some(episode) = self.episodes.get(number) else { continue };
            let at = place - number.checked_sub(1).and_then(|before| ends.get(before)).copied().unwrap_or(0);
            let put = |to: &mut [f32], from: &[f32], place: usize, width: usize| {
                for (row, value) in from.iter().skip(place * width).take(width).enumerate() {
                    to[row * samples + column] = *value;
                }
            };
            put(&mut batch.known, &episode.known, at, inputs);
            put(&mut batch.next, &episode.known, at + 1, inputs);
            put(&mut batch.done, &episode.done, at, actions);
            batch.gained[column] = episode.gained.get(at).copied().unwrap_or(0.0);
        }
        batch
    }
}
