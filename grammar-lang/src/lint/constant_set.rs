//! Values that rules set from what they choose, and that are the same whatever is chosen.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind};
use crate::units::shown;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (rule, locals) in known.rules() {
        // What is chosen comes after what is matched.
        let first: usize = rule.matches.iter().map(crate::ir::Match::slots).sum();
        let chosen = first..first + rule.choices.len();
        let reads = |value: &Expr| {
            value.any(&mut |e| matches!(e.kind, ExprKind::Local(slot) if chosen.contains(&slot)))
        };
        for effect in Effect::single(&rule.effects) {
            let (Effect::Set { value, .. } | Effect::SetOfBody { value, .. }) = effect else { continue };
            let mut reasoning = known.reasoning(&locals.all);
            // A choice of one value is told as such.
            let is_choice = matches!(value.kind, ExprKind::Local(_));
            if let Some(always) = reasoning.numbers(value).single().filter(|_| !is_choice && reads(value)) {
                findings.push(
                    Diagnostic::new(
                        Code::POINTLESS,
                        value.span,
                        format!("the rule `{}` always sets the same value", rule.name),
                    )
                    .label(format!(
                        "{} whatever is chosen",
                        shown(always, value.ty.dimension().unwrap_or_default())
                    ))
                    .help("is `min` meant where `max` is written, or the other way round?"),
                );
            }
        }
    }
}
