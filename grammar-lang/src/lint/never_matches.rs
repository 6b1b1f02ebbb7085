//! A rule that matches a kind of part that nothing ever adds, or that undoes
//! steps although no step adds anything.

use super::kinds::{can_hold, possible_kinds};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, ExprKind, Group, Operator, Pattern, RuleSet};

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let kinds = possible_kinds(ruleset);
    let grows = ruleset.rules.iter().any(|r| r.effects.iter().any(|e| matches!(e, Effect::Attach { .. })));
    let name = |group: &Group| match group {
        Group::Part => "part".to_owned(),
        Group::Block => "block".to_owned(),
        Group::Actuator => "actuator".to_owned(),
        Group::Kind(kind) => kind.clone(),
    };
    for rule in &ruleset.rules {
        let reason = match &rule.pattern {
            Pattern::Nothing => None,
            Pattern::Part { kind, condition, .. } => {
                if can_hold(kind, &kinds, ruleset) {
                    condition.as_ref().and_then(|c| {
                        // `where p is KIND`, alone or joined by `and`.
                        let mut impossible = None;
                        let mut open = vec![c];
                        while let Some(e) = open.pop() {
                            match &e.kind {
                                ExprKind::Binary(a, Operator::And, b) => open.extend([&**a, &**b]),
                                ExprKind::Binary(a, Operator::Is, b) => {
                                    if let (ExprKind::Local(0), ExprKind::Group(group)) = (&a.kind, &b.kind)
                                        && !can_hold(group, &kinds, ruleset)
                                    {
                                        impossible = Some(name(group));
                                    }
                                }
                                _ => {}
                            }
                        }
                        impossible
                    })
                } else {
                    Some(name(kind))
                }
                .map(|kind| format!("no design ever has a `{kind}`"))
            }
            Pattern::Step { .. } => (!grows).then(|| "no rule ever adds a part".to_owned()),
        };
        if let Some(reason) = reason {
            findings.push(
                Diagnostic::new(
                    Code::NEVER_MATCHES,
                    rule.span,
                    format!("the rule `{}` can never match", rule.name),
                )
                .label(reason)
                .help("add a rule that attaches such a part, or remove this rule"),
            );
        }
    }
}
