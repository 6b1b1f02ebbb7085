//! Which values outside of actuations come from shared variables: these are known where an actuation is.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::{Declaration, Program};
use crate::source::Span;
use crate::syntax::ast::{Expr, ExprKind, Item, ItemKind};

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
            each_name(value, &mut |name, span| {
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

/// Calls `told` with each name of an expression and its place.
fn each_name(expr: &Expr, told: &mut impl FnMut(&str, Span)) {
    let mut next = vec![expr];
    while let Some(expr) = next.pop() {
        match &expr.kind {
            ExprKind::Quantity(..) | ExprKind::Text(_) | ExprKind::Bool(_) => {}
            ExprKind::Name(name) => told(name, expr.span),
            ExprKind::Member(of, _) | ExprKind::Convert(of, _) | ExprKind::Negate(of) | ExprKind::Not(of) => {
                next.push(of);
            }
            ExprKind::Call(callee, arguments) => {
                next.push(callee);
                next.extend(arguments.iter().map(|argument| &argument.value));
            }
            ExprKind::Index(a, b)
            | ExprKind::At(a, b)
            | ExprKind::Binary(a, _, b)
            | ExprKind::Narrowed(a, b)
            | ExprKind::Exchanged(a, b)
            | ExprKind::Range(a, b) => next.extend([&**a, &**b]),
            ExprKind::If(a, b, c) => next.extend([&**a, &**b, &**c]),
            ExprKind::Cases(of, cases, otherwise) => {
                next.push(of);
                next.extend(cases.iter().flat_map(|(case, value)| [case, value]));
                next.extend(otherwise.as_deref());
            }
            ExprKind::Aggregate { share, binders, condition, body, otherwise, .. } => {
                next.extend(binders.iter().map(|binder| &binder.over));
                next.extend(
                    [share, condition, body, otherwise].into_iter().filter_map(|part| part.as_deref()),
                );
            }
            ExprKind::Set(items) | ExprKind::List(items) => next.extend(items),
        }
    }
}
