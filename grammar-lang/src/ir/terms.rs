//! What expressions build on.

use std::collections::BTreeSet;

use indexmap::IndexMap;

use super::{Expr, ExprKind, Term};

/// An expression, and then the terms that it builds on with their names, each once.
pub fn builds_on<'r>(
    expr: &'r Expr,
    terms: &'r IndexMap<String, Term>,
) -> impl Iterator<Item = (Option<&'r str>, &'r Expr)> {
    let mut known: BTreeSet<&str> = BTreeSet::new();
    let mut all = vec![(None, expr)];
    let mut next = 0;
    while let Some((_, expr)) = all.get(next).copied() {
        next += 1;
        expr.any(&mut |e| {
            if let ExprKind::Term(name) = &e.kind
                && let Some((name, term)) = terms.get_key_value(name)
                && known.insert(name)
            {
                all.push((Some(name.as_str()), &term.value));
            }
            false
        });
    }
    all.into_iter()
}
