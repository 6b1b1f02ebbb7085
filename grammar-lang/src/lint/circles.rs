//! Terms and patterns that are defined by themselves, or build on too many others.

use std::collections::BTreeMap;

use indexmap::IndexMap;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, RuleSet};

/// How many may build on each other, and how many pieces one may have when
/// all that it builds on is written out: evaluation takes as long.
const DEEPEST: usize = 100;
const LARGEST: usize = 100_000;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let terms: IndexMap<&str, &Expr> = ruleset.terms.iter().map(|(n, t)| (n.as_str(), &t.value)).collect();
    let patterns: IndexMap<&str, &Expr> = ruleset.patterns.iter().map(|(n, e)| (n.as_str(), e)).collect();
    for (what, all) in [("term", terms), ("pattern", patterns)] {
        let mut sizes = BTreeMap::new();
        for (name, expr) in &all {
            if let Err(reason) = measure(name, &all, &mut sizes, 0) {
                findings.push(
                    Diagnostic::new(Code::BAD_VALUE, expr.span, format!("the {what} `{name}` {reason}"))
                        .label(if reason.contains("itself") {
                            "uses itself, at once or through others"
                        } else {
                            "too much to work out"
                        })
                        .help(if reason.contains("itself") {
                            "nothing can use itself: give one of them a value of its own"
                        } else {
                            "build it on fewer others"
                        }),
                );
                return;
            }
        }
    }
}

/// The size of a named expression written out; `None` in `sizes` while it is being measured.
fn measure<'r>(
    name: &'r str,
    all: &IndexMap<&'r str, &'r Expr>,
    sizes: &mut BTreeMap<&'r str, Option<usize>>,
    depth: usize,
) -> Result<usize, &'static str> {
    match sizes.get(name) {
        Some(Some(size)) => return Ok(*size),
        Some(None) => return Err("is defined by itself"),
        None if depth > DEEPEST => return Err("builds on too many others"),
        None => {}
    }
    sizes.insert(name, None);
    let mut size = 0usize;
    let mut used: Vec<String> = Vec::new();
    if let Some(expr) = all.get(name) {
        expr.any(&mut |e| {
            size += 1;
            if let ExprKind::Term(other) | ExprKind::Pattern(other) = &e.kind {
                used.push(other.clone());
            }
            false
        });
    }
    for other in used {
        if let Some((other, _)) = all.get_key_value(other.as_str()) {
            size = size.saturating_add(measure(other, all, sizes, depth + 1)?);
        }
    }
    if size > LARGEST {
        return Err("is too large when all that it builds on is written out");
    }
    sizes.insert(name, Some(size));
    Ok(size)
}
