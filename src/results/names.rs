//! What people call the parts of a design: one name each, the same in every place that speaks of it.
//!
//! A part that `begin` places has the name that it has there. The others are their kind and a number, `bender-3`, in the
//! order of their making; an image of a symmetry is its original's twin, `bender-3.twin`.

use std::collections::BTreeMap;
use thiserror::Error;

use grammar_lang::ir::RuleSet;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::derive::Derivation;
use crate::design::{Body, Design, Part, PartId, lattice};

/// Names of parts, each once. Cells have their places for names, and are not among them; of cells that are strained
/// as one, the first stands for the actuator that they are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Names(BTreeMap<PartId, String>);

impl Names {
    /// The names of all parts that a derivation makes, also of those that are gone in the end: they come last.
    #[must_use]
    pub fn through(rules: &RuleSet, derivation: &Derivation) -> Self {
        let mut parts = kept(&derivation.design);
        derivation.retrace(rules, |_, before, after| {
            for (id, part) in kept(before).into_iter().chain(kept(after)) {
                parts.entry(id).or_insert(part);
            }
        });
        Self::given(&derivation.design.placed, &parts)
    }

    /// The names of what a design has: its parts, or where it is of cells, its actuators.
    #[must_use]
    pub fn of(rules: &RuleSet, design: &Design) -> Self {
        if rules.lattice.is_none() {
            return Self::given(&design.placed, &kept(design));
        }
        let cells = Body::new(design, rules).actuators;
        let numbered = cells
            .iter()
            .enumerate()
            .filter_map(|(index, id)| Some((*id, format!("{}-{}", design.parts.get(id)?.kind, index + 1))));
        Self(numbered.collect())
    }

    fn given(placed: &BTreeMap<String, PartId>, parts: &IndexMap<PartId, Part>) -> Self {
        let mut names: BTreeMap<PartId, String> = placed.iter().map(|(n, id)| (*id, n.clone())).collect();
        let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
        for (id, part) in parts.iter().filter(|(_, part)| part.image_of.is_none()) {
            names.entry(*id).or_insert_with(|| {
                let number = numbers.entry(part.kind.as_str()).or_default();
                *number += 1;
                format!("{}-{number}", part.kind)
            });
        }
        for (id, part) in parts {
            let original = part.image_of.and_then(|original| names.get(&original)).cloned();
            if let Some(original) = original.filter(|_| !names.contains_key(id)) {
                let number = if part.image > 1 { part.image.to_string() } else { String::new() };
                names.insert(*id, format!("{original}.twin{number}"));
            }
        }
        Self(names)
    }

    /// The name of a part.
    #[must_use]
    pub fn get(&self, id: PartId) -> Option<&str> {
        self.0.get(&id).map(String::as_str)
    }

    /// The names of some parts; one that has none is called so.
    #[must_use]
    pub fn all(&self, ids: &[PartId]) -> Vec<String> {
        ids.iter().map(|id| self.get(*id).unwrap_or("a part without a name").to_owned()).collect()
    }

    /// The same names, but for parts that others name.
    #[must_use]
    pub fn but(mut self, others: &Self) -> Self {
        self.0.extend(others.0.iter().map(|(id, name)| (*id, name.clone())));
        self
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Checks that these can be the names of a design: that each of its parts has one, and no two the same.
    ///
    /// # Errors
    ///
    /// The first fault.
    pub fn check(&self, parts: &[PartId]) -> Result<(), BadNames> {
        if let Some(id) = parts.iter().find(|id| !self.0.contains_key(id)) {
            return Err(BadNames::Missing(*id));
        }
        let mut seen = BTreeMap::new();
        for (id, name) in &self.0 {
            // Tables name columns by them.
            let is_odd = |c: char| c.is_control() || c == ',' || c == '"';
            if name.trim().is_empty() || name.chars().any(is_odd) {
                return Err(BadNames::Odd { name: name.clone(), part: *id });
            }
            if seen.insert(name, id).is_some() {
                return Err(BadNames::Twice(name.clone()));
            }
        }
        Ok(())
    }
}

/// Why names cannot be those of a design's parts.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BadNames {
    /// A part has none.
    #[error("its part {0} has no name in it: the file was changed")]
    Missing(PartId),
    /// Tables and pages cannot show it.
    #[error(
        "`{}` cannot be the name of its part {part}: a name is text without commas, quotes and line breaks",
        name.escape_default()
    )]
    Odd {
        /// The name.
        name: String,
        /// Whose it should be.
        part: PartId,
    },
    /// Two parts have the same.
    #[error("two of its parts are called `{0}`: give each a name of its own")]
    Twice(String),
}

/// The parts of a design that have names of their own.
fn kept(design: &Design) -> IndexMap<PartId, Part> {
    let named = design.parts.iter().filter(|(id, _)| !lattice::is_cell(**id));
    named.map(|(id, part)| (*id, part.clone())).collect()
}
