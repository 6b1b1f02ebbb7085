//! How long a rule may be, and how deep its blocks.

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;
use crate::syntax::ast::{RuleClause, RuleClauseKind};

/// Clauses of a rule, at most, with those of its blocks.
const MOST_CLAUSES: usize = 1000;
/// Blocks that are repeated within each other, at most.
const DEEPEST: usize = 8;

/// Where the clause stands that is one more than so many.
fn clause_at(clauses: &[RuleClause], left: &mut usize) -> Option<Span> {
    clauses.iter().find_map(|clause| {
        if *left == 0 {
            return Some(clause.span);
        }
        *left -= 1;
        match &clause.kind {
            RuleClauseKind::Repeat { clauses, .. } => clause_at(clauses, left),
            _ => None,
        }
    })
}

/// Where a block stands that lies within more others than so many.
fn deeper_than(clauses: &[RuleClause], most: usize) -> Option<Span> {
    clauses.iter().find_map(|clause| match &clause.kind {
        RuleClauseKind::Repeat { .. } if most == 0 => Some(clause.span),
        RuleClauseKind::Repeat { clauses, .. } => deeper_than(clauses, most - 1),
        _ => None,
    })
}

impl Declarations<'_> {
    /// Whether a rule has more clauses than anybody reads, or more blocks within each other; that is told.
    pub(super) fn is_too_long(&mut self, clauses: &[RuleClause]) -> bool {
        let told = if let Some(place) = clause_at(clauses, &mut { MOST_CLAUSES }) {
            Some((
                place,
                format!("a rule has at most {MOST_CLAUSES} clauses"),
                "one too many",
                "repeat what is alike with `for i in 0 .. 9 { ... }`, or write several rules",
            ))
        } else {
            deeper_than(clauses, DEEPEST).map(|place| {
                let message = format!("at most {DEEPEST} blocks may be repeated within each other");
                (
                    place,
                    message,
                    "one too many",
                    "repeat over more things at once: `for i in 0 .. 9` in place of two blocks of three",
                )
            })
        };
        let Some((place, message, label, help)) = told else { return false };
        self.report(Diagnostic::new(Code::OUT_OF_DOMAIN, place, message).label(label).help(help));
        true
    }
}
