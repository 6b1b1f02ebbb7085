//! Growth without an end: parts are attached for ever, nothing takes any away, and
//! no requirement says how many are enough.

use crate::bounds::linear::contradictory;
use crate::bounds::{Abstract, Facts, Reasoning, conjuncts, made_by, narrowed_locals_of};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind, Operator, Rule, RuleSet, Word};

use super::counts::Counts;
use super::places::conditions;

/// More parts than any body has.
const ENDLESS: f64 = 1e6;

pub(super) fn check(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    let shrinks = |e: &Effect| matches!(e, Effect::Remove(_) | Effect::Revert(_) | Effect::Replace { .. });
    if ruleset.rules.iter().flat_map(|r| &r.effects).any(shrinks) || bounded(ruleset) {
        return;
    }
    // Growth has no end where parts hold parts of kinds that hold them in turn.
    let facts = Facts::new(ruleset);
    let steps: Vec<Growth<'_>> = ruleset.rules.iter().flat_map(|rule| growth(&facts, rule)).collect();
    if let Some(endless) = steps.iter().find(|step| comes_back(&steps, step)) {
        findings.push(
            Diagnostic::new(Code::ENDLESS, endless.rule.span, "designs of this grammar grow without an end")
                .label("this rule can be applied for ever")
                .help(
                    "add a requirement such as `require count(part) <= 20`, or a rule that takes steps back",
                ),
        );
    }
}

/// Whether requirements bound the number of parts, or may do so in a way that is not followed here.
fn bounded(ruleset: &RuleSet) -> bool {
    let mut counts = Counts::new(ruleset);
    let mut rows = Vec::new();
    for condition in ruleset.requirements.iter().flat_map(|r| conjuncts(&r.condition)) {
        let said = counts.rows(condition);
        let geometry = matches!(condition.kind, ExprKind::Word(Word::Connected | Word::NoOverlap));
        if said.is_empty() && !geometry {
            return true;
        }
        rows.extend(said);
    }
    rows.extend(counts.base());
    rows.push(counts.parts_at_least(ENDLESS));
    !counts.only_counts() || contradictory(&rows)
}

/// What a rule attaches, and to what.
struct Growth<'r> {
    rule: &'r Rule,
    holders: Vec<String>,
    made: Vec<String>,
}

fn growth<'r>(facts: &Facts<'r>, rule: &'r Rule) -> Vec<Growth<'r>> {
    let simple = conditions(rule).flat_map(conjuncts).all(asks_only_what);
    let always = matches!(rule.weight.kind, ExprKind::Number(x) if x > 0.0);
    if !simple || !always {
        // It may stop by itself.
        return Vec::new();
    }
    let locals = narrowed_locals_of(facts, rule);
    let attach = |effect: &Effect| match effect {
        Effect::Attach { on, .. } => match Reasoning::new(facts, locals.clone()).value(&on.port) {
            Abstract::Port(holders) => Some(Growth { rule, holders, made: made_by(facts, rule, effect) }),
            _ => None,
        },
        _ => None,
    };
    rule.effects.iter().filter_map(attach).collect()
}

/// Whether a condition asks only what kind of part or port something is.
fn asks_only_what(condition: &Expr) -> bool {
    matches!(&condition.kind, ExprKind::Binary(_, Operator::Is | Operator::IsNot, b)
        if matches!(b.kind, ExprKind::Group(_)))
}

/// Whether what a step makes can, after more steps, hold what the step makes again.
fn comes_back(steps: &[Growth<'_>], start: &Growth<'_>) -> bool {
    let mut reached = start.made.clone();
    let mut next = 0;
    while let Some(kind) = reached.get(next).cloned() {
        next += 1;
        if start.holders.contains(&kind) {
            return true;
        }
        for step in steps.iter().filter(|s| s.holders.contains(&kind)) {
            for made in &step.made {
                if !reached.contains(made) {
                    reached.push(made.clone());
                }
            }
        }
    }
    false
}
