//! A parameter that one choice of a kind is given, while another that has it keeps its default.

use indexmap::IndexMap;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, RuleSet};
use crate::source::Span;

use super::known::Known;
use super::places::places;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut all: IndexMap<Span, Diagnostic> = IndexMap::new();
    for place in places(known) {
        for expr in &place.exprs {
            expr.any(&mut |e| {
                if let Some(finding) = given_to_one(e, known.ruleset) {
                    all.entry(finding.span()).or_insert(finding);
                }
                false
            });
        }
    }
    findings.extend(all.into_values());
}

fn given_to_one(expr: &Expr, ruleset: &RuleSet) -> Option<Diagnostic> {
    let kinds = branches(expr);
    let bare = kinds.iter().filter(|(_, given, _)| given.is_empty());
    let given =
        kinds.iter().flat_map(|(to, given, place)| given.iter().map(move |(param, _)| (to, param, place)));
    let pairs = bare.flat_map(|bare| given.clone().map(move |given| (bare, given)));
    let ((kind, _, place), (to, param, there)) =
        pairs.into_iter().find(|((kind, ..), (_, param, _))| has(ruleset, kind, param))?;
    Some(
        Diagnostic::new(
            Code::GIVEN_TO_ONE_KIND,
            *place,
            format!("`{kind}` has a parameter `{param}`, too, but keeps its default here"),
        )
        .label(format!("no `{param}` is given"))
        .also(*there, format!("only `{to}` is given one"))
        .help(format!("write `{kind}({param} = ...)`, with its default value if you mean that: arguments apply only to the kind directly before them")),
    )
}

/// A kind, what it is given, and where it stands.
type Branch<'e> = (&'e str, &'e [(String, Expr)], Span);

/// The kinds that an `if` or a `match` decides between, with what each is given.
fn branches(expr: &Expr) -> Vec<Branch<'_>> {
    let mut next: Vec<&Expr> = match &expr.kind {
        ExprKind::If(_, then, otherwise) => vec![otherwise, then],
        _ => return Vec::new(),
    };
    let mut found = Vec::new();
    while let Some(branch) = next.pop() {
        match &branch.kind {
            ExprKind::If(_, then, otherwise) => next.extend([&**otherwise, &**then]),
            ExprKind::Kind(kind, given) => found.push((kind.as_str(), given.as_slice(), branch.span)),
            _ => {}
        }
    }
    found
}

fn has(ruleset: &RuleSet, kind: &str, param: &str) -> bool {
    let part = ruleset.parts.get(kind).map(|part| &part.params);
    let params = part.or_else(|| ruleset.actuators.get(kind).map(|actuator| &actuator.params));
    params.is_some_and(|params| params.contains_key(param))
}
