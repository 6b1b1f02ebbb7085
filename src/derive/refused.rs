//! Rules that the initial design refuses for ever: their images take each other's ports, or have no
//! place at all.

use std::collections::BTreeSet;

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::ir::{Effect, Expr, ExprKind, Group, Matched, Rule, RuleSet, Spread};

use super::{Blocked, Derivation, Extent, Stream};
use crate::design::Refusal;

/// How many applications of a rule are tried at most.
const MOST: usize = 1000;

/// Reports the rules that can only be applied to what `begin` places, and never can.
pub(super) fn check(rules: &RuleSet, begun: &Derivation) -> Vec<Diagnostic> {
    // What is turned may fit later.
    if rules
        .rules
        .iter()
        .chain(&rules.always)
        .flat_map(|rule| Effect::single(&rule.effects))
        .any(|e| matches!(e, Effect::Set { .. }))
    {
        return Vec::new();
    }
    let made = made(rules);
    let bound = rules.rules.iter().filter(|rule| is_bound(rule, &made));
    bound.filter_map(|rule| report(rules, rule, &always(rules, rule, begun)?)).collect()
}

/// The kinds that rules make.
fn made(rules: &RuleSet) -> BTreeSet<String> {
    let mut made = BTreeSet::new();
    for expr in rules.rules.iter().flat_map(exprs) {
        expr.any(&mut |e| {
            if let ExprKind::Kind(name, _) = &e.kind {
                made.insert(name.clone());
            }
            false
        });
    }
    made
}

/// What a rule asks, chooses from and does; its weight is no matter.
fn exprs(rule: &Rule) -> impl Iterator<Item = &Expr> {
    let conditions = rule.matches.iter().filter_map(|m| m.condition.as_ref());
    let guards = rule.guards.iter().map(|g| &g.condition);
    let domains = rule.choices.iter().map(|c| &c.domain);
    let effects = rule.effects.iter().flat_map(Effect::exprs);
    conditions.chain(guards).chain(domains).chain(effects)
}

/// Whether what a rule can do is the same whatever other rules have done: it attaches to what `begin`
/// places, and reads nothing else of the design.
fn is_bound(rule: &Rule, made: &BTreeSet<String>) -> bool {
    let attaches = Effect::single(&rule.effects).all(|e| matches!(e, Effect::Attach { .. }));
    let placed = rule.matches.iter().all(|m| match &m.what {
        Matched::Part { kind: Group::Kind(kind), joined_to: None, .. } => !made.contains(kind.as_str()),
        Matched::Port { of } => of.is_some(),
        _ => false,
    });
    let reads = |e: &Expr| {
        matches!(
            e.kind,
            ExprKind::Group(_) | ExprKind::Aggregate { .. } | ExprKind::Attribute(..) | ExprKind::Word(_)
        )
    };
    attaches && placed && !rule.effects.is_empty() && !exprs(rule).any(|expr| expr.any(&mut |e| reads(e)))
}

/// Why each application of a rule is refused, if each is, and for the same reason.
fn always(rules: &RuleSet, rule: &Rule, begun: &Derivation) -> Option<Refusal> {
    if rule.choices.iter().any(|c| !matches!(c.spread, Spread::Even | Spread::Fixed)) {
        return None;
    }
    let mut random = Stream::named(0, "refused");
    let all = begun.applications(rules, rule, 0.0, Extent { most: MOST, hints: &[] }, &mut random).ok()?;
    if all.sampled {
        return None;
    }
    let mut reason = None;
    for locals in &all.all {
        match begun.apply(rules, rule, locals) {
            Err(Blocked::Refused(
                why @ (Refusal::PortTaken { .. }
                | Refusal::Asymmetric(_)
                | Refusal::NoImage { .. }
                | Refusal::Askew(_)),
            )) if reason.as_ref().is_none_or(|known| *known == why) => {
                reason = Some(why);
            }
            _ => return None,
        }
    }
    reason
}

fn report(rules: &RuleSet, rule: &Rule, why: &Refusal) -> Option<Diagnostic> {
    let help = match why {
        Refusal::PortTaken { .. } => {
            "a part is attached there already, or the symmetry attaches one: attach only one part, and the symmetry makes its images"
        }
        Refusal::Asymmetric(_) => {
            "on the axis or mirror plane, attach only parts that are their own images (such as a round actuator that twists, spins or slides along the axis)"
        }
        Refusal::Askew(_) => {
            "turn it by 0 deg or 180 deg; to bend across the plane, give it another axis instead: \
             `bender(direction = 90 deg)`, or `joint = bend about y` in an actuator of your own"
        }
        Refusal::NoImage { .. } => {
            "the symmetry must map each port to a port (`radial 4` does not map five ports around an axis to each other)"
        }
        _ => return None,
    };
    Some(
        Diagnostic::new(Code::NO_ROOM, rule.span, format!("the rule `{}` is always refused", rule.name))
            .label(Blocked::Refused(why.clone()).sentence(rules))
            .help(help),
    )
}
