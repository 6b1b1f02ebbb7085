//! Repetitions that attach to one port again and again: from the second one on it is taken.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, _) in known.rules() {
        for effect in &rule.effects {
            repeated(effect, findings);
        }
    }
}

fn repeated(effect: &Effect, findings: &mut Vec<Diagnostic>) {
    let Effect::Repeat { over, effects, .. } = effect else { return };
    // What stands in a block takes slots from the first of what it runs over on.
    let Some(first) = over.iter().map(|binder| binder.slot).min() else { return };
    let is_once = over.iter().all(|binder| match &binder.over.kind {
        // A block after `if` runs over a range of one number, or of none.
        ExprKind::Range(low, high) => low.kind == high.kind || matches!(high.kind, ExprKind::If(..)),
        _ => false,
    });
    let is_range = over.iter().any(|binder| matches!(binder.over.kind, ExprKind::Range(..)));
    for effect in effects {
        repeated(effect, findings);
        let Effect::Attach { on, .. } = effect else { continue };
        let is_fixed = is_a_port(&on.port) || is_range && matches!(on.port.kind, ExprKind::Local(_));
        if !is_once && is_fixed && !reads(&on.port, first) {
            findings.push(
                Diagnostic::new(Code::POINTLESS, on.port.span, "each repetition attaches to the same port")
                    .label("the first repetition takes this port")
                    .help("let the port depend on what `for` runs over: `b.side[i]` in `for i in 0 .. 5`"),
            );
        }
    }
}

/// Whether it names a port of a part.
fn is_a_port(e: &Expr) -> bool {
    matches!(e.kind, ExprKind::Port(..))
}

/// Whether an expression reads a local from a slot on.
fn reads(e: &Expr, first: usize) -> bool {
    e.any(&mut |e| matches!(e.kind, ExprKind::Local(slot) if slot >= first))
}
