//! A rule that matches a kind of part that nothing ever adds, or that undoes
//! steps although no step adds anything.

use std::collections::BTreeSet;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind, Group, Matched, Operator};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let (ruleset, possible) = (known.ruleset, &known.possible);
    let grows =
        ruleset.rules.iter().any(|r| {
            Effect::single(&r.effects).any(|e| matches!(e, Effect::Attach { .. } | Effect::Cells(_)))
        }) || ruleset.begin.len() > 1;
    let name = |group: &Group| match group {
        Group::Part => "part".to_owned(),
        Group::Block => "block".to_owned(),
        Group::Actuator => "actuator".to_owned(),
        Group::Cell => "cell".to_owned(),
        Group::Kind(kind) => kind.clone(),
    };
    let never = |kind: &str| {
        let an = if kind.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
        format!("no design ever has {an} `{kind}`")
    };
    for rule in &ruleset.rules {
        let mut slot = 0;
        let mut reason = None;
        for matched in &rule.matches {
            let impossible = match &matched.what {
                Matched::Part { kind, .. } if !possible.contains(kind) => Some(never(&name(kind))),
                Matched::Part { .. } => matched
                    .condition
                    .as_ref()
                    .and_then(|c| impossible_kind(c, slot, possible))
                    .map(|group| never(&name(group))),
                Matched::Joint | Matched::Step if !grows => Some("no rule ever adds a part".to_owned()),
                _ => None,
            };
            slot += matched.slots();
            reason = reason.or(impossible);
        }
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

/// The kind that `where p is KIND` asks for, alone or joined by `and`, if no design ever has it.
fn impossible_kind<'r>(condition: &'r Expr, slot: usize, possible: &BTreeSet<Group>) -> Option<&'r Group> {
    let mut open = vec![condition];
    while let Some(e) = open.pop() {
        match &e.kind {
            ExprKind::Binary(a, Operator::And, b) => open.extend([&**a, &**b]),
            ExprKind::Binary(a, Operator::Is, b) => {
                if let (ExprKind::Local(local), ExprKind::Group(group)) = (&a.kind, &b.kind)
                    && *local == slot
                    && !possible.contains(group)
                {
                    return Some(group);
                }
            }
            _ => {}
        }
    }
    None
}
