//! Parameters of cells that an actuation reads, and that nothing ever gives another value than the default.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Effect, Expr, ExprKind, Settable};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    let Some(lattice) = &rules.lattice else { return };
    let of_rules = rules.rules.iter().chain(&rules.always).flat_map(|rule| Effect::single(&rule.effects));
    let effects: Vec<&Effect> = Effect::single(&lattice.begin).chain(of_rules).collect();
    let gives = |e: &Expr, wanted: &str| {
        let (ExprKind::Kind(_, given) | ExprKind::With(_, given)) = &e.kind else { return false };
        given.iter().any(|(name, _)| name == wanted)
    };
    let is_given = |wanted: &str| {
        effects.iter().any(|effect| {
            matches!(effect, Effect::Set { attribute: Settable::Param(name), .. } if name == wanted)
                || effect.exprs().into_iter().any(|expr| expr.any(&mut |e| gives(e, wanted)))
        })
    };
    for actuation in rules.actuations.values() {
        let mut told = Vec::new();
        for value in actuation.lets.iter().map(|(_, value)| value).chain([&actuation.drive]) {
            value.any(&mut |e| {
                if let ExprKind::Attribute(_, Attribute::Param(name)) = &e.kind
                    && lattice.cell.params.contains_key(name)
                    && !is_given(name)
                    && !told.contains(name)
                {
                    told.push(name.clone());
                    findings.push(
                        Diagnostic::new(
                            Code::POINTLESS,
                            e.span,
                            format!("nothing gives `{name}` of `{}` a value", lattice.kind),
                        )
                        .label("this is the default in every cell")
                        .help(format!(
                            "give it where cells are made: `fill ... with {}({name} = ...)`",
                            lattice.kind
                        )),
                    );
                }
                false
            });
        }
    }
}
