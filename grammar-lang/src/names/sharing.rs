//! Which values outside of actuations come from what only an actuation knows: shared variables, sensors, and states of the robot.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::{Declaration, Program};
use crate::syntax::ast::{Expr, Field, Item, ItemKind};
use crate::syntax::declarations::BlockKind;

/// What only actuations know, and the values and functions that read some of it, themselves or through others.
#[derive(Debug, Default)]
pub struct Sharing {
    /// By value or function: the shared variables, sensors, states, values and functions that it reads itself. Only of what reads
    /// something that only actuations know in the end.
    reads: BTreeMap<Declaration, BTreeSet<Declaration>>,
    /// By state or policy: what it reads itself.
    fed_by: BTreeMap<Declaration, BTreeSet<Declaration>>,
    /// By state or policy: the shared variables that it comes from, through values, functions and other states. States may read
    /// each other, so this says nothing of an order.
    variables: BTreeMap<Declaration, BTreeSet<Declaration>>,
}

/// What is known where an actuation is, and nowhere else.
fn is_source(item: &Item) -> bool {
    matches!(item.kind, ItemKind::Shared(_) | ItemKind::Sense(_) | ItemKind::State(_))
}

/// The expressions of an item that may read such values.
fn expressions(item: &Item) -> Vec<&Expr> {
    match &item.kind {
        ItemKind::Let(_, _, value) => vec![value],
        ItemKind::State(of_body) => vec![&of_body.state.from, &of_body.state.next],
        ItemKind::Block(BlockKind::Policy, block) => {
            let values = block.fields.iter().filter_map(|field| match field {
                Field::Value(_, value) => Some(value),
                _ => None,
            });
            values.collect()
        }
        _ => Vec::new(),
    }
}

impl Sharing {
    /// Follows what the values of a program read.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let mut found = Self::default();
        let mut next: VecDeque<Declaration> = program
            .items()
            .filter(|(declaration, item)| is_source(item) && !program.dropped.contains_key(declaration))
            .map(|(declaration, _)| declaration)
            .collect();
        // Most grammars have none.
        if next.is_empty() {
            return found;
        }
        let mut readers: BTreeMap<Declaration, Vec<Declaration>> = BTreeMap::new();
        for (reader, item) in program.items() {
            for value in expressions(item) {
                value.each_name(&mut |name, span| {
                    let Some((read, of)) = program.lookup(span, name) else { return };
                    if !is_source(of) && !matches!(of.kind, ItemKind::Let(..)) {
                        return;
                    }
                    if matches!(item.kind, ItemKind::Let(..)) {
                        readers.entry(read).or_default().push(reader);
                    } else {
                        found.fed_by.entry(reader).or_default().insert(read);
                    }
                });
            }
        }
        while let Some(read) = next.pop_front() {
            for reader in readers.get(&read).into_iter().flatten() {
                if !found.reads.contains_key(reader) {
                    next.push_back(*reader);
                }
                found.reads.entry(*reader).or_default().insert(read);
            }
        }
        found.follow_states(program);
        found
    }

    /// Finds the shared variables that states and policies come from.
    fn follow_states(&mut self, program: &Program) {
        // Other values are known everywhere.
        for read in self.fed_by.values_mut() {
            read.retain(|d| self.reads.contains_key(d) || program.item(*d).is_some_and(is_source));
        }
        let mut readers: BTreeMap<Declaration, Vec<Declaration>> = BTreeMap::new();
        for (reader, read) in self.reads.iter().chain(&self.fed_by) {
            read.iter().for_each(|read| readers.entry(*read).or_default().push(*reader));
        }
        let is_variable = |item: &Item| matches!(item.kind, ItemKind::Shared(_));
        let variables = readers.keys().filter(|d| program.item(**d).is_some_and(is_variable));
        for variable in variables {
            let mut all: BTreeSet<Declaration> = BTreeSet::new();
            let mut next = vec![*variable];
            while let Some(read) = next.pop() {
                if all.insert(read) {
                    next.extend(readers.get(&read).into_iter().flatten());
                }
            }
            for fed in all.into_iter().filter(|reader| self.fed_by.contains_key(reader)) {
                self.variables.entry(fed).or_default().insert(*variable);
            }
        }
    }

    /// Whether a value or function outside of actuations reads what only actuations know, or a state or policy a shared variable.
    #[must_use]
    pub fn reads(&self, declaration: Declaration) -> bool {
        self.reads.contains_key(&declaration) || self.variables.contains_key(&declaration)
    }

    /// What a state reads itself of what only actuations know.
    #[must_use]
    pub fn read_by(&self, state: Declaration) -> BTreeSet<Declaration> {
        self.fed_by.get(&state).cloned().unwrap_or_default()
    }

    /// Whether a declaration does not read itself in the end.
    #[must_use]
    pub fn is_known_in_the_end(&self, declaration: Declaration) -> bool {
        self.before([declaration]).contains(&declaration)
    }

    /// What must be known before a declaration is: the shared variables and values that it reads, itself or through functions and
    /// other values, such that each stands after what it reads. What reads itself in the end is left out. Of a state that is read,
    /// the shared variables that it comes from are among them.
    #[must_use]
    pub fn before(&self, wanted: impl IntoIterator<Item = Declaration>) -> Vec<Declaration> {
        let mut all: BTreeSet<Declaration> = BTreeSet::new();
        let mut next: Vec<Declaration> = wanted.into_iter().collect();
        while let Some(declaration) = next.pop() {
            if all.insert(declaration) {
                next.extend(self.reads.get(&declaration).into_iter().flatten());
                next.extend(self.variables.get(&declaration).into_iter().flatten());
            }
        }
        let mut unknown: BTreeMap<Declaration, usize> = BTreeMap::new();
        let mut readers: BTreeMap<Declaration, Vec<Declaration>> = BTreeMap::new();
        let mut ready: BTreeSet<Declaration> = all.clone();
        for (reader, read) in all.iter().filter_map(|reader| Some((*reader, self.reads.get(reader)?))) {
            ready.remove(&reader);
            unknown.insert(reader, read.len());
            for declaration in read {
                readers.entry(*declaration).or_default().push(reader);
            }
        }
        let mut ordered = Vec::new();
        while let Some(declaration) = ready.pop_first() {
            ordered.push(declaration);
            for reader in readers.get(&declaration).into_iter().flatten() {
                let left = unknown.entry(*reader).or_default();
                *left = left.saturating_sub(1);
                if *left == 0 {
                    ready.insert(*reader);
                }
            }
        }
        ordered
    }
}
