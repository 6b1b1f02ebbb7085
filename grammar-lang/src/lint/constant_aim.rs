//! An objective that is the same for every design and every motion.

use std::collections::BTreeSet;

use crate::bounds::Reasoning;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Expr, ExprKind, MotionWord, RuleSet, Word};
use crate::units::shown;

use super::known::Known;
use super::over_nothing::facts_of;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    constant_rewards(ruleset, findings);
    let of_tasks = ruleset.tasks.values().map(|task| (&task.objective, facts_of(known, task)));
    let of_all = ruleset.objectives().map(|objective| (objective, known.facts.clone()));
    for (objective, facts) in of_tasks.chain(of_all) {
        if findings.iter().any(|d| d.span() == objective.value.span) {
            continue;
        }
        let value = Reasoning::new(&facts, Vec::new()).numbers(&objective.value).single();
        if let ExprKind::If(_, a, b) = &objective.quantity().kind
            && [a, b].iter().all(|branch| known.numbers(branch).single().is_some())
        {
            findings.push(
                Diagnostic::new(
                    Code::CONSTANT_AIM,
                    objective.value.span,
                    "this objective has only two values",
                )
                .label("there are no values between them to guide a search")
                .help("use a quantity with many possible values, as in `maximize travel in cm`"),
            );
            continue;
        }
        if only_the_start(ruleset, &objective.value) {
            findings.push(
                Diagnostic::new(
                    Code::CONSTANT_AIM,
                    objective.value.span,
                    "this objective reads only the start of the motion",
                )
                .label("it has the same value for every motion")
                .help("read what changes, such as `e.position at end`"),
            );
            continue;
        }
        let Some(value) = value else { continue };
        let dimension = objective.value.ty.dimension().unwrap_or_default();
        findings.push(
            Diagnostic::new(Code::CONSTANT_AIM, objective.value.span, "every design has the same value")
                .label(format!("always {}", shown(value, dimension)))
                .help("let the objective read the motion or the design, as in `maximize travel in cm`"),
        );
    }
}

/// Rewards that are the same whatever a policy decides.
fn constant_rewards(ruleset: &RuleSet, findings: &mut Vec<Diagnostic>) {
    for policy in ruleset.policies.values() {
        let Some(reward) = &policy.reward else { continue };
        let is_now =
            |e: &Expr| matches!(&e.kind, ExprKind::At(_, time) if time.kind == ExprKind::Word(Word::Now));
        if !reward.any(&mut |e| is_now(e)) {
            findings.push(
                Diagnostic::new(
                    Code::CONSTANT_AIM,
                    reward.span,
                    "this reward does not depend on the decisions",
                )
                .label("it has the same value for every decision")
                .help("read the present, as in `(first(elements).velocity at now).x / (5 cm/s)`"),
            );
        }
    }
}

/// Whether what an objective reads of the motion, it reads at its start.
fn only_the_start(ruleset: &RuleSet, objective: &Expr) -> bool {
    let (mut begins, mut moves) = (false, false);
    let mut seen = BTreeSet::new();
    let mut open = vec![objective];
    while let Some(expr) = open.pop() {
        match &expr.kind {
            ExprKind::At(_, time) if time.kind == ExprKind::Word(Word::Motion(MotionWord::Start)) => {
                begins = true;
                continue;
            }
            ExprKind::At(..) | ExprKind::Task(_) | ExprKind::Shared(..) => moves = true,
            ExprKind::Word(Word::Motion(MotionWord::Period)) => moves = true,
            // What an element is, it is at all times.
            ExprKind::Attribute(_, attribute) => {
                let stays = matches!(attribute.text(), "part" | "cell" | "size");
                moves |= attribute.is_of_motion() && !stays && !matches!(attribute, Attribute::Track(_));
            }
            ExprKind::Term(name) if seen.insert(name) => {
                open.extend(ruleset.terms.get(name).map(|term| &term.value));
            }
            _ => {}
        }
        expr.each(&mut |inner| open.push(inner));
    }
    begins && !moves
}
