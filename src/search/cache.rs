//! Values of evaluations that were made before, so that they need not be simulated again. They are
//! counted as if they had been: what is remembered changes nothing but speed.

use std::cell::RefCell;
use std::collections::BTreeMap;

use sha2::{Digest, Sha256};

use super::evaluator::Evaluated;
use super::tally::Missing;
use crate::derive::Derivation;
use crate::simulate::Invalid;

/// More than this are not remembered: some ten megabytes.
const MOST: usize = 40_000;

/// Stands for one body and one task.
pub(super) type Subject = [u8; 16];

/// Values by what was evaluated.
#[derive(Debug, Default)]
pub(super) struct Cache {
    values: RefCell<BTreeMap<Key, Evaluated>>,
}

/// What names an evaluation.
pub(super) type Key = [u8; 16];

/// The name of a body for a task, at a precision. Two derivations with the same steps make the same
/// body to the bit; whether two others do is not asked.
pub(super) fn subject(derivation: &Derivation, task: &str, is_fine: bool) -> Subject {
    let steps = serde_json::to_vec(&derivation.kept().steps).unwrap_or_default();
    let mut hasher = Sha256::new();
    hasher.update(&steps);
    hasher.update([0, u8::from(is_fine)]);
    hasher.update(task);
    short(hasher)
}

impl Cache {
    /// The name of an evaluation.
    pub(super) fn key(subject: &Subject, parameters: &[f64]) -> Key {
        let mut hasher = Sha256::new_with_prefix(subject);
        for value in parameters {
            hasher.update(value.to_bits().to_le_bytes());
        }
        short(hasher)
    }

    /// A value that is known.
    pub(super) fn get(&self, key: &Key) -> Option<Evaluated> {
        self.values.borrow().get(key).cloned()
    }

    /// Remembers a value.
    pub(super) fn keep(&self, key: Key, value: &Evaluated) {
        // What was given up for one chain may be of use to another.
        if matches!(value.value, Err(Missing::Motion(Invalid::GivenUp))) {
            return;
        }
        let mut values = self.values.borrow_mut();
        if values.len() >= MOST {
            values.clear();
        }
        values.insert(key, value.clone());
    }
}

fn short(hasher: Sha256) -> [u8; 16] {
    let mut key = [0; 16];
    key.copy_from_slice(&hasher.finalize()[..16]);
    key
}
