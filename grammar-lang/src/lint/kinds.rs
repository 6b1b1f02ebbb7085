//! Which kinds of parts a rule set can ever make.

use crate::ir::{self, ExprKind, Group, RuleSet};

/// The kinds of parts that can ever be in a design.
pub(super) fn possible_kinds(ruleset: &RuleSet) -> Vec<String> {
    let mut kinds: Vec<String> = ruleset.begin.iter().map(|p| p.kind.clone()).collect();
    for rule in &ruleset.rules {
        for effect in &rule.effects {
            let ir::Effect::Attach { what, .. } = effect else { continue };
            for expr in rule.choices.iter().map(|c| &c.domain).chain([what]) {
                expr.any(&mut |e| {
                    if let ExprKind::Kind(name, _) = &e.kind
                        && !kinds.contains(name)
                    {
                        kinds.push(name.clone());
                    }
                    false
                });
            }
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
