//! Values of evaluations that were made before, on whatever thread, so that they need not be simulated again. They are
//! counted as if they had been: what is remembered changes nothing but speed.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use sha2::{Digest, Sha256};

use super::evaluated::Evaluated;
use super::fidelity::Fidelity;
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
    values: Mutex<BTreeMap<Key, Evaluated>>,
}

/// What names an evaluation.
pub(super) type Key = [u8; 16];

/// The name of a body for a task, at a precision. Two derivations with the same steps make the same
/// body to the bit; whether two others do is not asked.
pub(super) fn subject(derivation: &Derivation, task: &str, fidelity: Fidelity) -> Subject {
    let steps = serde_json::to_vec(&derivation.kept().steps).unwrap_or_default();
    let mut hasher = Sha256::new();
    hasher.update(&steps);
    let fidelity = match fidelity {
        Fidelity::Model => 0,
        Fidelity::HalfStep => 1,
        Fidelity::Rods => 2,
    };
    hasher.update([0, fidelity]);
    hasher.update(task);
    short(hasher)
}

/// The name of something of a subject.
pub(super) fn named(subject: &Subject, of: &[u8]) -> Subject {
    short(Sha256::new_with_prefix(subject).chain_update(of))
}

impl Cache {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Key, Evaluated>> {
        // What is kept is kept whole.
        self.values.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The name of an evaluation.
    pub(super) fn key(subject: &Subject, parameters: &[f64]) -> Key {
        let mut hasher = Sha256::new_with_prefix(subject);
        for value in parameters {
            hasher.update(value.to_bits().to_le_bytes());
        }
        short(hasher)
    }

    /// A value that is known; of one that was given up it is enough that it stays below what is needed.
    pub(super) fn get(&self, key: &Key, needed: f64) -> Option<Evaluated> {
        let is_enough = |known: &&Evaluated| !is_given_up(known) || known.ceiling < needed;
        self.lock().get(key).filter(is_enough).cloned()
    }

    /// Remembers a value.
    pub(super) fn keep(&self, key: Key, value: &Evaluated) {
        let mut values = self.lock();
        // What was given up for one chain may have been of use to another.
        if is_given_up(value) && values.contains_key(&key) {
            return;
        }
        if values.len() >= MOST {
            values.clear();
        }
        values.insert(key, value.clone());
    }
}

fn is_given_up(value: &Evaluated) -> bool {
    matches!(value.value, Err(Missing::Motion(Invalid::GivenUp)))
}

fn short(hasher: Sha256) -> [u8; 16] {
    let mut key = [0; 16];
    key.copy_from_slice(&hasher.finalize()[..16]);
    key
}
