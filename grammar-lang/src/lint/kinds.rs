//! Which kinds of parts a rule set can ever make.

use crate::ir::{Effect, Expr, ExprKind, Group, RuleSet};

/// The kinds of parts that can ever be in a design.
pub(super) fn possible_kinds(ruleset: &RuleSet) -> Vec<String> {
    let mut kinds: Vec<String> = Vec::new();
    let mut gather = |expr: &Expr| {
        expr.any(&mut |e| {
            if let ExprKind::Kind(name, _) = &e.kind
                && !kinds.contains(name)
            {
                kinds.push(name.clone());
            }
            false
        });
    };
    ruleset.begin.iter().for_each(|p| gather(&p.what));
    for rule in &ruleset.rules {
        let makes = |e: &&Effect| matches!(e, Effect::Attach { .. } | Effect::Replace { .. });
        for effect in rule.effects.iter().filter(makes) {
            if let Effect::Attach { what, .. } | Effect::Replace { with: what, .. } = effect {
                gather(what);
            }
            rule.choices.iter().for_each(|c| gather(&c.domain));
        }
    }
    kinds
}

/// Whether a group can have a part of one of these kinds.
pub(super) fn can_hold(group: &Group, kinds: &[String], ruleset: &RuleSet) -> bool {
    kinds.iter().any(|kind| match group {
        Group::Part => true,
        Group::Block => !ruleset.is_actuator(kind),
        Group::Actuator => ruleset.is_actuator(kind),
        Group::Kind(name) => name == kind,
    })
}
