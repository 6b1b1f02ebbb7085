//! No rule has a weight above zero.

use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::Expr;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    // What the parameters are set to counts here: this search would do nothing.
    let none = |weight: &Expr| {
        let now = known.value(weight);
        matches!(now, Ok(Value::Number(x)) if x <= 0.0) || known.numbers(weight).high <= 0.0
    };
    if let Some(first) = ruleset.rules.first()
        && ruleset.rules.iter().all(|rule| none(&rule.weight))
        // A weight that is always negative is an error of its own.
        && ruleset.rules.iter().any(|rule| known.numbers(&rule.weight).high >= 0.0)
    {
        let mut finding = Diagnostic::new(Code::NOTHING_DRAWN, first.weight.span, "no rule is ever drawn")
            .label("never above zero")
            .help("give at least one rule a weight above zero");
        for rule in ruleset.rules.iter().skip(1) {
            finding = finding.also(rule.weight.span, "never above zero");
        }
        findings.push(finding);
    }
}
