//! Policies of two sides that know what changes its sign in the mirror as if it did not.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Function};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for policy in known.ruleset.policies.values().filter(|policy| policy.mirrored.is_some()) {
        let turns = |input: &&Expr| input.any(&mut |e| is_heading(known, e));
        let even = |input: &Expr| {
            input.any(&mut |e| matches!(e.kind, ExprKind::Call(Function::Cos | Function::Abs, _)))
        };
        let wrong = policy.inputs.iter().find(|input| turns(input) && !even(input));
        findings.extend(wrong.map(|input| {
            Diagnostic::new(Code::UNUSUAL, input.span, "a heading changes its sign in the mirror")
                .label("here both sides know it alike")
                .help("move it from `inputs` to `mirrored`")
        }));
    }
}

/// Whether it is a heading, or a sensor of one.
fn is_heading(known: &Known<'_>, e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Call(Function::Heading, _) => true,
        ExprKind::Sensor(name, _) => known.ruleset.sensors.get(name).is_some_and(|sensor| {
            sensor.value.any(&mut |e| matches!(e.kind, ExprKind::Call(Function::Heading, _)))
        }),
        _ => false,
    }
}
