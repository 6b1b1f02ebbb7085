//! Requirements that leave no room for what rules attach: for no part more than the initial design
//! has, or for none of a kind.

use crate::bounds::Repeated;
use crate::bounds::linear::Row;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Group, Requirement, Rule};

use super::clash::{listed, one};
use super::counts::Counts;
use super::known::{Known, Locals};

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // A lattice is bounded, and begins with cells of the one kind that it has.
    if known.ruleset.lattice.is_some() {
        return;
    }
    let ruleset = known.ruleset;
    let attaches = |e: &Effect| matches!(e, Effect::Attach { .. });
    let attaching: Vec<(&Rule, &Locals)> =
        known.rules().filter(|(rule, _)| Effect::single(&rule.effects).any(attaches)).collect();
    let Some((first, _)) = attaching.first() else { return };
    let mut counts = Counts::new(known);
    let all: Vec<(&Requirement, Vec<Row>)> =
        ruleset.requirements.iter().map(|r| (r, counts.rows(&r.condition))).collect();
    let mut base = counts.base().to_vec();
    base.extend(counts.begun());
    // The initial design stays: what is attached comes on top of it.
    base.push(counts.parts_at_least(known.facts.placed(&Group::Part) as f64 + 1.0));
    if let Some(stops) = one(&base, &all) {
        let (what, label) = ("anything but the initial design", "no larger design fulfils this");
        findings.extend(report(&stops, first, what, label));
        return;
    }
    let full = counts.full(all.iter().map(|(_, rows)| rows.as_slice()));
    if full.is_empty() {
        return;
    }
    for (rule, locals) in attaching {
        let mut attached = Vec::new();
        known.reasoning(&locals.narrowed).through_effects(
            &rule.effects,
            Repeated::Together,
            &mut |reasoning, effect| {
                attached.extend(reasoning.made_by(effect).filter(|_| attaches(effect)));
            },
        );
        let vain = attached.iter().find_map(|made| {
            let kinds = known.facts.names(made);
            let stops = kinds.iter().all(|kind| full.contains_key(kind));
            let (kind, number) = full.get_key_value(*kinds.first().filter(|_| stops)?)?;
            Some((*kind, all.get(*number)?.0))
        });
        if let Some((kind, requirement)) = vain {
            let what = format!("one more `{kind}` than the initial design has");
            findings.extend(report(&[requirement], rule, &what, "no design with one more can fulfil this"));
        }
    }
}

fn report(stops: &[&Requirement], rule: &Rule, what: &str, label: &str) -> Option<Diagnostic> {
    let first = stops.first()?;
    let verb = if stops.len() == 1 { "leaves" } else { "leave" };
    let mut finding = Diagnostic::new(
        Code::NO_ROOM,
        first.condition.span,
        format!("{} {verb} no room for {what}", listed(stops)),
    )
    .label(label)
    .help("relax the requirement, or remove the rules that attach parts");
    for other in stops.iter().skip(1) {
        finding = finding.also(other.condition.span, "together with this");
    }
    Some(finding.also(rule.span, "this rule can never attach parts"))
}
