//! How large functions are when all functions in them are written out, and when that is too large.
//!
//! A call is replaced by the body of its function. Two calls in each of a row of functions double
//! with every one of them, so calls are counted, those of each function once.

use std::collections::{BTreeMap, BTreeSet};

use super::{DEEPEST, LARGEST};
use crate::diagnostics::{Code, Diagnostic};
use crate::names::Declaration;
use crate::source::Span;

/// How many calls may be written out within one.
const MOST_CALLS: usize = 10_000;
/// How many calls within calls may be written out in one check: some seconds.
const MOST_OF_ALL: usize = 1_000_000;

/// A function that is being written out.
struct Open {
    function: Declaration,
    /// How many calls there were when it began.
    before: usize,
}

/// What has been written out.
#[derive(Default)]
pub(super) struct WrittenOut {
    /// Calls within the outermost function, itself included where it was called.
    calls: usize,
    /// Calls within calls, of all functions.
    all: usize,
    /// Functions within each other, outermost first.
    open: Vec<Open>,
    /// How many calls each function was, itself included.
    sizes: BTreeMap<Declaration, usize>,
    /// Those that are too large, alone or through others. Each has an error, or what it calls has.
    too_large: BTreeSet<Declaration>,
    found: Vec<Diagnostic>,
}

impl WrittenOut {
    /// Begins anew: with the body of a function, or what calls one.
    pub(super) fn begin(&mut self, function: Option<Declaration>) {
        self.calls = 0;
        self.open = function.map(|function| Open { function, before: 0 }).into_iter().collect();
    }

    /// A call of a function, before its body is written out. False if it must not be; the first time, that is found.
    pub(super) fn call(&mut self, function: Declaration, name: &str, span: Span) -> bool {
        if self.too_large.contains(&function) || self.all >= MOST_OF_ALL {
            self.pass_on();
            return false;
        }
        if self.open.len() >= DEEPEST {
            let others = format!("its calls are nested more than {DEEPEST} deep");
            self.finds(name, span, &others);
            self.too_large.extend(self.open.first().map(|open| open.function));
            return false;
        }
        let after = self.calls + self.sizes.get(&function).map_or(1, |size| *size);
        if after > MOST_CALLS {
            self.finds(name, span, &format!("there are more than {MOST_CALLS} calls in it"));
            let large = self.open.iter().filter(|open| after - open.before > MOST_CALLS);
            self.too_large.extend(large.map(|open| open.function));
            self.too_large.extend(self.open.first().map(|open| open.function));
            return false;
        }
        self.open.push(Open { function, before: self.calls });
        self.calls += 1;
        if self.open.len() > 1 {
            self.all += 1;
        }
        if self.all == MOST_OF_ALL {
            self.finds(
                name,
                span,
                &format!("all functions together have more than {MOST_OF_ALL} nested calls"),
            );
        }
        true
    }

    /// The end of a call, whose function has so many operations. False if these are too many.
    pub(super) fn end(&mut self, name: &str, span: Span, operations: usize) -> bool {
        let Some(Open { function, before }) = self.open.pop() else { return true };
        if self.too_large.contains(&function) {
            self.pass_on();
            return false;
        }
        if operations > LARGEST {
            self.finds(name, span, &format!("there are more than {LARGEST} operations in it"));
            self.too_large.insert(function);
            self.pass_on();
            return false;
        }
        self.sizes.insert(function, self.calls - before);
        true
    }

    /// What was found since the last time.
    pub(super) fn found(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.found)
    }

    /// What calls something that is too large is too large itself.
    fn pass_on(&mut self) {
        self.too_large.extend(self.open.iter().map(|open| open.function));
    }

    fn finds(&mut self, name: &str, span: Span, reason: &str) {
        let message = format!("`{name}` is too large when all functions in it are expanded: {reason}");
        self.found.push(
            Diagnostic::new(Code::TOO_DEEP, span, message)
                .label("too many nested functions")
                .help("call a function once, and pass its result to the other functions as an argument"),
        );
    }
}
