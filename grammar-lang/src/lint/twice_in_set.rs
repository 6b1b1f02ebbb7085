//! A value that stands twice in a set.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::evaluate;
use crate::ir::{Expr, ExprKind, RuleSet};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    for choice in ruleset.rules.iter().flat_map(|rule| &rule.choices) {
        let ExprKind::Set(items) = &choice.domain.kind else { continue };
        for (i, item) in items.iter().enumerate() {
            let first = items.iter().take(i).find(|other| same(ruleset, item, other));
            if let Some(first) = first {
                findings.push(
                    Diagnostic::new(
                        Code::TWICE_IN_SET,
                        item.span,
                        format!("`{}` has the same value twice", choice.name),
                    )
                    .label("again")
                    .also(first.span, "first here")
                    .help(
                        "leave it out; to draw it more often, give weights: `choose x in { a, b } by [2, 1]`",
                    ),
                );
            }
        }
    }
}

/// Whether two items are the same, whatever the parameters are set to.
fn same(ruleset: &RuleSet, a: &Expr, b: &Expr) -> bool {
    let fixed = |e: &Expr| !e.any(&mut |e| matches!(e.kind, ExprKind::Param(_)));
    let value = |e: &Expr| evaluate(e, ruleset, &mut Vec::new()).ok();
    fixed(a) && fixed(b) && value(a).is_some_and(|a| Some(a) == value(b))
}
