//! Checks what a rule does, in which order: `then` stands between what it does first and what it does next, and a rule that takes a
//! step back does nothing else. A rule that is carried out always only sets what follows from the design.

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Painting;
use crate::source::Span;
use crate::syntax::ast::{ItemKind, Name, RuleClause, RuleClauseKind};

impl Declarations<'_> {
    /// Reports what a rule does beside taking a step back: the steps of a design would not lead to it.
    pub(super) fn check_reversion(&mut self, clauses: &[RuleClause]) {
        let is_reversion = |clause: &&RuleClause| matches!(clause.kind, RuleClauseKind::Revert(_));
        let Some(revert) = clauses.iter().find(is_reversion) else { return };
        let other = clauses.iter().find(|other| !is_reversion(other) && does_something(&other.kind));
        if let Some(other) = other {
            self.report(
                Diagnostic::new(
                    Code::BAD_VALUE,
                    other.span,
                    "a rule that reverts a step cannot do anything else",
                )
                .label(
                    "this would not belong to a step, so it would be lost when the design is derived again",
                )
                .also(revert.span, "the step is reverted here")
                .help("write two rules: one that reverts, and one for the rest"),
            );
        }
    }

    /// Reports what a rule that is carried out always cannot do: it is not drawn, and changes what parts are like, but not which there are.
    pub(super) fn check_always(&mut self, clauses: &[RuleClause]) {
        let mut all = clauses.iter().filter(|clause| matches!(clause.kind, RuleClauseKind::Always));
        let Some(always) = all.next() else { return };
        for again in all {
            self.report(
                Diagnostic::new(Code::DUPLICATE, again.span, "a rule can have only one `always`")
                    .label("another one")
                    .also(always.span, "the first one")
                    .help("keep one of them"),
            );
        }
        self.check_only_sets(clauses, always.span);
    }

    /// Reports a rule that is carried out always where one is named that is drawn, or is a step; whether it is one.
    pub(super) fn tell_of_always(&mut self, name: &Name, declared: &ItemKind) -> bool {
        let ItemKind::Rule(_, clauses) = declared else { return false };
        let Some(always) = clauses.iter().find(|c| matches!(c.kind, RuleClauseKind::Always)) else {
            return false;
        };
        let message =
            format!("`{}` cannot be a step: a rule with `always` is carried out after every step", name.text);
        self.report(
            Diagnostic::new(Code::BAD_VALUE, name.span, message)
                .label("not a rule that is drawn")
                .also(always.span, "it says `always`")
                .help("take this out, or name another rule"),
        );
        true
    }

    /// Reports a rule that is declared, but of which the grammar knows nothing: it stands beside a variant.
    pub(super) fn tell_of_unused_rule(&mut self, name: &Name) -> bool {
        let program = self.environment.program;
        let declared = program.lookup(name.span, &name.text);
        let Some((_, item)) = declared
            .filter(|(place, item)| matches!(item.kind, ItemKind::Rule(..)) && !program.takes_part(*place))
        else {
            return false;
        };
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_NAME,
                name.span,
                format!("this grammar has no rule `{}`", name.text),
            )
            .label("not part of the variant")
            .also(item.span, "declared here, outside the braces of the variant")
            .help(format!("write it inside the braces: `add rule {} {{ ... }}`", name.text)),
        );
        true
    }

    fn check_only_sets(&mut self, clauses: &[RuleClause], always: Span) {
        for clause in clauses {
            let (word, help) = match &clause.kind {
                RuleClauseKind::Match { .. } | RuleClauseKind::MatchNothing => ("match", OVER_ALL),
                RuleClauseKind::Choose(..) => ("choose", NOT_DRAWN),
                RuleClauseKind::Weight(_) => ("weight", NOT_DRAWN),
                RuleClauseKind::Attach { .. } => ("attach", ONLY_SETS),
                RuleClauseKind::Remove(_) => ("remove", ONLY_SETS),
                RuleClauseKind::Replace { .. } => ("replace", ONLY_SETS),
                RuleClauseKind::Revert(_) => ("revert", ONLY_SETS),
                RuleClauseKind::Cells { how: Painting::Fill, .. } => ("fill", ONLY_SETS),
                RuleClauseKind::Cells { how: Painting::Clear, .. } => ("clear", ONLY_SETS),
                RuleClauseKind::Repeat { clauses, .. } => {
                    self.check_only_sets(clauses, always);
                    continue;
                }
                _ => continue,
            };
            let message = format!("a rule with `always` cannot contain `{word}`");
            self.report(
                Diagnostic::new(Code::BAD_VALUE, clause.span, message)
                    .label("it is carried out after every step")
                    .also(always, "the rule says `always` here")
                    .help(help),
            );
        }
    }

    /// Reports a `then` with nothing above or below it, and clauses below it that are about the whole rule.
    pub(super) fn check_phases(&mut self, clauses: &[RuleClause], damaged: bool) {
        let is_then = |clause: &&RuleClause| matches!(clause.kind, RuleClauseKind::Then);
        let Some(first) = clauses.iter().position(|clause| is_then(&clause)) else { return };
        for (place, then) in clauses.iter().enumerate().filter(|(_, clause)| is_then(clause)) {
            let acts = |clause: &RuleClause| does_something(&clause.kind);
            // What cannot stand below it is told as that.
            let is_misplaced = |clause: &RuleClause| is_of_the_whole_rule(&clause.kind);
            let (above, below) = (clauses.get(..place), clauses.get(place + 1..));
            let is_before = |clause: &&RuleClause| !is_then(clause);
            let acts_above = above.is_some_and(|above| above.iter().rev().take_while(is_before).any(acts));
            let acts_below = below.is_some_and(|below| {
                below.iter().take_while(is_before).any(|clause| acts(clause) || is_misplaced(clause))
            });
            let (side, help) = match (acts_above, acts_below) {
                (true, true) => continue,
                // Where nothing is done between two, the first one says so.
                (false, _) if place > first => continue,
                (false, _) => ("above", "take it out: what a rule does first reads the design as it is"),
                (true, false) => {
                    ("below", "write an effect below it: `attach`, `set`, `remove` or `replace`")
                }
            };
            // What could not be read may have done something.
            if !damaged {
                let message = format!("there is no effect {side} this `then`");
                self.report(
                    Diagnostic::new(Code::NO_EFFECT, then.span, message)
                        .label(format!("nothing {side} it"))
                        .help(help),
                );
            }
        }
        for clause in clauses.iter().skip(first) {
            let (word, help) = match &clause.kind {
                RuleClauseKind::Match { .. } | RuleClauseKind::MatchNothing => ("match", KNOWN_BEFORE),
                RuleClauseKind::Choose(..) => ("choose", KNOWN_BEFORE),
                RuleClauseKind::Guard(true, _) => ("when", IN_A_BLOCK),
                RuleClauseKind::Guard(false, _) => ("unless", IN_A_BLOCK),
                _ => continue,
            };
            self.report(
                Diagnostic::new(Code::BAD_VALUE, clause.span, format!("`{word}` cannot be below `then`"))
                    .label("it is about the whole rule")
                    .also(clauses.get(first).map_or(clause.span, |then| then.span), "this `then` is above it")
                    .help(help),
            );
        }
    }
}

const OVER_ALL: &str = "name all parts that it applies to: `set s.load = 2 N for s in strut`";
const NOT_DRAWN: &str = "take it out, or take `always` out: such a rule is never drawn";
const ONLY_SETS: &str = "write a separate rule for it: a rule with `always` can only set parameters";
const KNOWN_BEFORE: &str =
    "move it above `then`: what a rule matches and chooses is known before it does anything";
const IN_A_BLOCK: &str =
    "move it above `then`, or put what depends on it into a block: `if CONDITION { ... }`";

/// Whether a clause is about the whole rule, and is worked out before the rule does anything.
fn is_of_the_whole_rule(clause: &RuleClauseKind) -> bool {
    matches!(
        clause,
        RuleClauseKind::Match { .. }
            | RuleClauseKind::MatchNothing
            | RuleClauseKind::Choose(..)
            | RuleClauseKind::Guard(..)
    )
}

/// Whether a clause changes the design.
fn does_something(clause: &RuleClauseKind) -> bool {
    !is_of_the_whole_rule(clause)
        && !matches!(
            clause,
            RuleClauseKind::Let(..)
                | RuleClauseKind::Weight(_)
                | RuleClauseKind::Then
                | RuleClauseKind::Always
        )
}
