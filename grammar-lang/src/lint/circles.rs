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
        for name in all.keys() {
            let Err(trouble) = measure(name, &all, &mut sizes, &mut Vec::new()) else { continue };
            findings.extend(report(what, name, &all, &trouble));
            return;
        }
    }
}

/// What is wrong with a named expression.
enum Trouble<'r> {
    /// These build on each other in a circle.
    Circle(Vec<&'r str>),
    /// It builds on too many others.
    Deep,
    /// It is too large when all that it builds on is written out.
    Large,
}

fn report(what: &str, name: &str, all: &IndexMap<&str, &Expr>, trouble: &Trouble<'_>) -> Option<Diagnostic> {
    let place = |name: &str| all.get(name).map(|expr| expr.span);
    let finding = |name: &str, reason: &str, label: &str, help: &str| {
        Some(
            Diagnostic::new(Code::BAD_VALUE, place(name)?, format!("the {what} `{name}` {reason}"))
                .label(label)
                .help(help),
        )
    };
    let (label, help) = ("too much to compute", "let it use fewer other definitions");
    match trouble {
        Trouble::Deep => finding(name, "builds on too many others", label, help),
        Trouble::Large => finding(name, "is too large when everything that it uses is expanded", label, help),
        Trouble::Circle(ring) => {
            let (first, others) = ring.split_first()?;
            let label = if others.is_empty() { "uses itself" } else { "uses itself indirectly" };
            let help = "a definition cannot use itself: give one of them a value of its own";
            let circle = finding(first, "is defined in terms of itself", label, help)?;
            let through = others.iter().filter_map(|name| place(name));
            Some(through.fold(circle, |circle, place| circle.also(place, "through this")))
        }
    }
}

/// The size of a named expression written out; `None` in `sizes` while it is being measured, as all
/// those are that are `open`.
fn measure<'r>(
    name: &'r str,
    all: &IndexMap<&'r str, &'r Expr>,
    sizes: &mut BTreeMap<&'r str, Option<usize>>,
    open: &mut Vec<&'r str>,
) -> Result<usize, Trouble<'r>> {
    match sizes.get(name) {
        Some(Some(size)) => return Ok(*size),
        Some(None) => {
            let begins = open.iter().position(|other| *other == name).unwrap_or(0);
            return Err(Trouble::Circle(open.split_off(begins)));
        }
        None if open.len() > DEEPEST => return Err(Trouble::Deep),
        None => {}
    }
    sizes.insert(name, None);
    open.push(name);
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
            size = size.saturating_add(measure(other, all, sizes, open)?);
        }
    }
    if size > LARGEST {
        return Err(Trouble::Large);
    }
    sizes.insert(name, Some(size));
    open.pop();
    Ok(size)
}
