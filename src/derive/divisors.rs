//! Objectives that divide by what the design that a search starts from has none of.

use std::collections::BTreeSet;
use std::iter;

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::{Value, evaluate};
use grammar_lang::ir::{Expr, ExprKind, Operator, RuleSet};
use grammar_lang::source::Span;

use super::{Derivation, DesignScope};

/// An error for each quotient of an objective, and of the terms that it reads, whose divisor is zero for this design: a
/// search that starts from it ends at once.
pub(super) fn check(rules: &RuleSet, start: &Derivation) -> Vec<Diagnostic> {
    let scope = DesignScope::new(rules, start);
    let mut walk = Walk { rules, scope, terms: BTreeSet::new(), zeros: BTreeSet::new() };
    let tasks = rules.tasks.values().flat_map(|task| iter::once(&task.objective).chain(&task.beside));
    for objective in iter::once(&rules.objective).chain(&rules.beside).chain(tasks) {
        walk.visit(&objective.value);
    }
    let told = |span| {
        let message = "the objective has no value for the design that the search starts from";
        Diagnostic::new(Code::NO_VALUE, span, message)
            .label("this is zero there")
            .help("start from a design for which it is not zero, or write `max(1, ...)`")
    };
    walk.zeros.into_iter().map(told).collect()
}

struct Walk<'r> {
    rules: &'r RuleSet,
    scope: DesignScope<'r>,
    /// Terms that have been visited.
    terms: BTreeSet<&'r str>,
    /// Divisors that are zero.
    zeros: BTreeSet<Span>,
}

impl<'r> Walk<'r> {
    fn visit(&mut self, expr: &'r Expr) {
        match &expr.kind {
            // A condition may keep the zero away.
            ExprKind::If(..) => return,
            ExprKind::Term(name) => {
                if let Some((name, term)) = self.rules.terms.get_key_value(name)
                    && self.terms.insert(name)
                {
                    self.visit(&term.value);
                }
            }
            ExprKind::Binary(_, Operator::Divide, divisor)
                // What reads the motion has no value here, and is left alone.
                if evaluate(divisor, &self.scope, &mut Vec::new()) == Ok(Value::Number(0.0)) =>
            {
                self.zeros.insert(divisor.span);
            }
            _ => {}
        }
        expr.each(&mut |inner| self.visit(inner));
    }
}
