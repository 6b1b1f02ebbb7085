//! Which values outside of actuations come from shared variables: these are known where an actuation is.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::{Declaration, Program};
use crate::syntax::ast::{Item, ItemKind};

/// The shared variables of a program, and the values and functions that read some, themselves or through others.
#[derive(Debug, Default)]
pub struct Sharing {
    /// By declaration: the shared variables, values and functions that it reads itself. Only of what reads a shared variable in
    /// the end.
    reads: BTreeMap<Declaration, BTreeSet<Declaration>>,
}

impl Sharing {
    /// Follows what the values of a program read.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let is_shared = |item: &Item| matches!(item.kind, ItemKind::Shared(_));
        let mut found = Self::default();
        let mut next: VecDeque<Declaration> = program
            .items()
            .filter(|(declaration, item)| is_shared(item) && !program.dropped.contains_key(declaration))
            .map(|(declaration, _)| declaration)
            .collect();
        // Most grammars have none.
        if next.is_empty() {
            return found;
        }
        let mut readers: BTreeMap<Declaration, Vec<Declaration>> = BTreeMap::new();
        for (reader, item) in program.items() {
            let ItemKind::Let(_, _, value) = &item.kind else { continue };
            value.each_name(&mut |name, span| {
                if let Some((read, Item { kind: ItemKind::Let(..) | ItemKind::Shared(_), .. })) =
                    program.lookup(span, name)
                {
                    readers.entry(read).or_default().push(reader);
                }
            });
        }
        while let Some(read) = next.pop_front() {
            for reader in readers.get(&read).into_iter().flatten() {
                if !found.reads.contains_key(reader) {
                    next.push_back(*reader);
                }
                found.reads.entry(*reader).or_default().insert(read);
            }
        }
        found
    }

    /// Whether a value or function outside of actuations reads a shared variable.
    #[must_use]
    pub fn reads(&self, declaration: Declaration) -> bool {
        self.reads.contains_key(&declaration)
    }

    /// Whether a declaration does not read itself in the end.
    #[must_use]
    pub fn is_known_in_the_end(&self, declaration: Declaration) -> bool {
        self.before([declaration]).contains(&declaration)
    }

    /// What must be known before a declaration is: the shared variables and values that it reads, itself or through functions and
    /// other values, such that each stands after what it reads. What reads itself in the end is left out.
    #[must_use]
    pub fn before(&self, wanted: impl IntoIterator<Item = Declaration>) -> Vec<Declaration> {
        let mut all: BTreeSet<Declaration> = BTreeSet::new();
        let mut next: Vec<Declaration> = wanted.into_iter().collect();
        while let Some(declaration) = next.pop() {
            if all.insert(declaration) {
                next.extend(self.reads.get(&declaration).into_iter().flatten());
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
