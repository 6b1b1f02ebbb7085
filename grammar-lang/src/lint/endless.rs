//! Growth without an end: parts are attached for ever, nothing takes any away, and
//! no requirement says how many are enough.

use indexmap::IndexMap;

use crate::bounds::linear::{Row, contradictory};
use crate::bounds::{Abstract, Kinds, Repeated, conjuncts};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{DesignWord, Effect, Expr, ExprKind, Group, Operator, Rule, Word};

use super::counts::Counts;
use super::cycles::on_cycles;
use super::known::{Known, Locals, groups_of};
use super::places::conditions;

/// More parts than any body has.
const ENDLESS: f64 = 1e6;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    // A lattice is bounded, and begins with cells of the one kind that it has.
    if known.ruleset.lattice.is_some() {
        return;
    }
    let ruleset = known.ruleset;
    let shrinks = |e: &Effect| matches!(e, Effect::Remove(_) | Effect::Revert(_) | Effect::Replace { .. });
    if ruleset.rules.iter().flat_map(|r| Effect::single(&r.effects)).any(shrinks) {
        return;
    }
    let Some((counts, rows)) = said(known) else { return };
    let many = [counts.parts_at_least(ENDLESS)];
    if contradictory(&[rows.as_slice(), &many].concat()) {
        return;
    }
    // Growth has no end where parts hold parts of kinds that hold them in turn.
    let mut steps: Vec<Growth<'_>> =
        known.rules().flat_map(|(rule, locals)| growth(known, rule, locals)).collect();
    let bounded = counts.bounded(&rows);
    steps.retain(|step| match (step.made.groups().next(), step.made.groups().count()) {
        // Most rules make parts of one kind.
        (Some(Group::Kind(kind)), 1) => !bounded.contains(kind.as_str()),
        _ => true,
    });
    if let Some(endless) = coming_back(known, &steps).and_then(|step| steps.get(step)) {
        findings.push(
            Diagnostic::new(Code::ENDLESS, endless.rule.span, "designs of this grammar grow without limit")
                .label("this rule can be applied for ever")
                .help("add a requirement such as `require count(part) <= 20`, or a rule that reverts steps"),
        );
    }
}

/// What requirements say of how many parts there are; nothing if they may say it in a way that is
/// not followed here.
fn said<'k, 'r>(known: &'k Known<'r>) -> Option<(Counts<'k, 'r>, Vec<Row>)> {
    let mut counts = Counts::new(known);
    let mut rows = Vec::new();
    for condition in known.ruleset.requirements.iter().flat_map(|r| conjuncts(&r.condition)) {
        let said = counts.rows(condition);
        let geometry = matches!(
            condition.kind,
            ExprKind::Word(Word::Design(DesignWord::Connected | DesignWord::NoOverlap))
        );
        if said.is_empty() && !geometry {
            return None;
        }
        rows.extend(said);
    }
    rows.extend_from_slice(counts.base());
    counts.only_counts().then_some((counts, rows))
}

/// What a rule attaches, and to what.
struct Growth<'r> {
    rule: &'r Rule,
    holders: Kinds,
    made: Kinds,
}

fn growth<'r>(known: &Known<'r>, rule: &'r Rule, locals: &Locals) -> Vec<Growth<'r>> {
    let simple = conditions(rule).flat_map(conjuncts).all(asks_only_what);
    let always = matches!(rule.weight.kind, ExprKind::Number(x) if x > 0.0);
    if !simple || !always {
        // It may stop by itself.
        return Vec::new();
    }
    let mut all = Vec::new();
    known.reasoning(&locals.narrowed).through_effects(
        &rule.effects,
        Repeated::Together,
        &mut |reasoning, effect| {
            if let Effect::Attach { on, .. } = effect
                && let Abstract::Port(holders) = reasoning.value(&on.port)
                && let Some(made) = reasoning.made_by(effect)
            {
                all.push(Growth { rule, holders, made });
            }
        },
    );
    all
}

/// Whether a condition asks only what kind of part or port something is.
fn asks_only_what(condition: &Expr) -> bool {
    matches!(&condition.kind, ExprKind::Binary(_, Operator::Is | Operator::IsNot, b)
        if matches!(b.kind, ExprKind::Group(_)))
}

/// The first step of which what it makes can, after more steps, hold what the step makes again.
fn coming_back(known: &Known<'_>, steps: &[Growth<'_>]) -> Option<usize> {
    let mut graph = Graph { ways: vec![Vec::new(); steps.len()], groups: IndexMap::new() };
    for (step, growth) in steps.iter().enumerate() {
        for group in growth.made.groups() {
            let made = graph.node(Side::Made, group);
            graph.lead(step, made);
        }
        for group in growth.holders.groups() {
            let holder = graph.node(Side::Holds, group);
            graph.lead(holder, step);
        }
    }
    // What is of a kind may hold whatever asks for one of its groups.
    for group in [Group::Part, Group::Block, Group::Actuator] {
        let made = graph.node(Side::Made, &group);
        let kinds = Kinds::of(group.clone());
        for kind in known.facts.names(&kinds) {
            let kind = graph.node(Side::Made, &Group::Kind(kind.to_owned()));
            graph.lead(made, kind);
        }
    }
    for kind in known.facts.names(&Kinds::all()) {
        let made = graph.node(Side::Made, &Group::Kind(kind.to_owned()));
        for group in groups_of(&known.facts, kind) {
            let holder = graph.node(Side::Holds, &group);
            graph.lead(made, holder);
        }
    }
    on_cycles(&graph.ways).into_iter().take(steps.len()).position(|comes_back| comes_back)
}

/// On which side of a step a part is.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Side {
    Made,
    Holds,
}

/// What leads to what: first the steps, then what they make and what holds that.
struct Graph {
    ways: Vec<Vec<usize>>,
    groups: IndexMap<(Side, Group), usize>,
}

impl Graph {
    fn node(&mut self, side: Side, group: &Group) -> usize {
        *self.groups.entry((side, group.clone())).or_insert_with(|| {
            self.ways.push(Vec::new());
            self.ways.len() - 1
        })
    }

    fn lead(&mut self, from: usize, to: usize) {
        if let Some(ways) = self.ways.get_mut(from) {
            ways.push(to);
        }
    }
}
