//! Conditions of rules that hold whatever the design and the choices.

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{ExampleClause, Expr, ExprKind, Operator, without_spans};
use crate::source::Span;

use super::known::Known;
use super::places::conditions;

/// Whether both sides of a comparison are the same.
fn compares_with_itself(condition: &Expr) -> bool {
    use Operator as O;
    let ExprKind::Binary(a, operator, b) = &condition.kind else { return false };
    matches!(operator, O::Equal | O::LessEqual | O::GreaterEqual)
        && without_spans(a).ok().is_some_and(|a| without_spans(b).ok() == Some(a))
}

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told = |place: Span, message: &str, label: &str, help: &str| {
        findings.push(Diagnostic::new(Code::POINTLESS, place, message).label(label).help(help));
    };
    for preference in &known.ruleset.preferences {
        if known.numbers(&preference.weight).single() == Some(0.0) {
            told(
                preference.weight.span,
                "a preference without weight changes no value",
                "always zero",
                "write how much the objective loses where it does not hold, such as `weight 5`",
            );
        }
    }
    for example in known.ruleset.examples.values() {
        for clause in &example.clauses {
            if let ExampleClause::Expect(condition) = clause
                && (known.reasoning(&[]).truth(condition) == Truth::Always || compares_with_itself(condition))
            {
                told(
                    condition.span,
                    "this expectation holds whatever the steps do",
                    "holds for every design",
                    "expect what only these steps lead to, as in `expect count(part) == 5`",
                );
            }
        }
    }
    for (rule, locals) in known.rules() {
        let mut reasoning = known.reasoning(&locals.all);
        for condition in conditions(rule) {
            if reasoning.truth(condition) == Truth::Always {
                findings.push(
                    Diagnostic::new(
                        Code::POINTLESS,
                        condition.span,
                        format!("this condition of the rule `{}` excludes nothing", rule.name),
                    )
                    .label("holds for every design and every choice")
                    .help("remove the condition, or change it so that it excludes something"),
                );
            }
        }
    }
}
